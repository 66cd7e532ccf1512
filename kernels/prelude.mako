## prelude: the first text of every program.
## reads: lanes (1, 2, 4, 8, 16), int64 (extension to enable)
## gives: the lane types, the comparison and selection rules that hold for scalars and vectors alike
#pragma OPENCL FP_CONTRACT OFF
#pragma OPENCL EXTENSION cl_khr_fp64 : enable
#pragma OPENCL EXTENSION cl_khr_int64_base_atomics : enable

// Without always_inline PoCL silently does not vectorise what calls the function.
#define FN static inline __attribute__((always_inline))

// Lanes: one source for scalars and vectors.  A mask is all ones (-1) or all zeros in each lane;
// a vector comparison gives that by itself, a scalar one gives 0 or 1 and is negated.
% if lanes == 1:
typedef double real;
typedef long lint;
typedef ulong luint;
typedef uint word;
#define LT(a, b) (-(long)((a) < (b)))
#define LE(a, b) (-(long)((a) <= (b)))
#define EQ(a, b) (-(long)((a) == (b)))
#define NE(a, b) (-(long)((a) != (b)))
#define ANY(m) ((m) != 0)
#define AS_LINT(x) as_long(x)
#define AS_LUINT(x) as_ulong(x)
#define AS_REAL(x) as_double(x)
#define TO_REAL(x) ((double)(x))
#define TO_WORD(x) ((uint)(x))
#define TO_LINT(x) ((long)(x))
#define TO_LUINT(x) ((ulong)(x))
#define WORD_MASK(m) (m)
% else:
typedef double${lanes} real;
typedef long${lanes} lint;
typedef ulong${lanes} luint;
typedef uint${lanes} word;
#define LT(a, b) ((a) < (b))
#define LE(a, b) ((a) <= (b))
#define EQ(a, b) ((a) == (b))
#define NE(a, b) ((a) != (b))
#define ANY(m) (__builtin_reduce_or(m) != 0)
#define AS_LINT(x) as_long${lanes}(x)
#define AS_LUINT(x) as_ulong${lanes}(x)
#define AS_REAL(x) as_double${lanes}(x)
#define TO_REAL(x) __builtin_convertvector(x, real)
#define TO_WORD(x) __builtin_convertvector(x, word)
#define TO_LINT(x) __builtin_convertvector(x, lint)
#define TO_LUINT(x) __builtin_convertvector(x, luint)
#define WORD_MASK(m) __builtin_convertvector(m, int${lanes})
% endif
typedef lint mask;
#define GE(a, b) LE(b, a)
#define GT(a, b) LT(b, a)
// m ? a : b in every lane; the OpenCL ternary does this for vectors (sign bit) and for scalars.
#define SEL(m, a, b) ((m) ? (a) : (b))
#define SELW(m, a, b) (WORD_MASK(m) ? (a) : (b))
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
#define UNIT_ROUNDOFF 0x1p-53

// Splat and lane access.
FN real splat(double x) { return (real)(x); }
FN lint lsplat(long x) { return (lint)(x); }
FN word wsplat(uint x) { return (word)(x); }

// Gathers: lane l reads table[index_l].
% for ctype, rtype, name in (("double", "real", "gather"), ("long", "lint", "gather_long"), ("uint", "word", "gather_word")):
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
FN uint count_lanes(mask m) { return (uint)(-sum_lanes(m)); }
// Bit l of the result is lane l of m.
FN uint lane_bits(mask m) {
    const lint bit = (lint)(${", ".join(f"{1 << l}L" for l in range(lanes))});
    return (uint)__builtin_reduce_or(m & bit);
}
// 0, 1, 2, ... counted over the lanes set in m; *n is the number of lanes set.
FN lint rank_lanes(mask m, uint *n) {
    const lint one = -m, zero = lsplat(0L);
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
