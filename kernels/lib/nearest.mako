## classes: every element class of the program
// The nearest face ahead of every live lane.  Where two are equally near, the element named first
// in the file is hit.
//
// A ray that starts on a face it did not leave is doubtful: `crosses` must say whether it hits that
// face.  That is rare and slow, so the first pass only finds out whether any lane is doubtful, and a
// second, careful pass is made for all lanes where one is.
// reads: packet, geometry, codes.  gives: hit.
FN void nearest(const scene_t *scene, const packet_t *p, hit_t *h) {
    const lint left = p->left >> 2;
    for (int careful = 0; careful < 2; careful++) {
        mask doubtful = lsplat(0L);
        h->t = splat(INFINITY);
        h->code = lsplat(LONG_MAX);
        h->plane = splat(0.0);
        h->edge = lsplat(0L);
% for cls in classes:
        for (long j = scene->codes[${cls.number}]; j < scene->codes[${cls.number} + 1]; j++) {
            const long code = scene->codes[j];
            __global const double *row = scene->geometry + ELEMENT_OF(code) * ROW;
            real t;
% if cls.local:
            lint face;
            const mask ok = hit_${cls.suffix}(row, code, p, left, scene, careful, &doubtful, &t, &face);
            const lint hit_code = WITH_FACE(code, face);
% else:
            mask edge = lsplat(0L);
            const mask ok = hit_${cls.suffix}(row, code, p, EQ(left, lsplat(code)), scene, careful, &doubtful, &t, &edge);
            const lint hit_code = lsplat(code);
% endif
            const mask closer = ok & (LT(t, h->t) | (EQ(t, h->t) & LT(hit_code, h->code)));
            h->t = SEL(closer, t, h->t);
            h->code = SEL(closer, hit_code, h->code);
% if cls.flat:
            h->edge = SEL(closer, edge, h->edge);
% if cls.axis is not None:
            h->plane = SEL(closer, splat(row[${cls.axis}]), h->plane);
% endif
% endif
        }
% endfor
        if (!ANY(doubtful)) break;
    }
    h->found = p->alive & LT(h->t, splat(INFINITY));
}
