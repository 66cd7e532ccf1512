## source: the source kind; rendered once for each option
// reads: frame.  Cosine lobe about the axis: sin^2 theta = u, cos theta = sqrt(1 - u) > 0.
FN void emit_${source.suffix}(__global const double *source, real u, real v, real pu, real pv,
                          real *x, real *y, real *z, real *dx, real *dy, real *dz) {
    real s, c;
    sincos_turns(v, &s, &c);
    const real sin_theta = ${point("cosine_point.sine", "sqrt(u)")};
    *x = splat(source[SOURCE_X]); *y = splat(source[SOURCE_Y]); *z = splat(source[SOURCE_Z]);
    from_frame(source + SOURCE_FRAME, sin_theta * c, sin_theta * s, ${point("cosine_point.cosine", "sqrt(R(1.0) - u)")}, dx, dy, dz);
}
