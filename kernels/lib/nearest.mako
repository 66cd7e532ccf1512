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
// later than its best hit so far are tested, with the very functions of the plain scan.  Boxes are
// taken too large by more than any rounding, so the outcome has the same bits.
FN void scan(const scene_t *scene, const packet_t *p, lint left, search_t *search, hit_t *h) {
    __global const double *tree = scene->geometry + TREE_PLACE(scene);
    const double size = tree[-1];
    double entered[TREE_STACK];
    int waiting[TREE_STACK];
% if lanes == 1:
    // the flat element that the ray leaves is not hit: its row stays unread
    const long from = CLASS_OF(left);
    const int departed = ${" || ".join(f"from == {cls.number}L" for cls in classes if cls.flat) or "false"} ? (int)ELEMENT_OF(left) : -1;
    const box_ray_t ray = box_ray(p->ox, p->oy, p->oz, p->dx, p->dy, p->dz, size);
#define BEST h->t
    {
% else:
    // The ray of one lane leads; what it meets is tested for all of them.
    union { real v; double s[LANES]; } ox = {p->ox}, oy = {p->oy}, oz = {p->oz};
    union { real v; double s[LANES]; } dx = {p->dx}, dy = {p->dy}, dz = {p->dz}, best = {h->t};
#define BEST best.s[l]
    for (uint bits = lane_bits(p->alive); bits; bits &= bits - 1u) {
        const uint l = FIRST_LANE(bits);
        const box_ray_t ray = box_ray(ox.s[l], oy.s[l], oz.s[l], dx.s[l], dy.s[l], dz.s[l], size);
% endif
        int n = 1;
        waiting[0] = ~0;
        entered[0] = 0.0;
        while (n) {
            n--;
            if (entered[n] > BEST) continue;
            int link = waiting[n];
            // down to the nearest child; the others wait, the nearest last, to be taken next
            while (link < 0) {
                __global const double *node = tree + (long)~link * ${tree_node};
                __global const int *links = TREE_LINKS(node);
                union { double8 v; double s[TREE_WIDTH]; } at;
                ulong met = meet_boxes(node, &ray, BEST, &at.v);
                if (!met) break;
                int k = FIRST_BYTE(met);
                link = links[k];
                met &= met - 1UL;
                if (!met) continue;
                double begins = at.s[k];
                const int first = n;
                for (; met; met &= met - 1UL) {
                    k = FIRST_BYTE(met);
                    double later = at.s[k];
                    int other = links[k];
                    if (later < begins) {
                        const double d = begins; begins = later; later = d;
                        const int nearer = other; other = link; link = nearer;
                    }
                    int i = n++;
                    for (; i > first && entered[i - 1] < later; i--) {
                        entered[i] = entered[i - 1];
                        waiting[i] = waiting[i - 1];
                    }
                    entered[i] = later;
                    waiting[i] = other;
                }
            }
${"            if (link < 0 || link == departed) continue;" if lanes == 1 else "            if (link < 0) continue;"}
            __global const double *row = scene->geometry + (long)link * ROW;
            const long code = CODE_AT(scene, link);
            real t;
            switch ((int)CLASS_OF(code)) {
% for cls in classes:
            case ${cls.number}: {
${test_element(cls)}
                break;
            }
% endfor
            }
% if lanes > 1:
            best.v = h->t;
% endif
        }
    }
#undef BEST
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
% if "contact" in effects:
% for n in range(note_words):
        search.noted.word${n} = lsplat(-1L);
% endfor
% endif
        h->t = splat(INFINITY);
        h->code = lsplat(LONG_MAX);
        h->plane = splat(0.0);
        h->edge = lsplat(0L);
        scan(scene, p, left, &search, h);
        if (!ANY(search.doubtful)) break;
    }
% if "contact" in effects:
    h->noted = search.noted;
% endif
    h->found = p->alive & LT(h->t, splat(INFINITY));
}
