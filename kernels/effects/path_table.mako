## counts (shared_names: 1 where an element has several faces of one name)
// The path table: what a ray has met, as a key that grows by a step an interaction.
// reads: the key so far, face, event; codes (where faces share a name: that of each, by element).
// gives: the key behind the interaction, of the lanes in `met`.
FN luint trail_step(const launch_t *launch, const scene_t *scene, mask met, lint code, word event) {
    const lint element = SELI(met, ELEMENT_OF(code), lsplat(0L)), face = SELI(met, FACE_OF(code), lsplat(0L));
% if counts["shared_names"]:
    const lint names = gather_long(scene->codes + launch->face_names, element);
    const lint name = gather_long(scene->codes, names + face);
% else:
    const lint name = face;
% endif
    return TRAIL_STEP(element, name, TO_LUINT(event));
}

FN luint extend_trail(const launch_t *launch, const scene_t *scene, mask met, luint trail, lint code, word event) {
    return ${point("path_table.trail", "mixed_trail(trail, trail_step(launch, scene, met, code, event))")};
}
