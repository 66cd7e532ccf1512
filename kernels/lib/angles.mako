// The angle of a direction in degrees, from operations that IEEE 754 fixes.
//
// degrees_of(s, c): the angle in [0, 90] whose sine and cosine are in the proportion of s to c, neither of
// them negative.  Above 22.5 degrees off the nearer of 0 and 90 the angle is taken from 45; the tangent of
// the rest, |z| <= tan(22.5 degrees), goes through a polynomial in z^2 (interpolation at Chebyshev nodes,
// 60-digit arithmetic; truncation below 4e-18).  0, 45 and 90 degrees are exact; error of others below 3e-14.
<%
    atan_poly = ["-0x1.5555555555555p-2", "0x1.9999999999997p-3", "-0x1.24924924920adp-3", "0x1.c71c71c6ddbfcp-4",
                 "-0x1.745d173565149p-4", "0x1.3b13aea9e84b6p-4", "-0x1.1110cee80b516p-4", "0x1.e1d8e9bffe59ap-5",
                 "-0x1.aebd1fa559879p-5", "0x1.829ce3237aa74p-5", "-0x1.503c4469940ddp-5", "0x1.f5ef74d053589p-6",
                 "-0x1.c81291cfc2b07p-7"]
%>
FN real degrees_of(real s, real c) {
    const real y = fmin(s, c), x = fmax(s, c);
    const mask diagonal = GT(y, x * R(0x1.a827999fcef32p-2));
    const real over = SEL(diagonal, y - x, y), under = SEL(diagonal, y + x, x);
    const real z = over / SEL(GT(under, splat(0.0)), under, splat(1.0));
    const real w = z * z;
    real p = splat(${atan_poly[-1]});
% for a in atan_poly[-2::-1]:
    p = fma(p, w, splat(${a}));
% endfor
    const real angle = fma(fma(p, w * z, z), splat(0x1.ca5dc1a63c1f8p+5), SEL(diagonal, splat(45.0), splat(0.0)));
    return SEL(GT(s, c), R(90.0) - angle, angle);
}
