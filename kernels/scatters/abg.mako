// ABg: A / (B + Delta^g) = height / (1 + (Delta/half)^g), half = B^(1/g).
// It lies under height min(1, (half/Delta)^g), and over half of that: t = (Delta/half)^2 is tried from there,
// uniform up to 1 and with the density t^(-g/2) behind it, and taken with the chance 1 / (1 + t^(g/2)), or
// that of 1/t.
// reads: height, half, slope g.  gives: beta; BSDF.
FN mask try_abg(const lobe_t *s, ulong seed, mask m, draws_t *draws, real u, real v, real *x, real *y) {
    const real half_width = lobe_number(s, ABG_HALF), slope = lobe_number(s, ABG_SLOPE);
    const real far = lobe_reach(s) / half_width, top = far * far;
    const power_law_t law = power_law(fma(R(-0.5), slope, splat(1.0)), fmax(top, splat(1.0)));
    const real inner = fmin(top, splat(1.0)), sum = inner + law.whole, at = u * sum;
    const mask within = LT(at, inner);
    const real outer = drawn_from(&law, fmax(top, splat(1.0)), clamp((at - inner) / fmax(law.whole, splat(1e-30)), splat(0.0), splat(1.0)));
    const real t = SEL(within, at, outer);
    place_about(s, half_width * sqrt(t), v, x, y);
    next_draws(seed, m, draws);
    const real chance = R(1.0) / (R(1.0) + power(SEL(within, t, R(1.0) / outer), R(0.5) * slope));
    return m & LT(u01_closed_open(draws->c0, draws->c1), ${point("abg.chance", "chance")});
}
% if densities:

FN real bsdf_abg(const lobe_t *s, real square) {
    const real half_width = lobe_number(s, ABG_HALF);
    const real t = square / half_width / half_width;
    return lobe_number(s, ABG_HEIGHT) / (R(1.0) + power(t, R(0.5) * lobe_number(s, ABG_SLOPE)));
}
% endif
