## source: the source kind; rendered once for each option
// reads: frame, radius.  Parallel to the axis, uniform by area over the disk (r = R sqrt(u)).
FN void emit_${source.suffix}(__global const double *source, real u, real v, real pu, real pv,
                             real *x, real *y, real *z, real *dx, real *dy, real *dz) {
    real s, c;
    sincos_turns(pv, &s, &c);
    const real r = sqrt(pu) * source[COLLIMATED_DISK_RADIUS];
    from_frame(source + SOURCE_FRAME, r * c, r * s, splat(0.0), x, y, z);
    *x += source[SOURCE_X]; *y += source[SOURCE_Y]; *z += source[SOURCE_Z];
    *dx = splat(source[SOURCE_FRAME + 6]);
    *dy = splat(source[SOURCE_FRAME + 7]);
    *dz = splat(source[SOURCE_FRAME + 8]);
}
