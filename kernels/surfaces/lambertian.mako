// Lambertian: cosine lobe about the normal on the side that was hit, weight times reflectance.
// reads: normal, side, reflectance, draw DECIDE_SCATTER.  gives: the scattered ray.
FN void meet_lambertian(const encounter_t *event, const material_t *material, outcome_t *outcome) {
    const packet_t *p = event->p;
    real x, y, z;
    scatter_diffusely(event->seed, p, event->c, &x, &y, &z);
    send_on(outcome, event->m, x, y, z, ${point("lambertian.weight", "p->w * weight_number(material, LAMBERTIAN_REFLECTANCE)")},
            wsplat(SCATTERED));
% if densities:
    scattered(outcome, event->m, NO_LANES, p->w * weight_number(material, LAMBERTIAN_REFLECTANCE));
% endif
}
% if densities:

FN real density_lambertian(const encounter_t *event, const material_t *material, real x, real y, real z) {
    return diffuse_density(event->c, x, y, z);
}
% endif
