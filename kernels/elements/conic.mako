## cls: the element class; rendered once a class
// Conic: a sheet of a conic of revolution that opens up the axis from its vertex at the origin,
// F = x^2 + y^2 - z (2 R - kappa z), kappa = 1 + conic constant, between two circles about the axis.
// Normal into the concave side, which is the inside of F.
// Row: CONIC_, see photizon_cl/scene/elements/conic.py.
FN real bend_${cls.suffix}(__global const double *row, local_${cls.suffix} r) {
    return fma(r.dx, r.dx, fma(r.dy, r.dy, R(row[CONIC_KAPPA]) * r.dz * r.dz));
}
// the point nearest to the vertex: F is as large as the square of the distance
FN real anchor_${cls.suffix}(__global const double *row, local_${cls.suffix} r, real a) {
    return -dot3(r.x, r.y, r.z, r.dx, r.dy, r.dz);
}
FN form_${cls.suffix} form_at_${cls.suffix}(__global const double *row, local_${cls.suffix} r, real t) {
    form_${cls.suffix} q;
    const real x = fma(t, r.dx, r.x), y = fma(t, r.dy, r.y), z = fma(t, r.dz, r.z);
    const real kz = R(row[CONIC_KAPPA]) * z;
    const scalar radius = R(row[CONIC_RADIUS]);
    q.f = fma(x, x, fma(y, y, z * (kz - R(2.0) * radius)));
    q.b = fma(x, r.dx, fma(y, r.dy, (kz - radius) * r.dz));
    q.size = fma(x, x, fma(y, y, fabs(z) * (fabs(kz) + R(2.0) * radius)));
    return q;
}
FN real steepness_${cls.suffix}(__global const double *row, real x, real y, real z) {
    const real g = fma(z, splat(row[CONIC_KAPPA]), splat(-row[CONIC_RADIUS]));
    return sqrt(fma(x, x, fma(y, y, g * g)));
}
FN real height_${cls.suffix}(__global const double *row, local_${cls.suffix} r, real f) {
    return R(0.5) * f / steepness_${cls.suffix}(row, r.x, r.y, r.z);
}
// in a shallow sheet the distance from the axis tells the rims, in a steep one the height
FN mask in_rims_${cls.suffix}(__global const double *row, real x, real y, real z, real along, real across) {
    const real least = fmax(R(row[CONIC_INNER]) - across, splat(0.0)), most = across + R(row[CONIC_APERTURE]), rr = fma(x, x, y * y);
    return GE(z, R(row[REVOLVED_LOW]) - along) & LE(z, along + R(row[REVOLVED_HIGH])) & GE(rr, least * least) & LE(rr, most * most);
}
FN bool polishes_${cls.suffix}(__global const double *row) {
    return row[CONIC_POLISHES] != 0.0;
}

FN void shape_${cls.suffix}(const scene_t *scene, lint row, lint face, real *px, real *py, real *pz,
                        real *nx, real *ny, real *nz) {
    const real radius = gather(scene->geometry + CONIC_RADIUS, row), kappa = gather(scene->geometry + CONIC_KAPPA, row);
    const real inner = gather(scene->geometry + CONIC_INNER, row), aperture = gather(scene->geometry + CONIC_APERTURE, row);
    real x = *px, y = *py, z = *pz;
    for (int step = 0; step < 2; step++) {
        const real g = fma(kappa, z, -radius);
        const real f = fma(x, x, fma(y, y, z * (g - radius)));
        const real k = R(-0.5) * f / fma(x, x, fma(y, y, g * g));
        x = fma(k, x, x); y = fma(k, y, y); z = fma(k, g, z);
    }
    const real away = sqrt(fma(x, x, y * y));
    const mask beyond = GT(away, aperture), within = LT(away, inner) & GT(away, splat(0.0));
    const real low = gather(scene->geometry + REVOLVED_LOW, row), high = gather(scene->geometry + REVOLVED_HIGH, row);
    const real k = SEL(beyond, aperture / away, SEL(within, inner / away, splat(1.0)));
    x *= k; y *= k;
    z = ${point("conic.height", "clamp(z, low, high)")};
    const real g = fma(kappa, z, -radius), n = R(-1.0) / sqrt(fma(x, x, fma(y, y, g * g)));
    *px = x; *py = y; *pz = z;
    *nx = n * x; *ny = n * y; *nz = n * g;
}
