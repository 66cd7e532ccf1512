## source: the source kind; rendered once for each option
// reads: frame, 1 - cos of the half-angle.  Uniform over a cone about the axis: 1 - cos theta = u h with h
// = 1 - cos theta_max, which keeps its digits however narrow the cone; sin^2 theta = u h (2 - u h).
FN void emit_${source.suffix}(__global const double *source, real u, real v, real pu, real pv,
                     real *x, real *y, real *z, real *dx, real *dy, real *dz) {
    real s, c;
    sincos_turns(v, &s, &c);
    const real h = ${point("cone_point.height", "u")} * R(source[CONE_POINT_HEIGHT]), sin_theta = sqrt(h * (R(2.0) - h));
    *x = splat(source[SOURCE_X]); *y = splat(source[SOURCE_Y]); *z = splat(source[SOURCE_Z]);
    from_frame(source + SOURCE_FRAME, sin_theta * c, sin_theta * s, R(1.0) - h, dx, dy, dz);
}
