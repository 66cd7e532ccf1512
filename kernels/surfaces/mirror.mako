// Mirror: d' = d - 2 (d.n) n, weight times reflectance.
// reads: direction, normal, reflectance.  gives: the reflected ray.
FN void meet_mirror(const encounter_t *event, const material_t *material, outcome_t *outcome) {
    const packet_t *p = event->p;
    const contact_t *c = event->c;
    real x, y, z;
    reflect(p, c, &x, &y, &z);
    send_on(outcome, event->m, x, y, z, ${point("mirror.weight", "p->w * weight_number(material, MIRROR_REFLECTANCE)")},
            wsplat(REFLECTED));
% if amplitudes:
    const incident_t light = incident_light(event);
    const amplitudes_t r = conductor();
    polarise(outcome, event->m, &light, &r);
% endif
}
