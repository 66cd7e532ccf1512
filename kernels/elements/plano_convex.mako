## cls: the element class; rendered once a class
// Plano-convex lens: the cap z >= 0 of a ball that meets the plane z = 0 in a circle of radius a.
// Faces: 0 flat (normal down the axis), 1 convex.
// Row: 0-2 centre of the flat face, 3 a, 4 h = sqrt(R^2 - a^2), 5 1/R, 6 a^2, 7 rounding bound of a
// coordinate, 8 R, 15-23 frame.
FN bound_${cls.suffix} bound0_${cls.suffix}(__global const double *row, local_${cls.suffix} r) {
    bound_${cls.suffix} q;
    const real t = -r.z / r.dz;
    const mask up = GT(r.dz, splat(0.0)), down = LT(r.dz, splat(0.0));
    const mask along = ~(up | down);
    q.lo = SEL(up, t, SEL(along & LT(r.z, splat(0.0)), splat(INFINITY), splat(-INFINITY)));
    q.hi = SEL(down, t, splat(INFINITY));
    q.back = splat(INFINITY);
    q.on = LE(fabs(r.z), fma(fabs(r.x) + fabs(r.y), splat(row[9]), splat(row[7])));
    q.in = up;
% if "contact" in effects:
    q.height = -r.z;
    q.near = splat(fma(4.0 * row[3], row[9], row[7]));
% endif
    return q;
}
FN bound_${cls.suffix} bound1_${cls.suffix}(__global const double *row, local_${cls.suffix} r) {
    return cap_bound_${cls.suffix}(row, r, 1.0, row[4], row[8]);
}
FN void shape_${cls.suffix}(const scene_t *scene, lint row, lint face, real *x, real *y, real *z,
                        real *nx, real *ny, real *nz) {
    const mask convex = EQ(face, lsplat(1L));
    real cx = *x, cy = *y, cz = *z, mx, my, mz;
    cap_shape(splat(1.0), gather(scene->geometry + 4, row), gather(scene->geometry + 6, row),
              gather(scene->geometry + 5, row), &cx, &cy, &cz, &mx, &my, &mz);
    *x = SEL(convex, cx, *x);
    *y = SEL(convex, cy, *y);
    *z = SEL(convex, fmax(cz, splat(0.0)), splat(0.0));
    *nx = SEL(convex, mx, splat(0.0));
    *ny = SEL(convex, my, splat(0.0));
    *nz = SEL(convex, mz, splat(-1.0));
}
