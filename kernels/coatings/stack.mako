// A stack of thin films: plane waves, by the layers' characteristic matrices (Born & Wolf 1.6.2; Macleod,
// Thin-Film Optical Filters, 2.7), from the medium behind the face to that before it.
//
// With e^(-i omega t) a layer of index N = n + i kappa has q = N cos(theta) = sqrt(N^2 - n1^2 sin^2), of no
// negative imaginary part, beta = 2 pi d q / lambda, and the fields along the face at its two sides are
//   E' = cos(beta) E - i (sin(beta)/eta) H,   H' = cos(beta) H - i eta sin(beta) E,
// eta = q for s and q/N^2 for p.  Both are multiplied by e^(-Im beta), so that nothing grows, however thick
// and absorbing a layer is; they follow the wave that grows towards the light, which keeps its errors small.
// sin(beta)/q is 2 pi d / lambda where q is 0: at a layer's own critical angle nothing is divided by it.
// reads: wavelength, indices on both sides; layers.  gives: the parts, of unpolarised light half of what is polarised along s and along p;
// of polarised light the amplitudes as well.
typedef struct { real x, y; } complex_t;

FN complex_t times(complex_t a, complex_t b) {
    complex_t c = {fma(a.x, b.x, -(a.y * b.y)), fma(a.x, b.y, a.y * b.x)};
    return c;
}
// c - i a b
FN complex_t less_i_times(complex_t c, complex_t a, complex_t b) {
    const complex_t d = times(a, b);
    complex_t e = {c.x + d.y, c.y - d.x};
    return e;
}
% if amplitudes:
FN complex_t reversed(complex_t a) {
    const complex_t b = {a.x, -a.y};
    return b;
}
% endif
FN real squared(complex_t a) { return fma(a.x, a.x, a.y * a.y); }
FN complex_t chosen(mask m, complex_t a, complex_t b) {
    complex_t c = {SEL(m, a.x, b.x), SEL(m, a.y, b.y)};
    return c;
}

// What comes of a wave of one polarisation: the field along the face is reflected by r = back/on, and the
// electric one in the sense of Born & Wolf 1.5.2 by the same; sqrt(share) passed/on is the amplitude that
// passes, of which the square is a part of the power.  share is 0 beyond the critical angle.
typedef struct {
    complex_t e, h, back, on;
    real passed, share;
} wave_t;

FN void cross_layer(wave_t *w, mask m, complex_t c, complex_t over, complex_t by, real decay) {
    complex_t e = less_i_times(times(c, w->e), over, w->h);
    complex_t h = less_i_times(times(c, w->h), by, w->e);
    const real k = R(1.0) / (fabs(e.x) + fabs(e.y) + fabs(h.x) + fabs(h.y));
    e.x *= k; e.y *= k; h.x *= k; h.y *= k;
    w->e = chosen(m, e, w->e);
    w->h = chosen(m, h, w->h);
    w->passed = SEL(m, w->passed * (decay * k), w->passed);
}

// The admittances of the media before and behind the face are near and far, of which the latter is
// imaginary beyond the critical angle.
FN wave_t wave_behind(complex_t far) {
    wave_t w;
    w.e.x = splat(1.0); w.e.y = splat(0.0);
    w.h = far;
    w.passed = splat(1.0);
    w.share = far.x;
    return w;
}
FN void meet_wave(wave_t *w, real near) {
    const complex_t e = {near * w->e.x, near * w->e.y};
    w->back.x = e.x - w->h.x; w->back.y = e.y - w->h.y;
    w->on.x = e.x + w->h.x; w->on.y = e.y + w->h.y;
    w->share *= R(4.0) * near;
}
FN real reflected_part(const wave_t *w) { return squared(w->back) / squared(w->on); }
FN real passed_part(const wave_t *w) { return w->share * (w->passed * w->passed) / squared(w->on); }

FN void stack_waves(const film_t *film, mask m, wave_t *s, wave_t *p) {
    __global const double *table = film->material->scene->geometry;
    const lint first = SELI(m, film_place(film, COATING_NODES), lsplat(0L));
    const lint count = SELI(m, film_place(film, COATING_COUNT), lsplat(0L));
    const real outside = material_number(film->material, STACK_COATING_OUTSIDE);
    const real inside = material_number(film->material, STACK_COATING_INSIDE);
    const real n1 = SEL(film->plus, outside, inside), n2 = SEL(film->plus, inside, outside);
    const real wave = R(1.0) / material_number(film->material, STACK_COATING_NM);
    const real n11 = n1 * n1, along = n11 * film->sin2, straight = n11 * (film->ci * film->ci);
    const complex_t far = {film->ct, sqrt(fmax(-film->ct2, splat(0.0)))};
    const complex_t far_s = {n2 * far.x, n2 * far.y}, far_p = {far.x / n2, far.y / n2};
    *s = wave_behind(far_s);
    *p = wave_behind(far_p);
    for (long k = 0; ANY(m & ILT(lsplat(k), count)); k++) {
        const mask there = m & ILT(lsplat(k), count);
        // from the medium behind the face on: layers stand from outside to inside
        const lint number = ${point("stack.order", "SELI(film->plus, count - 1L - k, lsplat(k))")};
        const lint at = first + SELI(there, number, lsplat(0L)) * SIZE_OF_LAYER;
        const real n = gather(table + LAYER_INDEX, at), kappa = gather(table + LAYER_EXTINCTION, at);
        const real turns = gather(table + LAYER_THICKNESS, at) * wave;
        const complex_t inverse = {gather(table + LAYER_INVERSE, at), gather(table + LAYER_INVERSE_IMAGINARY, at)};
        const real nn = n * n;
        const complex_t square = {fma(-kappa, kappa, nn), R(2.0) * n * kappa};
        // q^2, from a difference of indices, or from the sine where that cancels less; and its root
        const real bare = SEL(GT(n11, R(2.0) * nn), nn - along, fma(n - n1, n + n1, straight));
        const real q2 = fma(-kappa, kappa, bare), size = sqrt(fma(q2, q2, square.y * square.y));
        const real large = sqrt(R(0.5) * (size + fabs(q2)));
        const real small = R(0.5) * square.y / SEL(GT(large, splat(0.0)), large, splat(1.0));
        const mask waves = GE(q2, splat(0.0));
        const complex_t q = {SEL(waves, large, small), SEL(waves, small, large)};
        real sine, cosine;
        const real phase = turns * q.x;
        sincos_turns(phase - floor(phase), &sine, &cosine);
        // e^(-b) cosh b, e^(-b) sinh b and e^(-b)
        real up = splat(1.0), down = splat(0.0), decay = splat(1.0);
        const real b = R(0x1.921fb54442d18p+2) * turns * q.y;
        if (ANY(there & GT(b, splat(0.0)))) {
            decay = exponential(-b);
            const real twice = R(2.0) * b;
            real series = splat(1.0);
% for k in range(14, 1, -1):
            series = fma(twice * R(-1.0 / ${k}.0), series, splat(1.0));
% endfor
            up = R(0.5) * fma(decay, decay, splat(1.0));
            down = SEL(LT(twice, splat(0.5)), b * series, R(0.5) * fma(-decay, decay, splat(1.0)));
        }
        const complex_t c = {cosine * up, -sine * down}, si = {sine * up, cosine * down};
        const real qq = squared(q);
        const mask some = GT(qq, splat(0.0));
        const real per = R(1.0) / SEL(some, qq, splat(1.0));
        const complex_t turned = {q.x * per, -q.y * per}, all = {R(0x1.921fb54442d18p+2) * turns, splat(0.0)};
        const complex_t over = chosen(some, times(si, turned), all), by = times(si, q);
        cross_layer(s, there, c, over, by, decay);
        cross_layer(p, there, c, times(over, square), times(by, inverse), decay);
    }
    meet_wave(s, n1 * film->ci);
    meet_wave(p, film->ci / n1);
}

FN void coat_stack(const film_t *film, mask m, weight *r, weight *t) {
    wave_t s, p;
    stack_waves(film, m, &s, &p);
% if amplitudes:
    // a_s and a_p of what is reflected are back/on, and of what passes sqrt(share) passed/on
    const real on_s = squared(s.on), on_p = squared(p.on), both = R(1.0) / (on_s * on_p);
    const complex_t turned = times(reversed(s.on), p.on);
    const complex_t reflected = times(times(s.back, reversed(p.back)), turned);
    const real passed = sqrt(s.share * p.share) * (s.passed * p.passed) * both;
    const amplitudes_t back = {reflected_part(&s), reflected_part(&p), reflected.x * both, reflected.y * both};
    const amplitudes_t on = {passed_part(&s), passed_part(&p), turned.x * passed, turned.y * passed};
    *film->back = chosen_amplitudes(m, back, *film->back);
    *film->on = chosen_amplitudes(m, on, *film->on);
    *r = TO_WEIGHT(${point("stack.polarised", "part_of(film->light, &back)")});
    *t = TO_WEIGHT(part_of(film->light, &on));
% else:
    *r = TO_WEIGHT(${point("stack.reflected", "R(0.5) * (reflected_part(&s) + reflected_part(&p))")});
    *t = TO_WEIGHT(${point("stack.passed", "R(0.5) * (passed_part(&s) + passed_part(&p))")});
% endif
}
