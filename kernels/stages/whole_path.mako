## the plain alternative that the wavefront is measured against: lanes == 1
// One work-item follows one launched ray and all its children to their ends, one after the other.
// from: rays not yet launched.  to: endings (records), the ledger.
__kernel void whole_path(SCENE_ARGUMENTS, QUEUE_ARGUMENTS, RECORD_ARGUMENTS) {
    const ulong me = get_global_id(0);
    if (me >= launch_buffer->items) return;
    const launch_t settings = open_launch(launch_buffer);
    const launch_t *launch = &settings;
    const scene_t scene = open_scene(geometry, materials, sources, codes);
% if splits or records:
    const queue_t queue = open_queue(launch, queue_reals, queue_words, queue_longs, me);
% endif
    const records_t records = open_records(launch, record_reals, record_words, me);
    item_t item = items[me];
    ledger_t ledger;
    open_ledger(&ledger, tally + item.slot * launch->n_cells * CELL);
    packet_t p;
    clear_packet(&p);
    uint blocked = 0;
    item.records = 0;
    if (item.next < item.end) {
        generate(launch, &scene, item.slot, (long)item.next, ALL_LANES, &p);
        item.next++;
    }
    for (;;) {
        if (!p.alive) {
            if (!item.stack) break;
% if splits or records:
            item.stack--;
            take_rays(&queue, (long)item.stack, ALL_LANES, &p);
% endif
        }
% if records:
        if (item.records + 1 > launch->record_capacity) break;
% endif
% if splits:
        if (item.stack + 1 + CHILDREN > launch->stack_capacity) { blocked = 1; break; }
% endif
        hit_t hit;
        nearest(&scene, &p, &hit);
        contact_t contact;
        packet_t child[CHILDREN];
        interact(launch, &scene, &records, &item.records, &ledger, &p, &hit, &contact, child);
% for k in range(children):
        push_rays(&queue, &item.stack, child[${k}].alive, child + ${k});
% endfor
    }
% if splits or records:
    // stopped on its way: for want of room for children, or for what is recorded, which a ray that passes
    // many detectors makes more of than one
    push_rays(&queue, &item.stack, p.alive, &p);
% endif
    close_ledger(&ledger);
    report_interactions(status, launch, &ledger);
    items[me] = item;
    report(status, &item, blocked);
}
