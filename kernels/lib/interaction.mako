## records, splits, hooks
// One interaction, the only one that there is: travel -> shade -> record -> survive, from the nearest
// face on.  The persistent packet, the whole path, the classical stages, the follower and the path
// recorder all call it.
//
// Hooks: `travel`, at the end of a segment, before the surface is met; `surface`, in shade, when the
// outcome is known; `survive`, before a ray goes on to its next segment.
//
// reads: packet, hit, scene tables.  writes: packet and child (the second ray of lanes that split, with
// what is left of both), contact, the ledger, records (where there are any).
FN void interact(const launch_t *launch, const scene_t *scene, const records_t *records, ulong *n_records,
                 ledger_t *ledger, packet_t *p, const hit_t *h, contact_t *c, packet_t *child) {
    locate(scene, p, h, c);
% for statement in hooks["travel"]:
    ${statement}
% endfor
    ending_t end;
    const mask met = shade(launch, scene, p, h, c, ledger, &end, child);
% if records:
    if (records) put_records(records, n_records, &end);
% endif
    survive(launch, p, ledger, met);
% if splits:
    if (ANY(child->alive)) survive(launch, child, ledger, met);
% endif
}
