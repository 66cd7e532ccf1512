// sin and cos of a whole turn's fraction, from operations that IEEE 754 fixes: the same bits on
// every device.
//
// sincos_turns(x, &s, &c): s = sin(2 pi x), c = cos(2 pi x) for 0 <= x <= 1.  The nearest quarter
// turn is removed exactly; the rest |r| <= 1/8 goes through polynomials in r^2 (interpolation at
// Chebyshev nodes, 60-digit arithmetic; truncation below 2e-20), and 2 pi is split in two doubles.
// Error below 1 ulp; sin and cos of exact quarter turns are exact.
<%
    sin_poly = ["-0x1.4abbce625be53p+5", "0x1.466bc6775aae1p+6", "-0x1.32d2cce62b872p+6",
                "0x1.50783486facaap+5", "-0x1.e3074d2614b2dp+3", "0x1.e8f036bcd3237p+1",
                "-0x1.6cc577dadd922p-1"]
    cos_poly = ["-0x1.3bd3cc9be45dep+4", "0x1.03c1f081b5ac0p+6", "-0x1.55d3c7e3cb241p+6",
                "0x1.e1f5068688d5bp+5", "-0x1.a6d1eef479be1p+4", "0x1.f9ce245cada0bp+2",
                "-0x1.b2f3eb054afcdp+0"]
    # 2 pi less the number nearest to it
    two_pi_rest = "0x1.1a62633145c07p-52" if real == "double" else "-0x1.777a5cf72cecep-23"
%>
FN void sincos_turns(real x, real *s, real *c) {
    // 4x + TO_INTEGER rounds to the nearest quarter turn and leaves its number in the low bits.
    const real shifted = fma(x, splat(4.0), splat(TO_INTEGER));
    const lint quarter = LOW_BITS(shifted);
    const real r = fma(shifted - R(TO_INTEGER), splat(-0.25), x);
    const real z = r * r;
    real ps = splat(${sin_poly[-1]});
    real pc = splat(${cos_poly[-1]});
% for a, b in zip(sin_poly[-2::-1], cos_poly[-2::-1]):
    ps = fma(ps, z, splat(${a}));
    pc = fma(pc, z, splat(${b}));
% endfor
    // sin = r (hi + lo + z ps), the large term last
    const real sr = fma(r, splat(0x1.921fb54442d18p+2), r * fma(z, ps, splat(${two_pi_rest})));
    const real cr = fma(pc, z, splat(1.0));
    const mask odd = MASK_OF(-(quarter & 1L));
    const mask turn_s = INE(quarter & 2L, lsplat(0L));
    const mask turn_c = INE((quarter + 1L) & 2L, lsplat(0L));
    const real a = SEL(odd, cr, sr);
    const real b = SEL(odd, sr, cr);
    *s = SEL(turn_s, -a, a);
    *c = SEL(turn_c, -b, b);
}
