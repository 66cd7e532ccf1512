## lanes; classes: every element class of the program; effects
// The nearest face ahead of every live lane.  Where two are equally near, the element named first
// in the file is hit.
//
// A ray that starts on a face it did not leave is doubtful: `crosses` must say whether it hits that
// face.  That is rare and slow, so the first pass only finds out whether any lane is doubtful, and a
// second, careful pass is made for all lanes where one is.
<%def name="test_element(cls)">
% if cls.local:
            lint face;
            const mask ok = hit_${cls.suffix}(row, code, p, left, scene, search, &t, &face);
            const lint hit_code = WITH_FACE(code, face);
% else:
            mask edge = lsplat(0L);
            const mask ok = hit_${cls.suffix}(row, code, p, EQ(left, lsplat(code)), scene, search, &t, &edge);
            const lint hit_code = lsplat(code);
% endif
            const mask closer = ok & (LT(t, h->t) | (EQ(t, h->t) & LT(hit_code, h->code)));
% if lanes == 1:
            // a branch that is rarely taken beats four conditional moves
            if (!closer) continue;
% endif
            h->t = SEL(closer, t, h->t);
            h->code = SEL(closer, hit_code, h->code);
% if cls.flat:
            h->edge = SEL(closer, edge, h->edge);
% if cls.axis is not None:
            h->plane = SEL(closer, splat(row[${cls.axis}]), h->plane);
% endif
% endif
</%def>
% if "acceleration" in effects:
// Through the tree of boxes (effects/acceleration.mako): only elements whose box the ray may meet no
// later than the best hit so far are tested, with the very functions of the plain scan.  Boxes are
// taken too large by more than any rounding, so the outcome has the same bits.
FN void scan(const scene_t *scene, const packet_t *p, lint left, search_t *search, hit_t *h) {
    const box_ray_t ray = box_ray(scene, p);
    uint waiting[TREE_DEPTH];
    uint n_waiting = 0;
    long node = 0;
    for (;;) {
        if (meets_box(scene, &ray, p, h->t, node)) {
            const long first = TREE_FIRST(scene, node), count = TREE_COUNT(scene, node);
            if (count == 0) {
                // the child on the side the packet comes from goes first
                const int low_first = comes_from_low(p, (int)(first & 3L));
                waiting[n_waiting++] = (uint)(low_first ? first >> 2 : node + 1);
                node = low_first ? node + 1 : first >> 2;
                continue;
            }
            for (long j = first; j < first + count; j++) {
                const long code = scene->codes[j];
                __global const double *row = scene->geometry + ELEMENT_OF(code) * ROW;
                real t;
% for n, cls in enumerate(classes):
                ${"else " if n else ""}if (CLASS_OF(code) == ${cls.number}L) {
${test_element(cls)}
                }
% endfor
            }
        }
        if (n_waiting == 0) break;
        node = waiting[--n_waiting];
    }
}
% else:
FN void scan(const scene_t *scene, const packet_t *p, lint left, search_t *search, hit_t *h) {
% for cls in classes:
    for (long j = scene->codes[${cls.number}]; j < scene->codes[${cls.number} + 1]; j++) {
        const long code = scene->codes[j];
        __global const double *row = scene->geometry + ELEMENT_OF(code) * ROW;
        real t;
${test_element(cls)}
    }
% endfor
}
% endif

// reads: packet, geometry, codes.  gives: hit.
FN void nearest(const scene_t *scene, const packet_t *p, hit_t *h) {
    const lint left = p->left >> 2;
    search_t search;
    for (search.careful = 0; search.careful < 2; search.careful++) {
        search.doubtful = lsplat(0L);
        h->t = splat(INFINITY);
        h->code = lsplat(LONG_MAX);
        h->plane = splat(0.0);
        h->edge = lsplat(0L);
        scan(scene, p, left, &search, h);
        if (!ANY(search.doubtful)) break;
    }
    h->found = p->alive & LT(h->t, splat(INFINITY));
}
