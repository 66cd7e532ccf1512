## source: the source kind; rendered once for each option
// reads: frame, radius.  Uniform by area over the disk (r = R sqrt(u)), cosine lobe about the axis.
FN void emit_${source.suffix}(__global const double *source, real u, real v, real pu, real pv,
                             real *x, real *y, real *z, real *dx, real *dy, real *dz) {
    real s, c;
    sincos_turns(pv, &s, &c);
    const real r = sqrt(pu) * R(source[LAMBERTIAN_DISK_RADIUS]);
    from_frame(source + SOURCE_FRAME, r * c, r * s, splat(0.0), x, y, z);
    *x += R(source[SOURCE_X]); *y += R(source[SOURCE_Y]); *z += R(source[SOURCE_Z]);
    sincos_turns(v, &s, &c);
    const real sin_theta = sqrt(u);
    from_frame(source + SOURCE_FRAME, sin_theta * c, sin_theta * s, sqrt(R(1.0) - u), dx, dy, dz);
}
