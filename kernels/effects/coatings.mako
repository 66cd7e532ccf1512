## counts (coating.<kernel>: number of a kind), amplitudes (whether light is polarised)
<%
    kinds = sorted((n, name.removeprefix("coating.")) for name, n in counts.items() if name.startswith("coating."))
%>
// What a coated face makes of a weight that meets it: what is reflected and what passes; and of polarised light
// by what amplitudes.
//
// reads: the coating, the angles.  writes: both weights, in lanes with a coating.  Of the two parts the smaller
// one is taken of the weight and the larger one is no more than that leaves, a difference that is exact where it
// matters: all of it, where the coating absorbs nothing.
FN void coat(const encounter_t *event, const material_t *material, mask total, real ci, real sin2, real ct, real ct2,
             real m, weight *reflected, weight *passed${", const incident_t *light, amplitudes_t *back, amplitudes_t *on" if amplitudes else ""}) {
% if amplitudes:
    // whatever says nothing of it is alike for s and p
    *back = conductor();
    *on = alike();
% endif
    const mask coated = event->m & IGE(material->coating, lsplat(0L));
    if (!ANY(coated)) return;
    const film_t film = {material, ${point("coatings.side", "event->c->came_plus")}, ci, sin2, ct, ct2, m, material->coating_head${", light, back, on" if amplitudes else ""}};
    const lint kind = film_place(&film, COATING_KIND);
    weight r = weight_splat(0.0), t = weight_splat(0.0);
% for number, name in kinds:
    {
        const mask mine = coated & IEQ(kind, lsplat(${number}L));
        if (ANY(mine)) {
            weight part_r, part_t;
            coat_${name}(&film, mine, &part_r, &part_t);
            r = SEL_WEIGHT(mine, part_r, r);
            t = SEL_WEIGHT(mine, part_t, t);
        }
    }
% endfor
    r = clamp(r, weight_splat(0.0), weight_splat(1.0));
    t = clamp(t, weight_splat(0.0), weight_splat(1.0));
    // beyond the critical angle nothing passes
    r = SEL_WEIGHT(total, ${point("coatings.total", "fmin(r + t, weight_splat(1.0))")}, r);
    t = SEL_WEIGHT(total, weight_splat(0.0), t);
    const weight w = event->p->w, small = w * fmin(r, t), rest = w - small;
    const mask lossless = ${point("coatings.lossless", "IEQ(material->coating & 1L, lsplat(0L))")}, mirrors = WEIGHT_GE(r, t);
    const weight large = SEL_WEIGHT(lossless, rest, fmin(w * fmax(r, t), rest));
    *reflected = SEL_WEIGHT(coated, SEL_WEIGHT(mirrors, large, small), *reflected);
    *passed = SEL_WEIGHT(coated, SEL_WEIGHT(mirrors, small, large), *passed);
}
