## cls: the element class; rendered once a class
// Biconvex lens: the intersection of two balls that meet in a circle of radius a in the plane z = 0.
// Faces: 0 front (its vertex up the axis), 1 back.
// Row: SOLID_ for the front ball, BICONVEX_ for the back one, see photizon_cl/scene/elements/biconvex.py.
FN bound_${cls.suffix} bound0_${cls.suffix}(__global const double *row, local_${cls.suffix} r) {
    return cap_bound_${cls.suffix}(row, r, 1.0, row[SOLID_DEPTH], row[SOLID_RADIUS]);
}
FN bound_${cls.suffix} bound1_${cls.suffix}(__global const double *row, local_${cls.suffix} r) {
    return cap_bound_${cls.suffix}(row, r, -1.0, row[BICONVEX_BACK_DEPTH], row[BICONVEX_BACK_RADIUS]);
}
FN void shape_${cls.suffix}(const scene_t *scene, lint row, lint face, real *x, real *y, real *z,
                        real *nx, real *ny, real *nz) {
    const mask front = IEQ(face, lsplat(0L));
    const real s = SEL(front, splat(1.0), splat(-1.0));
    const real h = SEL(front, gather(scene->geometry + SOLID_DEPTH, row), gather(scene->geometry + BICONVEX_BACK_DEPTH, row));
    const real k = SEL(front, gather(scene->geometry + SOLID_INVERSE, row), gather(scene->geometry + BICONVEX_BACK_INVERSE, row));
    cap_shape(s, h, gather(scene->geometry + SOLID_RIM_SQUARE, row), k, x, y, z, nx, ny, nz);
}
