## selftest: known answers asked of a device before it is trusted (hostcode/device/selftest.py).
## reads: lanes; prelude, lib/philox, lib/elementary and lib/limbs come before it.
## gives: one kernel per group of operations; arrays are operation-major, n elements each.
<%
    load = lambda p: f"{p}[item]" if lanes == 1 else f"vload{lanes}(item, {p})"
    store = lambda v, k: (
        f"out[{k} * n + item] = {v}" if lanes == 1 else f"vstore{lanes}({v}, item, out + {k} * n)"
    )
%>
// The operations that results rest on.  Operations 5 to 8 tell a fused multiply-add, which is only
// there where it is written, from a product and a sum that each round.
__kernel void selftest_arithmetic(__global const double *pa, __global const double *pb,
                                  __global const double *pc, __global double *out, uint n) {
    const size_t item = get_global_id(0);
    const real a = ${load("pa")}, b = ${load("pb")}, c = ${load("pc")};
    ${store("a + b", 0)};
    ${store("a - b", 1)};
    ${store("a * b", 2)};
    ${store("a / b", 3)};
    ${store("sqrt(fabs(a))", 4)};
    ${store("fma(a, b, c)", 5)};
    ${store("a * b + c", 6)};
    ${store("a * b - c", 7)};
    ${store("c - a * b", 8)};
    ${store("SEL(LT(a, b), a, b)", 9)};
    ${store("SEL(EQ(a, c), b, c)", 10)};
    ${store("copysign(a, b)", 11)};
}

// Conversions and integers: x is a double below 2^53 in magnitude, u any 64 bits.
__kernel void selftest_integers(__global const double *px, __global const ulong *pu,
                                __global ulong *out, uint n) {
    const size_t item = get_global_id(0);
    const real x = ${load("px")};
    const luint u = ${load("pu")};
    const word low = TO_WORD(u), high = TO_WORD(u >> 32);
    ${store("AS_LUINT(TO_REAL(u))", 0)};
    ${store("AS_LUINT(TO_REAL(AS_LINT(u)))", 1)};
    ${store("AS_LUINT(TO_REAL(low))", 2)};
    ${store("AS_LUINT(TO_LINT(x))", 3)};
    ${store("AS_LUINT(floor(x))", 4)};
    ${store("AS_LUINT(rint(x))", 5)};
    ${store("TO_LUINT(mul_hi(low, high))", 6)};
    ${store("TO_LUINT(low * high)", 7)};
    ${store("TO_LUINT(low) * TO_LUINT(high)", 8)};
    ${store("u * 0x9E3779B97F4A7C15UL", 9)};
    ${store("u ^ (u >> 29) ^ (u << 13)", 10)};
    ${store("AS_LUINT(AS_LINT(u) >> 17)", 11)};
}

// The production generator and the doubles made of its words.
__kernel void selftest_philox(__global const uint *counter, uint k0, uint k1,
                              __global uint *out, __global double *uniform, uint n) {
    const size_t item = get_global_id(0);
    word c0 = ${load("counter")};
    word c1 = ${load("(counter + n)")};
    word c2 = ${load("(counter + 2 * n)")};
    word c3 = ${load("(counter + 3 * n)")};
    philox4x32_10(&c0, &c1, &c2, &c3, k0, k1);
    ${store("c0", 0)};
    ${store("c1", 1)};
    ${store("c2", 2)};
    ${store("c3", 3)};
    const real u = u01_closed_open(c0, c1);
    ${"uniform[item] = u" if lanes == 1 else f"vstore{lanes}(u, item, uniform)"};
}

__kernel void selftest_sincos(__global const double *turns, __global double *out, uint n) {
    const size_t item = get_global_id(0);
    real s, c;
    sincos_turns(${load("turns")}, &s, &c);
    ${store("s", 0)};
    ${store("c", 1)};
}

// Sums that must not depend on order: the production image of a weight (three limbs, and a count),
// and two limbs of raw bits, every work-item adding to the same words.
__kernel void selftest_limbs(__global const double *weight, volatile __global long *raw,
                             volatile __global long *cell, uint repeat) {
    const size_t item = get_global_id(0);
    const real w = ${load("weight")};
    for (uint r = 0; r < repeat; ++r) {
        const image_t image = image_of(w);
        const luint bits = AS_LUINT(w);
% for l in range(lanes):
        atom_add(cell, ${lane("image.p0", l)});
        atom_add(cell + 1, ${lane("image.p1", l)});
        atom_add(cell + 2, ${lane("image.p2", l)});
        atom_add(cell + 3, 1L);
        atom_add(raw, (long)(${lane("bits", l)} & 0xFFFFFFFFUL));
        atom_add(raw + 1, (long)(${lane("bits", l)} >> 32));
% endfor
    }
}
