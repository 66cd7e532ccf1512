## splits; lanes == 1
// Which steps a path has: follows the launched ray that shows it, and all its children, until one
// arrives with the path's key.
//
// One work-item a path, depth first, through the functions that the trace runs.  What a ray has met
// stands in `chain`, a step an interaction; of a child that waits its last step waits beside it, and
// those before are still in place when it is taken up, since all that was followed between is longer.
// reads: scene tables, launch, wanted paths (key, ray's batch, its number in that, detector's
// element and number).
// uses: a queue segment a path.  writes: steps and their number, −1 where the path was not found; the
// tally, of which nothing is asked.
#define WANTED 5
__kernel void trails_stage(SCENE_ARGUMENTS, __global double *queue_reals, __global uint *queue_words,
                           __global long *queue_longs, __global long *last_steps, __global const long *wanted,
                           __global long *chains, __global long *lengths, ulong capacity, ulong most_steps) {
    const ulong me = get_global_id(0);
    if (me >= launch_buffer->items) return;
    const launch_t settings = open_launch(launch_buffer);
    const launch_t *launch = &settings;
    const scene_t scene = open_scene(geometry, materials, sources, codes);
    const queue_t queue = open_queue(launch, queue_reals, queue_words, queue_longs, me);
    __global long *waiting = last_steps + me * launch->stack_capacity;
    __global long *chain = chains + me * capacity;
    __global const long *want = wanted + WANTED * me;
    ledger_t ledger;
    open_ledger(&ledger, tally);
    packet_t p;
    clear_packet(&p);
    generate(launch, &scene, (ulong)want[1], want[2], ALL_LANES, &p);
    ulong stack = 0;
    lengths[me] = -1;
    for (ulong step = 0; step < most_steps; step++) {
        if (!p.alive) {
            if (!stack) break;
            stack--;
            take_rays(&queue, (long)stack, ALL_LANES, &p);
            chain[p.generation - 1] = waiting[stack];
        }
        hit_t hit;
        nearest(&scene, &p, &hit);
        if (hit.found && ELEMENT_OF(hit.code) == want[3] && path_key(p.trail, (ulong)want[4]) == (ulong)want[0]) {
            lengths[me] = p.generation;
            break;
        }
        const ulong before = p.trail;
        const uint generation = p.generation;
        contact_t contact;
        packet_t child;
        interact(launch, &scene, 0, 0, &ledger, &p, &hit, &contact, &child);
        if (p.alive && p.generation != generation) {
            for (uint event = REFLECTED; event <= SCATTERED; event++) {
                const ulong made = trail_step(launch, &scene, ALL_LANES, hit.code, event);
                if (mixed_trail(before, made) == p.trail) chain[generation] = (long)made;
            }
        }
% if splits:
        if (child.alive) {
            for (uint event = REFLECTED; event <= SCATTERED; event++) {
                const ulong made = trail_step(launch, &scene, ALL_LANES, hit.code, event);
                if (mixed_trail(before, made) == child.trail) waiting[stack] = (long)made;
            }
            push_rays(&queue, &stack, child.alive, &child);
        }
% endif
    }
}
