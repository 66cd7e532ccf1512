## prelude: the first text of every program.
## reads: lanes (1, 2, 4, 8, 16), real (double or float), weight (double, or what real is)
## gives: the lane types, the comparison and selection rules that hold for scalars and vectors alike
#pragma OPENCL FP_CONTRACT OFF
#pragma OPENCL EXTENSION cl_khr_fp64 : enable
#pragma OPENCL EXTENSION cl_khr_int64_base_atomics : enable

// Without always_inline PoCL silently does not vectorise what calls the function.
#define FN static inline __attribute__((always_inline))

// Lanes: one source for scalars and vectors, and for geometry in double or float.  With doubles a mask
// and a 64-bit integer are one C type, and so are `real` and `wide`; kernels keep them apart by these
// rules, and tests build every program with floats, where the compiler does.
//
//   types     real: lengths, directions (scalar: one lane of it); weight: what a ray carries, real or
//             wide (weight_scalar: one lane of it); mask: all ones or all zeros in each lane; lint,
//             luint: 64 bits; word: 32 bits; wide: double in every program, for exact sums of weights
//             and large counts
//   compare   reals LT LE GT GE EQ NE; what has 64 bits (lint, luint, wide) ILT ILE IGT IGE IEQ INE;
//             weights WEIGHT_LT WEIGHT_LE WEIGHT_GT WEIGHT_GE
//   select    reals SEL, weights SEL_WEIGHT, 64-bit integers SELI, words SELW, masks SELM
//   masks     ALL_LANES, NO_LANES, ALL_LANES_IF(a condition for all); & | ^ ~; ANY
//   mask to integer   INT_MASK(m), WORD_MASK(m): -1 or 0; a bit of it is INT_MASK(m) & 1L
//   integer to mask   MASK_OF(i), i all ones or all zeros in each lane
//   numbers   a constant or a table's number that meets a real: R(0.5) * x, x - R(row[ROW_X]); as an
//             argument of its own (fma, fmax, SEL, LT): splat(0.5), and lsplat, wsplat of integers;
//             with a weight WT(0.5), weight_splat(0.5)
//   rounding  UNIT_ROUNDOFF, and no power of two in its place
//   convert   by value TO_REAL, TO_WIDE, TO_WEIGHT (of a real), TO_LINT, TO_LUINT, TO_WORD; by bits
//             AS_LINT, AS_LUINT (of what has 64 bits), LOW_BITS (of a real, see there)
<%
    vector = "" if lanes == 1 else lanes
    mask = "long" if real == "double" else "int"
%>
typedef ${real} scalar;
typedef ${real}${vector} real;
typedef ${weight} weight_scalar;
typedef double${vector} wide;
typedef ${weight}${vector} weight;
typedef ${mask}${vector} mask;
typedef long${vector} lint;
typedef ulong${vector} luint;
typedef uint${vector} word;
#define AS_LINT(x) as_long${vector}(x)
#define AS_LUINT(x) as_ulong${vector}(x)
% if lanes == 1:
// A vector comparison gives all ones (-1) or all zeros in each lane, a scalar one 1 or 0.
#define COMPARED(c) (-(${mask})(c))
#define INTS_COMPARED(c) COMPARED(c)
#define ANY(m) ((m) != 0)
#define TO_REAL(x) ((${real})(x))
#define TO_WIDE(x) ((double)(x))
#define TO_WORD(x) ((uint)(x))
#define TO_LINT(x) ((long)(x))
#define TO_LUINT(x) ((ulong)(x))
#define WORD_MASK(m) (m)
#define INT_MASK(m) ((long)(m))
#define MASK_OF(i) ((${mask})(i))
% else:
#define COMPARED(c) (c)
#define ANY(m) (__builtin_reduce_or(m) != 0)
#define TO_REAL(x) __builtin_convertvector(x, real)
#define TO_WIDE(x) __builtin_convertvector(x, wide)
#define TO_WORD(x) __builtin_convertvector(x, word)
#define TO_LINT(x) __builtin_convertvector(x, lint)
#define TO_LUINT(x) __builtin_convertvector(x, luint)
#define WORD_MASK(m) __builtin_convertvector(m, int${lanes})
% if real == "double":
#define INTS_COMPARED(c) (c)
#define INT_MASK(m) (m)
#define MASK_OF(i) (i)
% else:
#define INTS_COMPARED(c) MASK_OF(c)
#define INT_MASK(m) __builtin_convertvector(m, lint)
#define MASK_OF(i) __builtin_convertvector(i, mask)
% endif
% endif
% for i, compared in (("", "COMPARED"), ("I", "INTS_COMPARED")):
#define ${i}LT(a, b) ${compared}((a) < (b))
#define ${i}LE(a, b) ${compared}((a) <= (b))
#define ${i}EQ(a, b) ${compared}((a) == (b))
#define ${i}NE(a, b) ${compared}((a) != (b))
#define ${i}GE(a, b) ${i}LE(b, a)
#define ${i}GT(a, b) ${i}LT(b, a)
% endfor
#define ALL_LANES msplat(-1L)
#define NO_LANES msplat(0L)
#define ALL_LANES_IF(c) msplat((c) ? -1L : 0L)
// m ? a : b in every lane; the OpenCL ternary does this for vectors (sign bit) and for scalars.
#define SEL(m, a, b) ((m) ? (a) : (b))
#define SELI(m, a, b) (INT_MASK(m) ? (a) : (b))
#define SELW(m, a, b) (WORD_MASK(m) ? (a) : (b))
#define SELM(m, a, b) ((m) ? (a) : (b))
% if weight == real:
#define SEL_WEIGHT(m, a, b) SEL(m, a, b)
#define TO_WEIGHT(x) (x)
% else:
#define SEL_WEIGHT(m, a, b) SELI(m, a, b)
#define TO_WEIGHT(x) TO_WIDE(x)
% endif
% for compared in ("LT", "LE", "GT", "GE"):
#define WEIGHT_${compared}(a, b) ${"" if weight == real else "I"}${compared}(a, b)
% endfor
#define LANES ${lanes}

// Has a cache line fetched; no more than a hint.  OpenCL's own prefetch() does nothing in PoCL.
#if defined(__x86_64__) || defined(__aarch64__)
#define FETCH(place) __builtin_prefetch((const void *)(size_t)(place), 0)
#define FETCH_TO_WRITE(place) __builtin_prefetch((const void *)(size_t)(place), 1)
#else
#define FETCH(place)
#define FETCH_TO_WRITE(place) ((void)*(volatile __global const long *)(place))
#endif

#define NO_FACE (-1L)
% if real == "double":
#define UNIT_ROUNDOFF 0x1p-53
// Added to a real it rounds that to an integer, which is then in the low bits.
#define TO_INTEGER 0x1.8p52
#define LOW_BITS(x) AS_LINT(x)
% else:
#define UNIT_ROUNDOFF 0x1p-24
#define TO_INTEGER 0x1.8p23
#define LOW_BITS(x) TO_LINT(as_int${vector}(x))
% endif

// Splat and lane access.
#define R(x) ((scalar)(x))
#define WT(x) ((weight_scalar)(x))
FN real splat(double x) { return (real)(x); }
% if weight == real:
#define weight_splat splat
% else:
FN weight weight_splat(double x) { return (weight)(x); }
% endif
FN mask msplat(${mask} x) { return (mask)(x); }
FN lint lsplat(long x) { return (lint)(x); }
FN word wsplat(uint x) { return (word)(x); }

// Gathers: lane l reads table[index_l].
<%
    gathers = [("double", "real", "gather"), ("long", "lint", "gather_long"), ("uint", "word", "gather_word")]
    if weight != real:
        gathers.append(("double", "weight", "gather_weight"))
%>
% if weight == real:
#define gather_weight gather
% endif
% for ctype, rtype, name in gathers:
FN ${rtype} ${name}(__global const ${ctype} *table, lint i) {
% if lanes == 1:
    return table[i];
% else:
    return (${rtype})(${", ".join(f"table[i.s{'0123456789abcdef'[l]}]" for l in range(lanes))});
% endif
}
% endfor

% if lanes == 1:
FN uint count_lanes(mask m) { return (uint)(-m); }
FN long sum_lanes(lint v) { return v; }
FN uint lane_bits(mask m) { return (uint)(-m); }
FN lint rank_lanes(mask m, uint *n) {
    *n = (uint)(-m);
    return 0;
}
% else:
// Written out, since clang 14 (PyPI's PoCL) has no builtin that adds up the lanes.
FN long sum_lanes(lint v) { return ${" + ".join(lane("v", l) for l in range(lanes))}; }
FN uint count_lanes(mask m) { return (uint)(-sum_lanes(INT_MASK(m))); }
// Bit l of the result is lane l of m.
FN uint lane_bits(mask m) {
    const mask bit = (mask)(${", ".join(str(1 << l) for l in range(lanes))});
    return (uint)__builtin_reduce_or(m & bit);
}
// 0, 1, 2, ... counted over the lanes set in m; *n is the number of lanes set.
FN lint rank_lanes(mask m, uint *n) {
    const lint one = -INT_MASK(m), zero = lsplat(0L);
    lint r = one;
<% step = 1 %>
% while step < lanes:
    r += __builtin_shufflevector(r, zero, ${", ".join(str(l - step) if l >= step else str(lanes) for l in range(lanes))});
<% step *= 2 %>
% endwhile
    *n = (uint)${lane("r", lanes - 1)};
    return r - one;
}
% endif
// The lowest lane set in bits, for loops over the lanes that a mask sets.
#define FIRST_LANE(bits) (31u - clz((bits) & (0u - (bits))))
