## cls: the element class; rendered once a class
// Cylinder: the wall of a round tube about the axis, from its entrance (z = 0) to z = L.
// F = x^2 + y^2 - R^2.  Row: CYLINDER_, see photizon_cl/scene/elements/cylinder.py.
FN real bend_${cls.suffix}(__global const double *row, local_${cls.suffix} r) {
    return fma(r.dx, r.dx, r.dy * r.dy);
}
// the point nearest to the axis: there b is nothing but rounding
FN real anchor_${cls.suffix}(__global const double *row, local_${cls.suffix} r, real a) {
    return -fma(r.x, r.dx, r.y * r.dy) / a;
}
FN form_${cls.suffix} form_at_${cls.suffix}(__global const double *row, local_${cls.suffix} r, real t) {
    form_${cls.suffix} q;
    const real x = fma(t, r.dx, r.x), y = fma(t, r.dy, r.y), rr = splat(row[CYLINDER_RADIUS] * row[CYLINDER_RADIUS]);
    q.f = fma(x, x, fma(y, y, -rr));
    q.b = fma(x, r.dx, y * r.dy);
    q.size = rr;
    return q;
}
FN real steepness_${cls.suffix}(__global const double *row, real x, real y, real z) {
    return splat(row[CYLINDER_RADIUS]);
}
FN real height_${cls.suffix}(__global const double *row, local_${cls.suffix} r, real f) {
    return f * R(0.5 * row[CYLINDER_INVERSE]);
}
FN mask in_rims_${cls.suffix}(__global const double *row, real x, real y, real z, real along, real across) {
    return GE(z, -along) & LE(z, ${point("cylinder.rim", "along")} + R(row[REVOLVED_HIGH]));
}

FN void shape_${cls.suffix}(const scene_t *scene, lint row, lint face, real *x, real *y, real *z,
                        real *nx, real *ny, real *nz) {
    const real away = sqrt(fma(*x, *x, *y * *y)), radius = gather(scene->geometry + CYLINDER_RADIUS, row);
    *nx = *x / away; *ny = *y / away; *nz = splat(0.0);
    *x = radius * *nx; *y = radius * *ny;
    *z = clamp(*z, splat(0.0), gather(scene->geometry + REVOLVED_HIGH, row));
}
