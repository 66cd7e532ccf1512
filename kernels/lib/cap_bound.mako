## cls: the element class; rendered once a class, for solids with caps
// The ball of a cap as a bound of a solid, see solid.mako.
FN bound_${cls.suffix} cap_bound_${cls.suffix}(__global const double *row, local_${cls.suffix} r, double s, double h, double radius) {
    bound_${cls.suffix} q;
    real b, c;
    const mask met = cap_interval(r.x, r.y, r.z, r.dx, r.dy, r.dz, s, h, row[SOLID_RIM], &q.lo, &q.hi, &b, &c);
    q.lo = SEL(met, q.lo, splat(INFINITY));
    // a ray known to be inside that rounding takes past the rim leaves at its closest approach
    q.hi = SEL(met, q.hi, -b);
    q.back = R(2.0) * fabs(b);
    q.on = LE(fabs(c), fma(fabs(r.x) + fabs(r.y) + fabs(r.z), splat(2.0 * radius * row[SOLID_RELATIVE]), splat(2.0 * radius * row[SOLID_NEAR])));
    q.in = LT(b, splat(0.0));
% if "contact" in effects:
    q.height = c * R(0.5 / radius);
    q.near = splat(fma(4.0 * row[SOLID_RIM], row[SOLID_RELATIVE], row[SOLID_NEAR]));
% endif
    return q;
}
