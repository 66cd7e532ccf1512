## the classical wavefront: one kernel per stage, one interaction of every waiting ray a step
// generate -> intersect -> interact -> tally, until the queue is empty.  A step works on the
// upper part of each segment, `base` to `stack`: as much as leaves room for every child and every
// record it can give.  Survivors are written back from `base` on, children behind them.

// from: rays not yet launched.  to: waiting rays.  reads and writes: items, queue.
__kernel void generate_stage(SCENE_ARGUMENTS, QUEUE_ARGUMENTS) {
    const ulong me = get_global_id(0);
    if (me >= launch_buffer->items) return;
    const launch_t settings = open_launch(launch_buffer);
    const launch_t *launch = &settings;
    const scene_t scene = open_scene(geometry, materials, sources, codes);
    const queue_t queue = open_queue(launch, queue_reals, queue_words, queue_longs, me);
    item_t item = items[me];
    item.records = 0;
    while (item.next < item.end && item.stack + LANES <= launch->fill) {
        packet_t p;
        clear_packet(&p);
        uint n;
        const lint i = rank_lanes(ALL_LANES, &n) + (long)item.next;
        generate(launch, &scene, item.slot, i, ILT(i, lsplat((long)item.end)), &p);
        item.next = min(item.next + (ulong)LANES, item.end);
        push_rays(&queue, &item.stack, p.alive, &p);
    }
    ulong n = item.stack;
% if splits:
    n = min(n, (launch->stack_capacity - item.stack) / CHILDREN);
% endif
% if records:
    n = min(n, launch->record_capacity);
% endif
    if (n == 0 && item.stack) atom_add(status + 1, 1L);
    item.base = item.stack - n;
    items[me] = item;
}

<%
    hit_reals = [f.name for f in hit_fields if f.type == "real"]
    hit_longs = [(f.name, f.type) for f in hit_fields if f.type != "real"]
%>
// from: waiting rays.  writes: a hit for each.
__kernel void intersect_stage(SCENE_ARGUMENTS, QUEUE_ARGUMENTS, __global double *hit_reals,
                              __global long *hit_longs) {
    const ulong me = get_global_id(0);
    if (me >= launch_buffer->items) return;
    const launch_t settings = open_launch(launch_buffer);
    const launch_t *launch = &settings;
    const scene_t scene = open_scene(geometry, materials, sources, codes);
    const queue_t queue = open_queue(launch, queue_reals, queue_words, queue_longs, me);
    const item_t item = items[me];
    const long field = (long)(queue.items * queue.capacity);
    for (long j = item.base; j < item.stack; j += LANES) {
        packet_t p;
        clear_packet(&p);
        uint n;
        const lint i = rank_lanes(ALL_LANES, &n) + j;
        take_rays(&queue, i, ILT(i, lsplat((long)item.stack)), &p);
        hit_t hit;
        nearest(&scene, &p, &hit);
        const lint at = queue_place(&queue, i);
% for l in range(lanes):
        if (${lane("p.alive", l)}) {
% for n, name in enumerate(hit_reals):
            hit_reals[${n} * field + ${lane("at", l)}] = ${lane(f"hit.{name}", l)};
% endfor
% for n, (name, _) in enumerate(hit_longs):
            hit_longs[${n} * field + ${lane("at", l)}] = ${lane(f"hit.{name}", l)};
% endfor
        }
% endfor
    }
}

// from: waiting rays and their hits.  to: waiting rays (survivors and children), records, the ledger.
__kernel void interact_stage(SCENE_ARGUMENTS, QUEUE_ARGUMENTS, RECORD_ARGUMENTS,
                             __global const double *hit_reals, __global const long *hit_longs) {
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
    const long field = (long)(queue.items * queue.capacity);
    ulong kept = item.base, tail = item.stack;
    for (long j = item.base; j < item.stack; j += LANES) {
        packet_t p, child[CHILDREN];
        clear_packet(&p);
        uint n;
        const lint i = rank_lanes(ALL_LANES, &n) + j;
        take_rays(&queue, i, ILT(i, lsplat((long)item.stack)), &p);
        const lint at = queue_place(&queue, SELI(p.alive, i, lsplat(0L)));
        hit_t hit;
% for n, name in enumerate(hit_reals):
        hit.${name} = gather(hit_reals + ${n} * field, at);
% endfor
% for n, (name, kind) in enumerate(hit_longs):
        hit.${name} = ${"MASK_OF" if kind == "mask" else ""}(gather_long(hit_longs + ${n} * field, at));
% endfor
        hit.found = p.alive & LT(hit.t, splat(INFINITY));
        contact_t contact;
        interact(launch, &scene, &records, &item.records, &ledger, &p, &hit, &contact, child);
        push_rays(&queue, &kept, p.alive, &p);
% for k in range(children):
        push_rays(&queue, &tail, child[${k}].alive, child + ${k});
% endfor
    }
    // children close up behind the survivors
    for (long j = item.stack; j < tail; j += LANES) {
        packet_t p;
        clear_packet(&p);
        uint n;
        const lint i = rank_lanes(ALL_LANES, &n) + j;
        take_rays(&queue, i, ILT(i, lsplat((long)tail)), &p);
        push_rays(&queue, &kept, p.alive, &p);
    }
    item.stack = kept;
    close_ledger(&ledger);
    report_interactions(status, launch, &ledger);
    items[me] = item;
    report(status, &item, 0);
}
