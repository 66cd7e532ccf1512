## cls: the element class; rendered once a class
// Biconvex lens: the intersection of two balls that meet in a circle of radius a in the plane z = 0.
// Faces: 0 front (its vertex up the axis), 1 back.
// Row: 0-2 centre of the rim, 3 a, 4 h of the front ball, 5 1/R front, 6 a^2, 7 rounding bound of a
// coordinate, 8 R front, 9 (rounding), 10 h of the back ball, 11 1/R back, 12 R back, 15-23 frame.
FN bound_${cls.suffix} bound0_${cls.suffix}(__global const double *row, local_${cls.suffix} r) {
    return cap_bound_${cls.suffix}(row, r, 1.0, row[4], row[8]);
}
FN bound_${cls.suffix} bound1_${cls.suffix}(__global const double *row, local_${cls.suffix} r) {
    return cap_bound_${cls.suffix}(row, r, -1.0, row[10], row[12]);
}
FN void shape_${cls.suffix}(const scene_t *scene, lint row, lint face, real *x, real *y, real *z,
                        real *nx, real *ny, real *nz) {
    const mask front = EQ(face, lsplat(0L));
    const real s = SEL(front, splat(1.0), splat(-1.0));
    const real h = SEL(front, gather(scene->geometry + 4, row), gather(scene->geometry + 10, row));
    const real k = SEL(front, gather(scene->geometry + 5, row), gather(scene->geometry + 11, row));
    cap_shape(s, h, gather(scene->geometry + 6, row), k, x, y, z, nx, ny, nz);
}
