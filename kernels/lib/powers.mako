// Logarithm, exponential and power from operations that IEEE 754 fixes: the same bits on every device.
// A kind that needs them names this file among its `libraries`.
//
//   natural_log(x)    -infinity at 0; NaN for x < 0
//   exponential(x)    0 and infinity beyond the range
//   power(x, y)       x^y for 0 <= x; 1 where y = 0; NaN for x < 0 or an infinite y
//
// What is not a number stays none, so that a slip below 0 is not taken for a weight.
// All are taken in double-double and rounded once: the logarithm below 0.51 ulp of a double, the exponential
// below 0.6, the power below 1 (its error grows with |y log x|); subnormal results below one more.
// Where `real` is float they are the double's value rounded again.
//
// log: x = 2^k m, sqrt(1/2) <= m < sqrt(2), s = (m - 1)/(m + 1), log m = 2 (s + s^3/3 + s^5/5 + ...), the
// first two terms in double-double.  exp: x = k log 2 + r, |r| <= log(2)/2, Taylor's series of 15 terms, the
// first two exactly.  (Muller, Elementary Functions, 3rd ed., 2016, sections 4.2 and 11.)
<%
    width = "" if lanes == 1 else lanes
    tail = [f"{2 / (2 * k + 1)!r}" for k in range(14, 1, -1)]
    factorials = [1]
    for k in range(1, 15):
        factorials.append(factorials[-1] * k)
    taylor = [f"{1 / factorials[k]!r}" for k in range(14, 1, -1)]
%>
#define AS_WIDE(x) as_double${width}(x)
#define WIDE(x) ((wide)(x))
#define WIDE_TO_INTEGER 0x1.8p52
#define LOG_TWO_HI 0x1.62e42fefa38p-1       // 42 bits: k LOG_TWO_HI is exact
#define LOG_TWO_LO 0x1.ef35793c7673p-45

typedef struct { wide hi, lo; } twofold_t;

FN twofold_t twofold_log(wide x) {
    const mask tiny = ILT(x, WIDE(0x1p-1022));
    const lint bits = AS_LINT(SELI(tiny, x * 0x1p54, x));
    const lint k = (bits - (lint)(0x3FE6A09E667F3BCDL)) >> 52;
    const wide n = TO_WIDE(k - SELI(tiny, lsplat(54L), lsplat(0L)));
    const wide m = AS_WIDE(bits - (k << 52));
    const wide f = m - 1.0, g = m + 1.0, g_lo = m - (g - 1.0);
    const wide s = f / g, s_lo = (fma(-s, g, f) - s * g_lo) / g;
    const wide z = s * s, z_lo = fma(s, s, -z) + 2.0 * s * s_lo;
    wide series = WIDE(${tail[0]});
% for c in tail[1:]:
    series = fma(series, z, WIDE(${c}));
% endfor
    // z 2/3 + z^2 (2/5 + ...), then times s
    const wide t = z * 0x1.5555555555555p-1;
    const wide t_lo = fma(z, WIDE(0x1.5555555555555p-1), -t) + (z * 0x1.5555555555555p-55 + z_lo * 0x1.5555555555555p-1);
    const wide u = z * z * series;
    const wide v = t + u, v_lo = (t - v) + u + t_lo;
    const wide w = s * v, w_lo = fma(s, v, -w) + (s * v_lo + s_lo * v);
    const wide h = 2.0 * s + w, h_lo = (2.0 * s - h) + w + (2.0 * s_lo + w_lo);
    const wide a = n * LOG_TWO_HI;
    twofold_t r;
    const wide sum = a + h;
    const wide rest = (a - sum) + h + (h_lo + n * LOG_TWO_LO);
    r.hi = sum + rest;
    r.lo = (sum - r.hi) + rest;
    return r;
}

FN wide twofold_exp(wide x, wide x_lo) {
    const mask outside = IGT(fabs(x), WIDE(1000.0));
    const wide y = fmin(fmax(x, WIDE(-1000.0)), WIDE(1000.0));
    const wide y_lo = SELI(outside, WIDE(0.0), x_lo);
    const wide shifted = fma(y, WIDE(0x1.71547652b82fep+0), WIDE(WIDE_TO_INTEGER));
    const wide n = shifted - WIDE_TO_INTEGER;
    const wide near = fma(-n, WIDE(LOG_TWO_HI), y), off = fma(-n, WIDE(LOG_TWO_LO), y_lo);
    const wide r = near + off, r_lo = (near - r) + off;
    wide series = WIDE(${taylor[0]});
% for c in taylor[1:]:
    series = fma(series, r, WIDE(${c}));
% endfor
    const wide one = r + 1.0, one_lo = (1.0 - one) + r;
    const wide e = one + (one_lo + fma(r * r, series, fma(r_lo, r, r_lo)));
    // 2^n in two factors, so that neither is out of range
    const lint k = AS_LINT(shifted) - as_long(WIDE_TO_INTEGER), low = k >> 1;
    return e * AS_WIDE((low + 1023L) << 52) * AS_WIDE((k - low + 1023L) << 52);
}

FN real natural_log(real x) {
    const wide w = TO_WIDE(x);
    const twofold_t log = twofold_log(w);
    // 0, infinity, and what has no logarithm
    const wide end = SELI(IEQ(w, WIDE(0.0)), WIDE(-INFINITY), SELI(IGT(w, WIDE(0.0)), w, WIDE(NAN)));
    return TO_REAL(SELI(IGT(w, WIDE(0.0)) & ILT(w, WIDE(INFINITY)), log.hi, end));
}

FN real exponential(real x) {
    const wide w = TO_WIDE(x);
    return TO_REAL(SELI(IEQ(w, w), twofold_exp(w, WIDE(0.0)), w));
}

FN real power(real x, real y) {
    const wide w = TO_WIDE(x), v = TO_WIDE(y);
    const twofold_t log = twofold_log(w);
    const wide p = v * log.hi;
    const wide result = twofold_exp(p, fma(v, log.hi, -p) + v * log.lo);
    // 0 and infinity to a power
    const wide end = SELI(IGT(v, WIDE(0.0)) ^ IGT(w, WIDE(0.0)), WIDE(0.0), WIDE(INFINITY));
    const wide ends = SELI(IEQ(v, WIDE(0.0)), WIDE(1.0), end);
    const mask known = IGE(w, WIDE(0.0)) & ILT(fabs(v), WIDE(INFINITY));
    return TO_REAL(SELI(known, SELI(IGT(w, WIDE(0.0)) & ILT(w, WIDE(INFINITY)), result, ends), WIDE(NAN)));
}
