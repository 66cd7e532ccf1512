## the classical wavefront: one kernel per stage, one interaction of every waiting ray a step
// generate -> intersect -> shade -> roulette -> tally, until the queue is empty.  A step works on the
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
        const lint i = rank_lanes(lsplat(-1L), &n) + (long)item.next;
        generate(launch, &scene, item.slot, i, LT(i, lsplat((long)item.end)), &p);
        item.next = min(item.next + (ulong)LANES, item.end);
        push_rays(&queue, &item.stack, p.alive, &p);
    }
    ulong n = item.stack;
% if "splitting" in effects:
    n = min(n, launch->stack_capacity - item.stack);
% endif
% if records:
    n = min(n, launch->record_capacity);
% endif
    if (n == 0 && item.stack) atom_add(status + 1, 1L);
    item.base = item.stack - n;
    items[me] = item;
}

// from: waiting rays.  writes: a hit for each.
__kernel void intersect_stage(SCENE_ARGUMENTS, QUEUE_ARGUMENTS, __global double *hit_reals,
                              __global long *hit_codes) {
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
        const lint i = rank_lanes(lsplat(-1L), &n) + j;
        take_rays(&queue, i, LT(i, lsplat((long)item.stack)), &p);
        hit_t hit;
        nearest(&scene, &p, &hit);
        const lint at = queue_place(&queue, i);
        const lint code = SEL(hit.found, (hit.code << 1) | (hit.edge & 1L), lsplat(-1L));
% if "contact" in effects:
        __global long *notes = queue.longs + ${queue_long.index("note0")} * field;
% endif
% for l in range(lanes):
        if (${lane("p.alive", l)}) {
            hit_reals[${lane("at", l)}] = ${lane("hit.t", l)};
            hit_reals[field + ${lane("at", l)}] = ${lane("hit.plane", l)};
            hit_codes[${lane("at", l)}] = ${lane("code", l)};
% if "contact" in effects:
            // the search before is over: its notes make room for this one's
% for n in range(note_words):
            notes[${n} * field + ${lane("at", l)}] = ${lane(f"hit.noted.word{n}", l)};
% endfor
% endif
        }
% endfor
    }
}

// from: waiting rays and their hits.  to: waiting rays (survivors and children), records, the ledger.
__kernel void shade_stage(SCENE_ARGUMENTS, QUEUE_ARGUMENTS, RECORD_ARGUMENTS,
                          __global const double *hit_reals, __global const long *hit_codes) {
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
    const long field = (long)(queue.items * queue.capacity);
    ulong kept = item.base, tail = item.stack;
    for (long j = item.base; j < item.stack; j += LANES) {
        packet_t p, child;
        clear_packet(&p);
        uint n;
        const lint i = rank_lanes(lsplat(-1L), &n) + j;
        take_rays(&queue, i, LT(i, lsplat((long)item.stack)), &p);
        const lint at = queue_place(&queue, SEL(p.alive, i, lsplat(0L)));
        hit_t hit;
        const lint code = gather_long(hit_codes, at);
        hit.t = gather(hit_reals, at);
        hit.plane = gather(hit_reals + field, at);
        hit.found = p.alive & GE(code, lsplat(0L));
        hit.edge = -(code & 1L);
        hit.code = code >> 1;
% if "contact" in effects:
% for n in range(note_words):
        hit.noted.word${n} = p.note${n};
% endfor
% endif
        ending_t end;
        shade(launch, &scene, &p, &hit, &ledger, &end, &child);
% if records:
        put_records(&records, &item.records, &end);
% endif
        cap_generations(launch, &p, &ledger);
        push_rays(&queue, &kept, p.alive, &p);
% if "splitting" in effects:
        cap_generations(launch, &child, &ledger);
        push_rays(&queue, &tail, child.alive, &child);
% endif
    }
    // children close up behind the survivors
    for (long j = item.stack; j < tail; j += LANES) {
        packet_t p;
        clear_packet(&p);
        uint n;
        const lint i = rank_lanes(lsplat(-1L), &n) + j;
        take_rays(&queue, i, LT(i, lsplat((long)tail)), &p);
        push_rays(&queue, &kept, p.alive, &p);
    }
    item.stack = kept;
    close_ledger(&ledger);
    report_interactions(status, launch, &ledger);
    items[me] = item;
% if "roulette" not in effects:
    report(status, &item, 0);
% endif
}

% if "roulette" in effects:
// from: the rays the last step gave.  to: those that go on.  writes: queue, the ledger.
__kernel void roulette_stage(SCENE_ARGUMENTS, QUEUE_ARGUMENTS) {
    const ulong me = get_global_id(0);
    if (me >= launch_buffer->items) return;
    const launch_t settings = open_launch(launch_buffer);
    const launch_t *launch = &settings;
    const queue_t queue = open_queue(launch, queue_reals, queue_words, queue_longs, me);
    item_t item = items[me];
    ledger_t ledger;
    open_ledger(&ledger, tally + item.slot * launch->n_cells * CELL);
    ulong kept = item.base;
    for (long j = item.base; j < item.stack; j += LANES) {
        packet_t p;
        clear_packet(&p);
        uint n;
        const lint i = rank_lanes(lsplat(-1L), &n) + j;
        take_rays(&queue, i, LT(i, lsplat((long)item.stack)), &p);
        roulette(launch, &p, &ledger);
        push_rays(&queue, &kept, p.alive, &p);
    }
    item.stack = kept;
    close_ledger(&ledger);
    items[me] = item;
    report(status, &item, 0);
}
% endif
