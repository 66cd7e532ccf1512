## selftest_single: known answers asked of a device before its single precision is trusted
## (hostcode/device/single.py).
## reads: lanes, real (float); prelude, lib/philox and lib/elementary come before it.
## gives: one kernel; arrays are operation-major, n elements each.
<%
    load = lambda p: f"{p}[item]" if lanes == 1 else f"vload{lanes}(item, {p})"
    store = lambda v, k: (
        f"out[{k} * n + item] = {v}" if lanes == 1 else f"vstore{lanes}({v}, item, out + {k} * n)"
    )
%>
// Operations 6 and 7 tell a fused multiply-add, which is only there where it is written, from a product
// and a sum that each round.
__kernel void selftest_single(__global const float *pa, __global const float *pb, __global const float *pc,
                              __global const uint *ph, __global const uint *pl, __global float *out, uint n) {
    const size_t item = get_global_id(0);
    const real a = ${load("pa")}, b = ${load("pb")}, c = ${load("pc")};
    ${store("a + b", 0)};
    ${store("a - b", 1)};
    ${store("a * b", 2)};
    ${store("a / b", 3)};
    ${store("sqrt(fabs(a))", 4)};
    ${store("fma(a, b, c)", 5)};
    ${store("a * b + c", 6)};
    ${store("c - a * b", 7)};
    ${store("TO_REAL(TO_WIDE(a) * TO_WIDE(b) + TO_WIDE(c))", 8)};
    ${store("u01_closed_open(" + load("ph") + ", " + load("pl") + ")", 9)};
}
