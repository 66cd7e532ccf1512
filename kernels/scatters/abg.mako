// ABg: A / (B + Delta^g) = height / (1 + (Delta/half)^g), half = B^(1/g).
// It lies under height min(1, (half/Delta)^g), and over half of that: t = (Delta/half)^2 is tried from there,
// uniform up to 1 and with the density t^(-g/2) behind it, and taken with the chance 1 / (1 + t^(g/2)), or
// that of 1/t.  Of a lobe wider than the disc (half beyond its farthest part, where squares over half^2 may
// vanish) places are tried uniformly, and taken with the chance 1 / (1 + Delta^g / B).
// reads: height, half, slope g, fall 1/B.  gives: beta; BSDF.
FN real abg_fall(const lobe_t *s, real square) {
    return power(square, R(0.5) * lobe_number(s, ABG_SLOPE)) * lobe_number(s, ABG_FALL);
}

FN mask try_abg(const lobe_t *s, ulong seed, mask m, draws_t *draws, real u, real v, real *x, real *y) {
    const real half_width = lobe_number(s, ABG_HALF), slope = lobe_number(s, ABG_SLOPE), reach = lobe_reach(s);
    const mask wide = GE(half_width, reach);
    const real unit = fmin(half_width, reach), far = reach / unit, top = fmax(far * far, splat(1.0));
    const power_law_t law = power_law(fma(R(-0.5), slope, splat(1.0)), top);
    const real at = u * (R(1.0) + law.whole);
    const mask within = LT(at, splat(1.0));
    const real outer = drawn_from(&law, top, SEL(within, splat(0.0), fmin((at - R(1.0)) / law.whole, splat(1.0))));
    const real t = SEL(within, at, outer);
    place_about(s, unit * sqrt(t), v, x, y);
    next_draws(seed, m, draws);
    const real beside = power(SEL(within, t, R(1.0) / outer), R(0.5) * slope);
    const real chance = R(1.0) / (R(1.0) + SEL(wide, abg_fall(s, reach * reach * t), beside));
    return m & LT(u01_closed_open(draws->c0, draws->c1), ${point("abg.chance", "chance")});
}
% if densities:

FN real bsdf_abg(const lobe_t *s, real square) {
    const real half_width = lobe_number(s, ABG_HALF);
    const real beside = power(square / half_width / half_width, R(0.5) * lobe_number(s, ABG_SLOPE));
    return lobe_number(s, ABG_HEIGHT) / (R(1.0) + SEL(GE(half_width, splat(1.0)), abg_fall(s, square), beside));
}
% endif
