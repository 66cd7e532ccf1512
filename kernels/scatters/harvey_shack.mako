// Harvey-Shack: height (1 + (Delta/L)^2)^(S/2).
// t = 1 + (Delta/L)^2 of what is tried has the density t^(S/2) up to the farthest part of the disc.  Where the
// lobe is all but flat there, t - 1 would be a difference of nearly equal numbers: places are tried
// uniformly, and taken with the chance t^(S/2), which is 1/e at least.
// reads: height, shoulder L, power S/2.  gives: beta; BSDF.
FN mask try_harvey_shack(const lobe_t *s, ulong seed, mask m, draws_t *draws, real u, real v, real *x, real *y) {
    const real shoulder = lobe_number(s, SHACK_SHOULDER), far = lobe_reach(s) / shoulder;
    const real top = fma(far, far, splat(1.0));
    const power_law_t law = power_law(lobe_number(s, SHACK_POWER) + R(1.0), top);
    const real r = shoulder * sqrt(drawn_from(&law, top, u) - R(1.0));
    const mask wide = m & LE(far * far * fabs(lobe_number(s, SHACK_POWER)), splat(1.0));
    const real uniform = lobe_reach(s) * sqrt(u);
    place_about(s, SEL(wide, uniform, ${point("harvey_shack.radius", "r")}), v, x, y);
    if (!ANY(wide)) return m;
    next_draws(seed, wide, draws);
    const real t = fma(uniform / shoulder, uniform / shoulder, splat(1.0));
    const real chance = power(t, lobe_number(s, SHACK_POWER));
    return m & (~wide | LT(u01_closed_open(draws->c0, draws->c1), chance));
}
% if densities:

FN real bsdf_harvey_shack(const lobe_t *s, real square) {
    const real shoulder = lobe_number(s, SHACK_SHOULDER);
    const real t = fma(square / shoulder, R(1.0) / shoulder, splat(1.0));
    return lobe_number(s, SHACK_HEIGHT) * power(t, lobe_number(s, SHACK_POWER));
}
% endif
