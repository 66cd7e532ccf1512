// Small vector algebra over the lane type.
FN real dot3(real ax, real ay, real az, real bx, real by, real bz) {
    return fma(ax, bx, fma(ay, by, az * bz));
}

// One Newton step of 1/|d| at |d| = 1: brings a direction with |d| = 1 + e back to 1 - 1.5 e^2.
FN void renormalise(real *x, real *y, real *z) {
    const real k = fma(splat(-0.5), dot3(*x, *y, *z, *x, *y, *z), splat(1.5));
    *x *= k; *y *= k; *z *= k;
}

// a e1 + b e2 + c n for an orthonormal basis about the unit vector n
// (Duff, Burgess, Christensen, Hery, Kensler, Liani, Villemin, JCGT 6(1), 2017).
// The sign is chosen by comparison, so that -0 and +0 give the same basis.
FN void about_normal(real nx, real ny, real nz, real a, real b, real c,
                     real *x, real *y, real *z) {
    const real sign = SEL(GE(nz, splat(0.0)), splat(1.0), splat(-1.0));
    const real k = R(-1.0) / (sign + nz);
    const real m = nx * ny * k;
    const real e1x = fma(sign * nx, nx * k, splat(1.0)), e1y = sign * m, e1z = -sign * nx;
    const real e2x = m, e2y = fma(ny, ny * k, sign), e2z = -ny;
    *x = fma(a, e1x, fma(b, e2x, c * nx));
    *y = fma(a, e1y, fma(b, e2y, c * ny));
    *z = fma(a, e1z, fma(b, e2z, c * nz));
}

// Rows u, v, w of a frame at f: the local vector (a, b, c) in world coordinates.  Entries 0 and 1
// make every product and sum exact, so an axis frame costs no accuracy.
FN void from_frame(__global const double *f, real a, real b, real c, real *x, real *y, real *z) {
    *x = fma(a, splat(f[0]), fma(b, splat(f[3]), c * R(f[6])));
    *y = fma(a, splat(f[1]), fma(b, splat(f[4]), c * R(f[7])));
    *z = fma(a, splat(f[2]), fma(b, splat(f[5]), c * R(f[8])));
}
