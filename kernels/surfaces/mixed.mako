## surface: the kind, whose .splits says whether any of its elements has both children
// Mixed: a mirror child and a Lambertian child; what neither takes is absorbed.
// The smaller child has no more than the larger one leaves, a difference that is exact where it matters:
// no rounding absorbs less than nothing.
// reads: direction, normal, side, specular and diffuse reflectance, draw DECIDE_SCATTER.
// gives: the specular ray and the diffuse one beside it; the diffuse one alone where nothing is specular.
FN void meet_mixed(const encounter_t *event, const material_t *material, outcome_t *outcome) {
    const packet_t *p = event->p;
    const weight s = weight_number(material, MIXED_SPECULAR), d = weight_number(material, MIXED_DIFFUSE);
    const weight large = p->w * ${point("mixed.larger", "fmax(s, d)")}, small = fmin(p->w * fmin(s, d), p->w - large);
    const mask shines = WEIGHT_GE(s, d);
    const weight w_specular = SEL_WEIGHT(shines, large, small), w_diffuse = SEL_WEIGHT(shines, small, large);
    real sx, sy, sz, x, y, z;
    reflect(p, event->c, &sx, &sy, &sz);
    scatter_diffusely(event->seed, p, event->c, &x, &y, &z);
    const mask specular = WEIGHT_GT(w_specular, weight_splat(0.0));
    send_on(outcome, event->m, ${point("mixed.first", "SEL(specular, sx, x)")}, SEL(specular, sy, y), SEL(specular, sz, z),
            SEL_WEIGHT(specular, w_specular, w_diffuse), SELW(specular, wsplat(REFLECTED), wsplat(SCATTERED)));
% if amplitudes:
    // a matt child is unpolarised
    const incident_t light = incident_light(event);
    const amplitudes_t r = conductor();
    polarise(outcome, ${point("mixed.polarised", "event->m & specular")}, &light, &r);
% endif
% if surface.splits:
    send_second(outcome, event->m & specular & WEIGHT_GT(w_diffuse, weight_splat(0.0)), x, y, z, w_diffuse,
                wsplat(SCATTERED));
% endif
% if densities:
    scattered(outcome, event->m & WEIGHT_GT(w_diffuse, weight_splat(0.0)), specular, w_diffuse);
% endif
}
% if densities:

FN real density_mixed(const encounter_t *event, const material_t *material, real x, real y, real z) {
    return diffuse_density(event->c, x, y, z);
}
% endif
