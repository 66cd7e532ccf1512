## cls: the element class; rendered once a class
// Cone: the wall of a frustum about the axis, from its entrance (z = 0) to z = L.
// With w = r0 + k z its radius at a height, F = x^2 + y^2 - w^2: in (x, y, w) every cone is the one of
// 45 degrees with its apex at the origin, and the point of a ray that is nearest to the apex there is no
// larger than the hit itself.  There F is solved, so that nothing is lost near the apex.
// Row: CONE_, see photizon_cl/scene/elements/cone.py.
FN real bend_${cls.suffix}(__global const double *row, local_${cls.suffix} r) {
    const real dw = r.dz * R(row[CONE_SLOPE]);
    return fma(r.dx, r.dx, fma(r.dy, r.dy, -dw * dw));
}
FN real anchor_${cls.suffix}(__global const double *row, local_${cls.suffix} r, real a) {
    const real w = fma(r.z, splat(row[CONE_SLOPE]), splat(row[CONE_FOOT])), dw = r.dz * R(row[CONE_SLOPE]);
    return -dot3(r.x, r.y, w, r.dx, r.dy, dw) / dot3(r.dx, r.dy, dw, r.dx, r.dy, dw);
}
FN form_${cls.suffix} form_at_${cls.suffix}(__global const double *row, local_${cls.suffix} r, real t) {
    form_${cls.suffix} q;
    const real x = fma(t, r.dx, r.x), y = fma(t, r.dy, r.y), z = fma(t, r.dz, r.z);
    const real w = fma(z, splat(row[CONE_SLOPE]), splat(row[CONE_FOOT])), dw = r.dz * R(row[CONE_SLOPE]);
    q.f = fma(x, x, fma(y, y, -w * w));
    q.b = fma(x, r.dx, fma(y, r.dy, -w * dw));
    q.size = fma(x, x, fma(y, y, w * w));
    return q;
}
FN real steepness_${cls.suffix}(__global const double *row, real x, real y, real z) {
    return fabs(fma(z, splat(row[CONE_SLOPE]), splat(row[CONE_FOOT]))) / R(row[CONE_COSINE]);
}
FN real height_${cls.suffix}(__global const double *row, local_${cls.suffix} r, real f) {
    const real w = fma(r.z, splat(row[CONE_SLOPE]), splat(row[CONE_FOOT]));
    return (sqrt(fma(r.x, r.x, r.y * r.y)) - w) * R(row[CONE_COSINE]);
}
// in a flat cone the distance from the axis tells the rims, in a slender one the height
FN mask in_rims_${cls.suffix}(__global const double *row, real x, real y, real z, real along, real across) {
    const real least = fmax(R(row[CONE_NARROW]) - across, splat(0.0)), most = across + R(row[CONE_WIDE]), rr = fma(x, x, y * y);
    return GE(z, -along) & LE(z, along + R(row[REVOLVED_HIGH])) & GE(rr, least * least) & LE(rr, most * most);
}
FN bool polishes_${cls.suffix}(__global const double *row) {
    return row[CONE_POLISHES] != 0.0;
}
FN real latest_${cls.suffix}(__global const double *row, local_${cls.suffix} r) {
    const real w = fma(r.z, splat(row[CONE_SLOPE]), splat(row[CONE_FOOT])), dw = r.dz * R(row[CONE_SLOPE]);
    return SEL(LT(dw, splat(0.0)), fmax(-w / dw, splat(0.0)), splat(INFINITY)) + R(row[CONE_NARROW] > 0.0 ? INFINITY : 0.0);
}

FN void shape_${cls.suffix}(const scene_t *scene, lint row, lint face, real *x, real *y, real *z,
                        real *nx, real *ny, real *nz) {
    const real foot = gather(scene->geometry + CONE_FOOT, row), k = gather(scene->geometry + CONE_SLOPE, row);
    const real cosine = gather(scene->geometry + CONE_COSINE, row);
    const real away = sqrt(fma(*x, *x, *y * *y));
    // at the apex, which has no normal, some direction
    const mask apex = EQ(away, splat(0.0));
    const real ux = SEL(apex, splat(1.0), *x / away), uy = SEL(apex, splat(0.0), *y / away);
    const real off = (away - fma(k, *z, foot)) * (cosine * cosine);
    *z = clamp(fma(k, off, *z), splat(0.0), gather(scene->geometry + REVOLVED_HIGH, row));
    const real w = fmax(fma(k, *z, foot), splat(0.0));
    *x = ux * w; *y = uy * w;
    *nx = ux * cosine; *ny = uy * cosine; *nz = -k * cosine;
}
