## classes: every element class of the program
// Where the ray meets what it hit: the point, put back onto the face, its outward normal, and the
// side the ray came from.
// reads: packet, hit, geometry.  gives: contact.
FN void locate(const scene_t *scene, const packet_t *p, const hit_t *h, contact_t *c) {
    *c = no_contact(p, h->t);
% for cls in classes:
    place_${cls.suffix}(scene, p, h, h->found & IEQ(CLASS_OF(h->code), lsplat(${cls.number}L)), c);
% endfor
    c->came_plus = came_from_plus(p, c);
}
