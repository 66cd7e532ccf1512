## the persistent packet: every stage in one kernel, up to max_bounces steps a launch
// reads: scene tables, launch, the work-item's state and queue segment.
// writes: state, queue segment, records, the batch's tally.
// from: waiting rays and rays not yet launched.  to: endings (records) and waiting rays.
//
// Each work-item keeps one ray in every lane of its packets.  When at least `refill` lanes are empty it
// fills them, first from its own stack, then from its own range of fresh rays.  It returns when nothing is left,
// after max_bounces steps, or when its segments might not hold what one more step can give: then it
// puts its live lanes back, so nothing is ever dropped.
FN void fill(const launch_t *launch, const scene_t *scene, const queue_t *queue, item_t *item, packet_t *p, uint *live) {
    if (item->stack) {
        uint n;
        const lint rank = rank_lanes(~p->alive, &n);
        const uint taken = (uint)min((ulong)n, item->stack);
        take_rays(queue, ((long)item->stack - 1) - rank, ~p->alive & ILT(rank, lsplat(taken)), p);
        item->stack -= taken;
        *live += taken;
    }
    if (item->next < item->end && ANY(~p->alive)) {
        uint n;
        const lint rank = rank_lanes(~p->alive, &n);
        const lint i = rank + (long)item->next;
        generate(launch, scene, item->slot, i, ~p->alive & ILT(i, lsplat((long)item->end)), p);
        const ulong next = min(item->next + (ulong)n, item->end);
        *live += (uint)(next - item->next);
        item->next = next;
    }
}

__kernel void wave(SCENE_ARGUMENTS, QUEUE_ARGUMENTS, RECORD_ARGUMENTS) {
    const ulong me = get_global_id(0);
    if (me >= launch_buffer->items) return;
    const launch_t settings = open_launch(launch_buffer);
    const launch_t *launch = &settings;
    const scene_t scene = open_scene(geometry, materials, sources, codes);
    const queue_t queue = open_queue(launch, queue_reals, queue_words, queue_longs, me);
    const records_t records = open_records(launch, record_reals, record_words, me);
    item_t item = items[me];
    ledger_t ledger;
    open_ledger(&ledger, tally + item.slot * launch->n_cells * CELL);
    packet_t packets[PACKETS];
    for (uint l = 0; l < PACKETS; l++) clear_packet(packets + l);
    uint blocked = 0;
    item.records = 0;
    for (ulong step = 0; step < launch->max_bounces; step++) {
        uint live = 0;
        for (uint l = 0; l < PACKETS; l++) live += count_lanes(packets[l].alive);
        if (PACKETS * LANES - live >= launch->refill || live == 0) {
            for (uint l = 0; l < PACKETS; l++) fill(launch, &scene, &queue, &item, packets + l, &live);
            if (!live) break;
        }
% if records:
        if (item.records + PACKETS * LANES > launch->record_capacity) break;
% endif
% if splits:
        if (item.stack + (1 + CHILDREN) * PACKETS * LANES > launch->stack_capacity) { blocked = 1; break; }
% endif
        hit_t hits[PACKETS];
        nearest_of(&scene, packets, PACKETS, hits);
% if packets > 1:
        for (uint l = 0; l < PACKETS; l++) expect(&ledger, ELEMENT_OF(hits[l].code), hits[l].found);
% endif
        for (uint l = 0; l < PACKETS; l++) {
            packet_t *p = packets + l;
            if (PACKETS > 1 && !ANY(p->alive)) continue;
            contact_t contact;
            packet_t child[CHILDREN];
            interact(launch, &scene, &records, &item.records, &ledger, p, hits + l, &contact, child);
% for k in range(children):
            if (ANY(child[${k}].alive)) push_rays(&queue, &item.stack, child[${k}].alive, child + ${k});
% endfor
        }
    }
    for (uint l = 0; l < PACKETS; l++) push_rays(&queue, &item.stack, packets[l].alive, packets + l);
    close_ledger(&ledger);
    report_interactions(status, launch, &ledger);
    items[me] = item;
    report(status, &item, blocked);
}
