// A ball seen from the circle where it meets the plane z = 0: radius a there, centre at z = -s h with
// s = +-1 and h = sqrt(R^2 - a^2).  Its points are x^2 + y^2 + z^2 + 2 s h z <= a^2: nothing as large
// as R^2 is ever subtracted, so a cap a millionth as high as wide keeps its digits.
//
// gives: the interval [t0, t1] of the ray inside the ball; b = d.(o - centre) and c, the left side less
// a^2, at the origin.  No interval where the ray misses it.
FN mask cap_interval(real x, real y, real z, real dx, real dy, real dz, double s, double h, double a,
                     real *t0, real *t1, real *b_out, real *c_out) {
    const real b = fma(dz, splat(s * h), dot3(x, y, z, dx, dy, dz));
    const real c = ${careful("geometry", "fma(x, x, fma(y, y, fma(z, z + R(2.0 * s * h), splat(-a * a))))", "fma(x, x, fma(y, y, (z + R(s * h)) * (z + R(s * h)))) - R(fma(a, a, h * h))")};
    // b^2 - c is the same at every point of the ray.  Far from the rim both are as large as the
    // square of the distance, so it is taken at the point nearest to the rim's centre instead.
    const real near = ${careful("geometry", "-dot3(x, y, z, dx, dy, dz)", "splat(0.0)")};
    const real nx = fma(near, dx, x), ny = fma(near, dy, y), nz = fma(near, dz, z);
    const real nb = fma(dz, splat(s * h), dot3(nx, ny, nz, dx, dy, dz)), bb = nb * nb;
    const real nc = fma(nx, nx, fma(ny, ny, fma(nz, nz + R(2.0 * s * h), splat(-a * a))));
    const real discriminant = (bb - nc) + fma(nb, nb, -bb);
    const real root = sqrt(fmax(discriminant, splat(0.0)));
    // t = -b -+ root; q is the one of larger magnitude, the other is c / q
    const real q = -(b + copysign(root, b));
    const real other = SEL(EQ(q, splat(0.0)), splat(0.0), c / q);
    *t0 = fmin(q, other);
    *t1 = fmax(q, other);
    *b_out = b;
    *c_out = c;
    return GE(discriminant, splat(0.0));
}

// The nearest point of the ball's surface to one that is close to it, and the outward normal.
FN void cap_shape(real s, real h, real a2, real k, real *x, real *y, real *z, real *nx, real *ny, real *nz) {
    for (int step = 0; step < 2; step++) {
        const real g = fma(*x, *x, fma(*y, *y, fma(*z, *z, fma(R(2.0) * s * h, *z, -a2))));
        *nx = *x * k; *ny = *y * k; *nz = fma(s, h, *z) * k;
        const real move = R(-0.5) * k * g;
        *x = fma(move, *nx, *x); *y = fma(move, *ny, *y); *z = fma(move, *nz, *z);
    }
    *nx = *x * k; *ny = *y * k; *nz = fma(s, h, *z) * k;
}
