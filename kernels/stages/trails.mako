## splits; lanes == 1
// Which steps paths have: follows the launched rays that show them, each with all its children, until
// every path that is wanted of it was met.
//
// One work-item a ray, depth first, through the functions that the trace runs.  What a ray has met
// stands in `chain`, a step an interaction; of a child that waits its last step waits beside it, and
// those before are still in place when it is taken up, since all that was followed between is longer.
// A ray that has met more than the longest path that is wanted is left.
// reads: scene tables, launch; rays (batch, number in that, first of its paths, how many, interactions
// of the longest), keys of the paths, ascending within a ray's.
// uses: a queue segment a ray.  writes: steps of each path and their number, -1 where it was not found;
// the tally, of which nothing is asked.
#define TRAIL_RAY 5
__kernel void trails_stage(SCENE_ARGUMENTS, __global double *queue_reals, __global uint *queue_words,
                           __global long *queue_longs, __global long *last_steps, __global long *chains,
                           __global const long *rays, __global const ulong *keys, __global long *steps,
                           __global long *lengths, ulong room, ulong longest, ulong most_steps) {
    const ulong me = get_global_id(0);
    if (me >= launch_buffer->items) return;
    const launch_t settings = open_launch(launch_buffer);
    const launch_t *launch = &settings;
    const scene_t scene = open_scene(geometry, materials, sources, codes);
    const queue_t queue = open_queue(launch, queue_reals, queue_words, queue_longs, me);
    __global long *waiting = last_steps + me * launch->stack_capacity;
    __global long *chain = chains + me * room;
    __global const long *ray = rays + TRAIL_RAY * me;
    const long first = ray[2];
    long left = ray[3];
    ledger_t ledger;
    open_ledger(&ledger, tally);
    packet_t p;
    clear_packet(&p);
    generate(launch, &scene, (ulong)ray[0], ray[1], ALL_LANES, &p);
    ulong stack = 0;
    for (ulong step = 0; step < most_steps && left; step++) {
        if (!p.alive || (long)p.generation > ray[4]) {
            if (!stack) break;
            stack--;
            take_rays(&queue, (long)stack, ALL_LANES, &p);
            chain[p.generation - 1] = waiting[stack];
            continue;
        }
        hit_t hit;
        nearest(&scene, &p, &hit);
        if (hit.found && HAS_DETECTOR(hit.code)) {
            const ulong key = path_key(p.trail, (ulong)codes[launch->detector_of + ELEMENT_OF(hit.code)]);
            long low = first, high = first + ray[3];
            while (low < high) {
                const long middle = (low + high) / 2;
                if (keys[middle] < key) low = middle + 1;
                else high = middle;
            }
            if (low < first + ray[3] && keys[low] == key && lengths[low] < 0) {
                lengths[low] = p.generation;
                for (uint k = 0; k < p.generation; k++) steps[low * longest + k] = chain[k];
                left--;
            }
        }
        const ulong before = p.trail;
        const uint generation = p.generation;
        contact_t contact;
        packet_t child[CHILDREN];
        interact(launch, &scene, 0, 0, &ledger, &p, &hit, &contact, child);
        if (p.alive && p.generation != generation) {
            for (uint event = REFLECTED; event <= SCATTERED; event++) {
                const ulong made = trail_step(launch, &scene, ALL_LANES, hit.code, event);
                if (mixed_trail(before, made) == p.trail) chain[generation] = (long)made;
            }
        }
% for k in range(children):
        if (child[${k}].alive) {
            for (uint event = REFLECTED; event <= SCATTERED; event++) {
                const ulong made = trail_step(launch, &scene, ALL_LANES, hit.code, event);
                if (mixed_trail(before, made) == child[${k}].trail) waiting[stack] = (long)made;
            }
            push_rays(&queue, &stack, child[${k}].alive, child + ${k});
        }
% endfor
    }
}
