## cls: the element class; rendered once a class
// Plano-convex lens: the cap z >= 0 of a ball that meets the plane z = 0 in a circle of radius a.
// Faces: 0 flat (normal down the axis), 1 convex.
// Row: SOLID_, see photizon_cl/scene/elements/lens.py.
FN bound_${cls.suffix} bound0_${cls.suffix}(__global const double *row, local_${cls.suffix} r) {
    bound_${cls.suffix} q;
    const real t = -r.z / r.dz;
    const mask up = GT(r.dz, splat(0.0)), down = LT(r.dz, splat(0.0));
    const mask along = ~(up | down);
    q.lo = SEL(up, t, SEL(along & LT(r.z, splat(0.0)), splat(INFINITY), splat(-INFINITY)));
    q.hi = SEL(down, t, splat(INFINITY));
    q.back = splat(INFINITY);
    q.on = LE(fabs(r.z), fma(fabs(r.x) + fabs(r.y), splat(row[SOLID_RELATIVE]), splat(row[SOLID_NEAR])));
    q.in = up;
% if "contact" in effects:
    q.height = -r.z;
    q.near = splat(fma(4.0 * row[SOLID_RIM], row[SOLID_RELATIVE], row[SOLID_NEAR]));
% endif
    return q;
}
FN bound_${cls.suffix} bound1_${cls.suffix}(__global const double *row, local_${cls.suffix} r) {
    return cap_bound_${cls.suffix}(row, r, 1.0, row[SOLID_DEPTH], row[SOLID_RADIUS]);
}
FN void shape_${cls.suffix}(const scene_t *scene, lint row, lint face, real *x, real *y, real *z,
                        real *nx, real *ny, real *nz) {
    const mask convex = IEQ(face, lsplat(1L));
    real cx = *x, cy = *y, cz = *z, mx, my, mz;
    cap_shape(splat(1.0), gather(scene->geometry + SOLID_DEPTH, row), gather(scene->geometry + SOLID_RIM_SQUARE, row),
              gather(scene->geometry + SOLID_INVERSE, row), &cx, &cy, &cz, &mx, &my, &mz);
    *x = SEL(convex, cx, *x);
    *y = SEL(convex, cy, *y);
    *z = SEL(convex, fmax(cz, splat(0.0)), splat(0.0));
    *nx = SEL(convex, mx, splat(0.0));
    *ny = SEL(convex, my, splat(0.0));
    *nz = SEL(convex, mz, splat(-1.0));
}
