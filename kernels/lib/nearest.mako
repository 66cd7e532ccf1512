## classes: every element class of the program
// The nearest face ahead of every live lane.  Where two are equally near, the element named first
// in the file is hit.
// reads: packet, geometry, codes.  gives: hit.
FN void nearest(const scene_t *scene, const packet_t *p, hit_t *h) {
    h->t = splat(INFINITY);
    h->code = lsplat(LONG_MAX);
    h->plane = splat(0.0);
    h->edge = lsplat(0L);
    const lint left = p->left >> 2;
% for cls in classes:
    for (long j = scene->codes[${cls.number}]; j < scene->codes[${cls.number} + 1]; j++) {
        const long code = scene->codes[j];
        __global const double *row = scene->geometry + ELEMENT_OF(code) * ROW;
        real t;
        mask edge = lsplat(0L);
        const mask ok = hit_${cls.suffix}(row, p, EQ(left, lsplat(code)), scene, &t, &edge);
        const mask closer = ok & (LT(t, h->t) | (EQ(t, h->t) & LT(lsplat(code), h->code)));
        h->t = SEL(closer, t, h->t);
        h->code = SEL(closer, lsplat(code), h->code);
% if cls.flat:
        h->edge = SEL(closer, edge, h->edge);
% if cls.axis is not None:
        h->plane = SEL(closer, splat(row[${cls.axis}]), h->plane);
% endif
% endif
    }
% endfor
    h->found = p->alive & LT(h->t, splat(INFINITY));
}
