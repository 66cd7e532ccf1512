## cls: the element class; lanes, orders, effects; rendered once a class
// An element of the class is asked whether a ray meets it, and where nearer than what it has met so
// far, `h` becomes that.  Where two are equally near, the element named first in the file is hit.
% if orders:
// While the order of faces in one place is settled, it is offered for that instead.
% endif
// reads: the element's row and code, packet, what the ray left.  writes: hit.
FN void meet_${cls.suffix}(const scene_t *scene, __global const double *row, long code, const packet_t *p, lint left,
                       search_t *search, hit_t *h) {
    real t;
% if cls.faced:
    lint face;
    const mask ok = hit_${cls.suffix}(row, code, p, left, scene, search, &t, &face);
    const lint hit_code = ${"with_surface(row, WITH_FACE(code, face))" if "face-surfaces" in effects and "own-surfaces" in cls.traits else "WITH_FACE(code, face)"};
% else:
    mask edge = NO_LANES;
    const mask ok = hit_${cls.suffix}(row, code, p, IEQ(left, lsplat(code)), scene, search, &t, &edge);
    const lint hit_code = lsplat(code);
% endif
% if orders:
    if (search->settling) {
        const mask asked = ok & search->shared & IN_OTHERS(hit_code);
        if (!ANY(asked)) return;
        hit_t there = *h;
        there.t = t;
        there.code = hit_code;
        there.edge = ${"edge" if cls.flat else "NO_LANES"};
        there.plane = ${f"splat(row[ROW_X + {cls.axis}])" if cls.flat and cls.axis is not None else "h->plane"};
        contact_t c = no_contact(p, t);
        place_${cls.suffix}(scene, p, &there, asked, &c);
        settle(search, p, asked, h->t, t, hit_code, there.plane, there.edge, &c, splat(row[COINCIDENCE_ROOM]));
        return;
    }
% endif
    const mask closer = ok & (LT(t, h->t) | (EQ(t, h->t) & ${point("meet.first_named", "ILT(hit_code, h->code)")}));
% if lanes == 1:
    // a branch that is rarely taken beats four conditional moves
    if (!closer) return;
% endif
    h->t = SEL(closer, t, h->t);
    h->code = SELI(closer, hit_code, h->code);
% if cls.flat:
    h->edge = SELM(closer, edge, h->edge);
% if cls.axis is not None:
    h->plane = SEL(closer, splat(row[ROW_X + ${cls.axis}]), h->plane);
% endif
% endif
}
