// Mirror: d' = d - 2 (d.n) n, weight times reflectance.
// reads: direction, normal, material 0 (reflectance).  writes: direction and weight after, side.
FN void meet_mirror(mask m, const packet_t *p, const contact_t *c, real reflectance,
                    real *dx, real *dy, real *dz, real *after, mask *went_plus) {
    const real k = -2.0 * dot3(p->dx, p->dy, p->dz, c->nx, c->ny, c->nz);
    real x = fma(k, c->nx, p->dx), y = fma(k, c->ny, p->dy), z = fma(k, c->nz, p->dz);
    renormalise(&x, &y, &z);
    *dx = SEL(m, x, *dx); *dy = SEL(m, y, *dy); *dz = SEL(m, z, *dz);
    *after = SEL(m, p->w * reflectance, *after);
    *went_plus = SEL(m, c->came_plus, *went_plus);
}
