## classes: every element class of the program
// Where the ray meets what it hit: the point, put back onto the face, its outward normal, and the
// side the ray came from.
// reads: packet, hit, geometry.  gives: contact.
FN void locate(const scene_t *scene, const packet_t *p, const hit_t *h, contact_t *c) {
    c->x = fma(h->t, p->dx, p->ox);
    c->y = fma(h->t, p->dy, p->oy);
    c->z = fma(h->t, p->dz, p->oz);
    c->nx = splat(0.0); c->ny = splat(0.0); c->nz = splat(0.0);
    c->from_minus = NO_LANES;
    c->from_plus = NO_LANES;
    c->inner = NO_LANES;
% for cls in classes:
    place_${cls.suffix}(scene, p, h, h->found & IEQ(CLASS_OF(h->code), lsplat(${cls.number}L)), c);
% endfor
    c->came_plus = (LE(dot3(p->dx, p->dy, p->dz, c->nx, c->ny, c->nz), splat(0.0)) & ~c->from_minus) | c->from_plus;
}
