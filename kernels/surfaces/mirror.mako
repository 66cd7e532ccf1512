## coats (whether there are coatings: a reflectance by angle is a table of its own)
// Mirror: d' = d - 2 (d.n) n, weight times reflectance.
// reads: direction, normal, reflectance.  gives: the reflected ray.
FN void meet_mirror(const encounter_t *event, const material_t *material, outcome_t *outcome) {
    const packet_t *p = event->p;
    const contact_t *c = event->c;
    real x, y, z;
    reflect(p, c, &x, &y, &z);
% if amplitudes:
    const incident_t light = incident_light(event);
    amplitudes_t r = conductor(), none_passes;
% endif
% if coats:
    weight w = p->w * weight_number(material, MIRROR_REFLECTANCE), none = weight_splat(0.0);
    const real dn = dot3(p->dx, p->dy, p->dz, c->nx, c->ny, c->nz), ci = fmin(fabs(dn), splat(1.0));
    const real sx = fma(-dn, c->nx, p->dx), sy = fma(-dn, c->ny, p->dy), sz = fma(-dn, c->nz, p->dz);
    coat(event, material, NO_LANES, ci, dot3(sx, sy, sz, sx, sy, sz), ci, ci * ci, splat(1.0), &w, &none${", &light, &r, &none_passes" if amplitudes else ""});
    send_on(outcome, event->m, x, y, z, w, wsplat(REFLECTED));
% else:
    send_on(outcome, event->m, x, y, z, ${point("mirror.weight", "p->w * weight_number(material, MIRROR_REFLECTANCE)")},
            wsplat(REFLECTED));
% endif
% if amplitudes:
    polarise(outcome, event->m, &light, &r);
% endif
}
