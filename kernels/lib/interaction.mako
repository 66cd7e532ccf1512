## records, splits, ends (whether a ray may end on its way), hooks
##
## What the statements of effects find in scope.  Everywhere `launch`, the launch structure with the
## effect's own members, and `ledger`; types are those of event.mako, limbs.mako and ledger.mako, and a
## `real`, `weight`, `lint` or `mask` has a value for each lane.  All are to be read; what may be written
## is said.
##
##   travel   (in interact) scene; p: the packet at the start of the segment, with its weight before (w may be
##            written, what it loses booked, and alive by an effect that `ends` rays on their way); h: what it meets, h->found the lanes that meet a face, h->t the length of
##            the segment in m; c: the contact, point, normal and side, of the lanes in h->found;
##            records and n_records.  `child` is not set yet.
##   surface  (in shade) scene, p, h and c as before, p not yet moved on; found: lanes that meet a face;
##            escaped: lanes that leave the scene; met: lanes of `found` that do not just pass;
##            element: its number in file order, of the lanes in `found`; takes: lanes whose element takes
##            what does not go on; before: the weight that arrives, as an image_t (limbs.mako) to be
##            booked; row: the material's row of each lane; outcome: what goes on (event.mako), with the
##            packet's weight behind the surface;
##            end: what is recorded, where anything is.  The ledger is booked already: a weight that is
##            changed in `outcome` is booked by the hook.
##   survive  (in survive) p: the packet at the start of its next segment, or the second ray of the lanes
##            that split (may be written: w, alive, each change booked); met: the lanes that made an
##            interaction, whether or not a ray goes on in them: rays are in p->alive & met.
##   arrival  (in count_arrival, detector.mako: in the program that counts what was recorded, one number at a time)
##            end: the record; which: the detector's number; codes; keyed where the effect keeps cells by
##            key (keyed.mako). Only arrivals on the side that counts.
##
## An image_t is a weight as three integers, in units of 2^-31, 2^-63 and 2^-95: image_of(w) makes one,
## book_row books it on a row of the effect.  count_weights adds a `weight` to the effect's cells.
// One interaction, the only one that there is: travel -> shade -> record -> survive, from the nearest
// face on.  The persistent packet, the whole path, the classical stages, the follower and the path
// recorder all call it.
//
// Hooks: `travel`, at the end of a segment, before the surface is met; `surface`, in shade, when the
// outcome is known; `survive`, before a ray goes on to its next segment.
//
// reads: packet, hit, scene tables.  writes: packet and child (CHILDREN packets: the second ray of lanes
// that split, and others beside it, with what is left of all), contact, the ledger, records (where there are any).
FN void interact(const launch_t *launch, const scene_t *scene, const records_t *records, ulong *n_records,
                 ledger_t *ledger, packet_t *p, const hit_t *h, contact_t *c, packet_t *child) {
    locate(scene, p, h, c);
% if ends:
    const mask set_out = p->alive;
% endif
% for statement in hooks["travel"]:
${statement}
% endfor
% if ends:
    // what ended on its way meets nothing
    c->lost = set_out & ~p->alive;
    hit_t reached = *h;
    reached.found &= ~c->lost;
    h = &reached;
% endif
    ending_t end;
    const mask met = shade(launch, scene, p, h, c, ledger, &end, child);
% if records:
    if (records) put_records(records, n_records, &end);
% endif
    survive(launch, p, ledger, met);
% if splits:
    if (ANY(child->alive)) survive(launch, child, ledger, met);
% for k in range(1, extras + 1):
    if (ANY(child[${k}].alive)) survive(launch, child + ${k}, ledger, met);
% endfor
% endif
}
