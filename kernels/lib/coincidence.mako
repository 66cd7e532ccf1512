## surfaces (kinds in use: .number, .counts, .refracts); rendered once a program
// Which of several faces that lie in one place a ray meets first.
//
// What their surfaces are decides, and only then the order in the file: first a refracting face that
// the ray meets from behind its normal, as it leaves that body; then those that it passes as if
// nothing were there; then opaque ones; then refracting ones that it meets from outside.  So bodies in
// contact have a film of their outside medium between them, whatever their order in the file.
//
// Of two faces in one place rounding decides which is nearer.  So where the nearest face may lie in
// others, a second search looks at all that is met there.  What is `there` follows from the nearest
// face and the other one alone, so that the order of the search does not matter: they have one tangent
// plane, and are no farther apart along its normal than their rounding can bring them.

#define IN_OTHERS(code) INE((code) & (1L << ${code["coincident"].shift}), lsplat(0L))
// Rounding of a point on a ray, relative to its coordinates, eight times over.
#define COINCIDENT R(0x1p8 * UNIT_ROUNDOFF)
% if real == "double":
// No face that is there is farther off than the nearest by more than this part of the way: then a ray
// runs along it at less than 2^-35 rad.
#define FARTHEST R(0x1p43 * UNIT_ROUNDOFF)
// The cosine of normals of one tangent plane is no less, 2^-14.5 rad apart.
#define PARALLEL R(1.0 - 0x1p23 * UNIT_ROUNDOFF)
% else:
// The same with rays at less than 2^-11 rad, and normals 2^-8.5 rad apart.
#define FARTHEST R(0x1p19 * UNIT_ROUNDOFF)
#define PARALLEL R(1.0 - 0x1p6 * UNIT_ROUNDOFF)
% endif
#define NO_RANK LONG_MAX

FN void locate(const scene_t *scene, const packet_t *p, const hit_t *h, contact_t *c);

FN lint rank_of(lint code, mask from_behind) {
    lint rank = lsplat(2L);
% for kind in surfaces:
% if kind.refracts:
    rank = SELI(IEQ(SURFACE_OF(code), lsplat(${kind.number}L)), ${point("coincidence.refracting", "SELI(from_behind, lsplat(0L), lsplat(3L))")}, rank);
% elif not kind.counts:
    rank = SELI(IEQ(SURFACE_OF(code), lsplat(${kind.number}L)), ${point("coincidence.clear", "lsplat(1L)")}, rank);
% endif
% endfor
    return rank;
}

// Whether a second search is to be made for any lane.  Then h->t becomes how far it has to look.
FN bool begin_settling(const scene_t *scene, search_t *search, const packet_t *p, hit_t *h) {
    search->settling = 1;
    search->shared = h->found & IN_OTHERS(h->code);
    if (!ANY(search->shared)) return false;
    const lint row = SELI(search->shared, ELEMENT_OF(h->code) * ROW, lsplat(0L));
    const real origin = fabs(p->ox) + fabs(p->oy) + fabs(p->oz);
    contact_t c;
    locate(scene, p, h, &c);
    search->nx = c.nx; search->ny = c.ny; search->nz = c.nz;
    search->room = fma(origin + h->t, COINCIDENT, gather(scene->geometry + COINCIDENCE_ROOM, row));
    search->nearest = h->t;
    search->code = h->code;
    search->plane = h->plane;
    search->edge = h->edge;
    search->rank = lsplat(NO_RANK);
    h->t = SEL(search->shared, fma(origin + h->t, FARTHEST, h->t), h->t);
    return true;
}

// A face that is met, in the lanes of m, with its contact.  room: for the rounding of its element.
FN void settle(search_t *search, const packet_t *p, mask m, real farthest, real t, lint code, real plane, mask edge,
               const contact_t *c, real room) {
    const real d_n = dot3(p->dx, p->dy, p->dz, c->nx, c->ny, c->nz);
    // faces in one place have one tangent plane there; a wall and the floor on which it stands do not
    const real along = fabs(dot3(search->nx, search->ny, search->nz, c->nx, c->ny, c->nz));
    // at its edge a face takes no precedence: put back onto it, a ray could be behind a wall that ends there
    // where a face is met where the ray starts, the one that it left is at the far end of a chord, however short
    const mask far_end = EQ(search->nearest, splat(0.0)) & IEQ(code, p->left >> 2);
    const mask there = EQ(t, search->nearest)
        | (LE(fabs((t - search->nearest) * d_n), ${point("coincidence.room", "(search->room + room)")}) & LE(t, farthest) & ~far_end & ~edge
           & ${point("coincidence.parallel", "GE(along, PARALLEL)")});
    const lint rank = rank_of(code, ~came_from_plus(p, c));
    const mask first = m & there & (ILT(rank, search->rank) | (IEQ(rank, search->rank) & ILT(code, search->code)));
    search->code = SELI(first, code, search->code);
    search->plane = SEL(first, plane, search->plane);
    search->edge = SELM(first, edge, search->edge);
    search->rank = SELI(first, rank, search->rank);
}

FN void end_settling(const search_t *search, hit_t *h) {
    // where the nearest one is: beyond it, though no farther than rounding along the normal, there may be a
    // wall that stands on it.  The point is put onto the face that comes first.
    h->t = SEL(search->shared, search->nearest, h->t);
    h->code = SELI(search->shared, search->code, h->code);
    h->plane = SEL(search->shared, search->plane, h->plane);
    h->edge = SELM(search->shared, search->edge, h->edge);
}
