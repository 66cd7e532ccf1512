## source: the source kind; rendered once for each option
// reads: nothing.  Uniform over the sphere: cos theta = 1 - 2u in (-1, 1], phi = 2 pi v.
FN void emit_${source.suffix}(__global const double *source, real u, real v, real pu, real pv,
                             real *x, real *y, real *z, real *dx, real *dy, real *dz) {
    real s, c;
    sincos_turns(v, &s, &c);
    const real sin_theta = R(2.0) * sqrt(u * (R(1.0) - u));
    *x = splat(source[SOURCE_X]); *y = splat(source[SOURCE_Y]); *z = splat(source[SOURCE_Z]);
    *dx = sin_theta * c;
    *dy = sin_theta * s;
    *dz = ${point("isotropic_point.cosine", "fma(splat(-2.0), u, splat(1.0))")};
}
