## source: the source kind; rendered once for each option
// reads: radius.  Uniform by area over the shell, cosine lobe about the outward normal.
FN void emit_${source.suffix}(__global const double *source, real u, real v, real pu, real pv,
                               real *x, real *y, real *z, real *dx, real *dy, real *dz) {
    real s, c;
    sincos_turns(pv, &s, &c);
    const real sin_n = R(2.0) * sqrt(pu * (R(1.0) - pu));
    const real nx = sin_n * c, ny = sin_n * s, nz = fma(splat(-2.0), pu, splat(1.0));
    *x = fma(nx, splat(source[LAMBERTIAN_SPHERE_RADIUS]), splat(source[SOURCE_X]));
    *y = fma(ny, splat(source[LAMBERTIAN_SPHERE_RADIUS]), splat(source[SOURCE_Y]));
    *z = fma(nz, splat(source[LAMBERTIAN_SPHERE_RADIUS]), splat(source[SOURCE_Z]));
    sincos_turns(v, &s, &c);
    const real sin_theta = sqrt(u);
    about_normal(nx, ny, nz, sin_theta * c, sin_theta * s, sqrt(R(1.0) - u), dx, dy, dz);
}
