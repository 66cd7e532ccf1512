// Gaussian lobe: height exp(-Delta^2 / 2 sigma^2).
// Delta of what is tried: the inverse of 1 - exp(-Delta^2 / 2 sigma^2), up to the farthest part of the disc.
// Of a lobe wider than the disc, where that is a difference of nearly equal numbers, places are tried
// uniformly, and taken with the chance exp(-Delta^2 / 2 sigma^2), which is 0.6 at least.
// reads: height, sigma.  gives: beta; BSDF.
FN mask try_gaussian(const lobe_t *s, ulong seed, mask m, draws_t *draws, real u, real v, real *x, real *y) {
    const real sigma = lobe_number(s, GAUSS_SIGMA), far = lobe_reach(s) / sigma;
    const real part = R(1.0) - exponential(R(-0.5) * far * far);
    const real r = sigma * sqrt(fmax(R(-2.0) * natural_log(fma(-u, part, splat(1.0))), splat(0.0)));
    const mask wide = m & GE(sigma, lobe_reach(s));
    const real uniform = lobe_reach(s) * sqrt(u);
    place_about(s, SEL(wide, uniform, ${point("gaussian.radius", "r")}), v, x, y);
    if (!ANY(wide)) return m;
    next_draws(seed, wide, draws);
    const real chance = exponential(R(-0.5) * (uniform / sigma) * (uniform / sigma));
    return m & (~wide | LT(u01_closed_open(draws->c0, draws->c1), chance));
}
% if densities:

FN real bsdf_gaussian(const lobe_t *s, real square) {
    const real sigma = lobe_number(s, GAUSS_SIGMA);
    return lobe_number(s, GAUSS_HEIGHT) * exponential(R(-0.5) * square / (sigma * sigma));
}
% endif
