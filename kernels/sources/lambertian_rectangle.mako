## source: the source kind; rendered once for each option
// reads: frame, half sizes.  Uniform by area over the rectangle, cosine lobe about the axis.
FN void emit_${source.suffix}(__global const double *source, real u, real v, real pu, real pv,
                     real *x, real *y, real *z, real *dx, real *dy, real *dz) {
    const real a = fma(splat(2.0), pu, splat(-1.0)) * R(source[LAMBERTIAN_RECTANGLE_HALF_WIDTH]);
    const real b = ${point("lambertian_rectangle.across", "fma(splat(2.0), pv, splat(-1.0))")} * R(source[LAMBERTIAN_RECTANGLE_HALF_HEIGHT]);
    from_frame(source + SOURCE_FRAME, a, b, splat(0.0), x, y, z);
    *x += R(source[SOURCE_X]); *y += R(source[SOURCE_Y]); *z += R(source[SOURCE_Z]);
    real s, c;
    sincos_turns(v, &s, &c);
    const real sin_theta = sqrt(u);
    from_frame(source + SOURCE_FRAME, sin_theta * c, sin_theta * s, sqrt(R(1.0) - u), dx, dy, dz);
}
