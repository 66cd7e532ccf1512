## the persistent packet: every stage in one kernel, up to max_bounces steps a launch
// reads: scene tables, launch, the work-item's state and queue segment.
// writes: state, queue segment, records, the batch's tally.
// from: waiting rays and rays not yet launched.  to: endings (records) and waiting rays.
//
// Each work-item keeps one ray in every lane.  When at least `refill` lanes are empty it fills them,
// first from its own stack, then from its own range of fresh rays.  It returns when nothing is left,
// after max_bounces steps, or when its segments might not hold what one more step can give: then it
// puts its live lanes back, so nothing is ever dropped.
__kernel void wave(SCENE_ARGUMENTS, QUEUE_ARGUMENTS, RECORD_ARGUMENTS) {
    const ulong me = get_global_id(0);
    if (me >= launch_buffer->items) return;
    const launch_t settings = open_launch(launch_buffer);
    const launch_t *launch = &settings;
    const scene_t scene = open_scene(geometry, materials, sources, codes);
    const queue_t queue = open_queue(launch, queue_reals, queue_words, queue_longs, me);
% if records:
    const records_t records = open_records(launch, record_reals, record_words, me);
% endif
    item_t item = items[me];
    ledger_t ledger;
    open_ledger(&ledger, tally + item.slot * launch->n_cells * CELL);
    packet_t p;
    clear_packet(&p);
    uint blocked = 0;
    item.records = 0;
    for (ulong step = 0; step < launch->max_bounces; step++) {
        const uint live = count_lanes(p.alive);
        if (LANES - live >= launch->refill || live == 0) {
            if (item.stack) {
                uint n;
                const lint rank = rank_lanes(~p.alive, &n);
                const uint taken = (uint)min((ulong)n, item.stack);
                take_rays(&queue, ((long)item.stack - 1) - rank, ~p.alive & LT(rank, lsplat(taken)), &p);
                item.stack -= taken;
            }
            if (item.next < item.end && ANY(~p.alive)) {
                uint n;
                const lint rank = rank_lanes(~p.alive, &n);
                const lint i = rank + (long)item.next;
                generate(launch, &scene, item.slot, i, ~p.alive & LT(i, lsplat((long)item.end)), &p);
                item.next = min(item.next + (ulong)n, item.end);
            }
            if (!ANY(p.alive)) break;
        }
% if records:
        if (item.records + LANES > launch->record_capacity) break;
% endif
% if "splitting" in effects:
        if (item.stack + 2 * LANES > launch->stack_capacity) { blocked = 1; break; }
% endif
        hit_t hit;
        nearest(&scene, &p, &hit);
        ending_t end;
        packet_t child;
        shade(launch, &scene, &p, &hit, &ledger, &end, &child);
% if records:
        put_records(&records, &item.records, &end);
% endif
        survive(launch, &p, &ledger);
% if "splitting" in effects:
        if (ANY(child.alive)) {
            survive(launch, &child, &ledger);
            push_rays(&queue, &item.stack, child.alive, &child);
        }
% endif
    }
    push_rays(&queue, &item.stack, p.alive, &p);
    close_ledger(&ledger);
    report_interactions(status, launch, &ledger);
    items[me] = item;
    report(status, &item, blocked);
}
