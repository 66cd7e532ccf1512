// A table over the angle outside: linear between nodes, which go from 0 to 90 degrees.
// A ray from inside is looked up at the angle at which it leaves, at 90 degrees where it does not.
// reads: nodes.  gives: the parts.
FN void coat_table(const film_t *film, mask m, weight *r, weight *t) {
    __global const double *table = film->material->scene->geometry;
    // lanes of other coatings read what there always is
    const lint first = SELI(m, film_place(film, COATING_NODES), lsplat(0L));
    const lint last = SELI(m, film_place(film, COATING_COUNT), lsplat(2L)) - 2L;
    const real sine = sqrt(film->sin2);
    const real angle = ${point("table.angle", "degrees_of(SEL(film->plus, sine, film->m * sine), SEL(film->plus, film->ci, film->ct))")};
    // the last node that is not above it, and has one behind it
    lint at = lsplat(0L);
    long step = 1;
    while (ANY(MASK_OF(INT_MASK(ILE(lsplat(2 * step), last))))) step *= 2;
    for (; step > 0; step >>= 1) {
        const lint next = at + step;
        const mask there = ILE(next, last);
        const mask up = there & LE(gather(table + ANGLE_NODE_ANGLE, first + SELI(there, next, at) * SIZE_OF_ANGLE_NODE), angle);
        at = SELI(up, next, at);
    }
    const lint node = first + at * SIZE_OF_ANGLE_NODE, next = node + SIZE_OF_ANGLE_NODE;
    const real way = (angle - gather(table + ANGLE_NODE_ANGLE, node)) * gather(table + ANGLE_NODE_DENSITY, node);
    const weight part = TO_WEIGHT(clamp(way, splat(0.0), splat(1.0)));
    const weight low_r = gather_weight(table + ANGLE_NODE_REFLECTANCE, node);
    const weight low_t = gather_weight(table + ANGLE_NODE_TRANSMITTANCE, node);
    *r = fma(part, gather_weight(table + ANGLE_NODE_REFLECTANCE, next) - low_r, low_r);
    *t = fma(part, gather_weight(table + ANGLE_NODE_TRANSMITTANCE, next) - low_t, low_t);
}
