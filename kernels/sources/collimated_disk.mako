## source: the source kind (option "diverging"); rendered once for each option
// reads: frame, radius, sine of the divergence.  Uniform by area over the disk (r = R sqrt(u)), parallel to
// the axis${", or with uniform radiance within a cone about it: sin^2 theta = u sin^2 delta" if source.option else ""}.
FN void emit_${source.suffix}(__global const double *source, real u, real v, real pu, real pv,
                             real *x, real *y, real *z, real *dx, real *dy, real *dz) {
    real s, c;
    sincos_turns(pv, &s, &c);
    const real r = ${point("collimated_disk.radius", "sqrt(pu)")} * R(source[COLLIMATED_DISK_RADIUS]);
    from_frame(source + SOURCE_FRAME, r * c, r * s, splat(0.0), x, y, z);
    *x += R(source[SOURCE_X]); *y += R(source[SOURCE_Y]); *z += R(source[SOURCE_Z]);
% if source.option == "diverging":
    sincos_turns(v, &s, &c);
    const real sin_theta = ${point("collimated_disk.sine", "sqrt(u)")} * R(source[COLLIMATED_DISK_SINE]);
    from_frame(source + SOURCE_FRAME, sin_theta * c, sin_theta * s, sqrt(fma(-sin_theta, sin_theta, splat(1.0))),
               dx, dy, dz);
% else:
    *dx = splat(source[SOURCE_FRAME + 6]);
    *dy = splat(source[SOURCE_FRAME + 7]);
    *dz = splat(source[SOURCE_FRAME + 8]);
% endif
}
