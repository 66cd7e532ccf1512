## lanes, effects, real, weight, ledger_rows; counts (media: those of the scene; media_counted: whether wrong ones are counted)
// Media: a ray carries the number of the medium that it is in, and loses weight on its way through it.
//
// Number 0 is the vacuum, then come the scene's media in order, then one without a name: what lies beside
// a border that has an index there and no medium.
//
// Beer and Lambert: w exp(-alpha s) is left of w behind a way s.  The product is taken to twice the
// precision, so that what is left is good to two roundings however much is lost.
// reads: packet, hit; absorption of the media, media of sources and of the elements' sides.
// gives: weight behind a segment, medium behind an interaction; writes: rows absorbed_in, counts of mismatches.

// The medium in which a launched ray starts.
FN lint medium_of_source(const launch_t *launch, const scene_t *scene, wide ray) {
    lint medium = lsplat(0L);
    for (ulong s = 0; s < launch->n_sources; s++) {
        __global const double *source = scene->sources + s * SOURCE_STRIDE;
        const mask k = IGE(ray, (wide)(source[SOURCE_FIRST_RAY])) & ILT(ray, (wide)(source[SOURCE_END_RAY]));
        medium = SELI(k, lsplat(scene->codes[launch->source_media + s]), medium);
    }
    return medium;
}

// What lies on a side of the face that is met: number << 1 | whether its surface names it, -1 where that
// is no border.
FN lint medium_beside(const launch_t *launch, const scene_t *scene, mask met, lint code, mask plus) {
    const lint place = SELI(met, ${"material_of_face(code)" if "face-surfaces" in effects else "ELEMENT_OF(code)"}, lsplat(0L));
    return gather_long(scene->codes + launch->side_media, (place << 1) | (INT_MASK(plus) & 1L));
}

// The medium of the ray that goes on: another one where it crosses a border.
FN lint medium_behind(const launch_t *launch, const scene_t *scene, const packet_t *p, const contact_t *c, mask met,
                      lint code, mask went_plus) {
    const lint side = medium_beside(launch, scene, met, code, went_plus);
    const mask crosses = met & (went_plus ^ c->came_plus) & IGE(side, lsplat(0L));
    return SELI(${point("media.crosses", "crosses")}, side >> 1, p->medium);
}

// What a segment loses, before its end is met.  What leaves the scene goes on for ever; a ray of which
// nothing is left ends on its way.
FN void absorb(const launch_t *launch, const scene_t *scene, ledger_t *ledger, packet_t *p, const hit_t *h) {
    __global const double *table = scene->geometry + launch->absorption;
<%
    degree = counts.get("band_degree", 0)
    places = [lane("place" if "line" in ray_long else "p->medium", l) for l in range(lanes)]
    numbers = lambda k: ["table[" + place + (f" + {k}" if degree else "") + "]" for place in places]
    number = lambda k: numbers(k)[0] if len(places) == 1 else "(wide)(" + ", ".join(numbers(k)) + ")"
%>
% if degree:
    const lint place = (p->medium * (long)launch->pieces + p->piece) * ${degree + 1}L;
% elif "line" in ray_long:
    const lint place = ${point("media.line", "p->medium * (long)launch->lines + p->line")};
% endif
    ${"const " if not degree else ""}wide alpha = ${number(degree)};
% for k in range(degree - 1, -1, -1):
    alpha = fma(alpha, ${point("media.along", "TO_WIDE(p->along)")}, ${number(k)});
% endfor
    const mask m = p->alive & IGT(alpha, (wide)(0.0));
    if (!ANY(m)) return;
    const wide s = ${point("media.length", "TO_WIDE(h->t)")};
    const wide product = alpha * s;
    const wide kept = twofold_exp(-product, -fma(alpha, s, -product));
% if real == weight:
    const weight left = p->w * TO_REAL(kept);
% else:
    const weight left = p->w * kept;
% endif
    const weight after = SEL_WEIGHT(m, ${point("media.left", "left")}, p->w);
    const image_t lost = image_difference(image_of(p->w), ${point("media.booked", "image_of(after)")});
% if ledger_rows:
% for k in range(1, counts["media"] + 1):
    book_row(launch, ledger, ROW_ABSORBED_IN_${k}, m & IEQ(p->medium, lsplat(${k}L)), lost);
% endfor
% elif counts["media"]:
    book(ledger, lsplat((long)launch->n_elements + ROW_ABSORBED_IN_1 - 1) + p->medium, m, lost);
% endif
    p->w = after;
    p->alive &= ~m | WEIGHT_GT(after, weight_splat(0.0));
}
% if counts["media_counted"]:

// Counts, by element, the rays that meet a surface which names another medium than they are in.
FN void count_mismatches(const launch_t *launch, const scene_t *scene, const ledger_t *ledger, const packet_t *p,
                         const contact_t *c, mask met, lint code) {
    const lint side = medium_beside(launch, scene, met, code, c->came_plus);
    const mask wrong = met & IGE(side, lsplat(0L)) & INE(side & 1L, lsplat(0L)) & ${point("media.wrong", "INE(side >> 1, p->medium)")};
    if (ANY(wrong)) count_weights(ledger, launch->media, ELEMENT_OF(code), wrong, p->w);
}
% endif
