## the trace of a few rays with every segment written down: lanes == 1
// One work-item follows one launched ray and all its children, depth first, through the functions that
// the trace runs, and books them in the ledger as the trace does.
// reads: scene tables, launch.  uses: a queue segment a ray for the children that wait.
// writes: segments, `counts` (segments of the ray, and 1 where `capacity` cut it short), the tally.
//
// A segment: start (3), end (3; the direction where it escapes), weight; path, generation, element (-1
// where it escapes), the ray's segment that it continues (-1 for a launched ray), whether it begins a
// line of its own, how it ends, and the face that it ends on (-1 where it escapes).
% if ends:
// One that ends on its way to a face is written up to that face, with its number and no element; one on
// its way out as one that escapes, but for how it ends.
% endif
#define GOES_ON 0L
#define ABSORBED 1L
#define ESCAPED 2L
#define CAPPED 3L
#define KILLED 4L
#define NOT_FOLLOWED 5L
__kernel void paths_stage(SCENE_ARGUMENTS, __global double *queue_reals, __global uint *queue_words,
                          __global long *queue_longs, __global long *parents,
                          __global double *segment_reals, __global long *segment_longs,
                          __global long *counts, ulong first) {
    const ulong me = get_global_id(0);
    if (me >= launch_buffer->items) return;
    const launch_t settings = open_launch(launch_buffer);
    const launch_t *launch = &settings;
    const scene_t scene = open_scene(geometry, materials, sources, codes);
    const queue_t queue = open_queue(launch, queue_reals, queue_words, queue_longs, me);
    const ulong capacity = launch->record_capacity;
    __global long *waiting = parents + me * launch->stack_capacity;
    __global double *reals = segment_reals + 7 * me * capacity;
    __global long *longs = segment_longs + 7 * me * capacity;
    ledger_t ledger;
    open_ledger(&ledger, tally);
    packet_t p;
    clear_packet(&p);
    generate(launch, &scene, 0, (long)(first + me), ALL_LANES, &p);
    ulong stack = 0, n = 0;
    long parent = -1, begins = 1, cut = 0;
    for (;;) {
        if (!p.alive) {
            if (!stack) break;
            stack--;
            take_rays(&queue, (long)stack, ALL_LANES, &p);
            parent = waiting[stack];
            begins = 1;
        }
        if (n == capacity) {
            if (!begins) longs[7 * parent + 5] = NOT_FOLLOWED;
            cut = 1;
            break;
        }
        __global double *real_of = reals + 7 * n;
        __global long *long_of = longs + 7 * n;
        real_of[0] = p.ox; real_of[1] = p.oy; real_of[2] = p.oz;
        real_of[3] = p.dx; real_of[4] = p.dy; real_of[5] = p.dz;
        real_of[6] = p.w;
        long_of[0] = (long)path_of(&p);
        long_of[1] = p.generation;
        long_of[3] = parent;
        long_of[4] = begins;
        hit_t hit;
        nearest(&scene, &p, &hit);
        contact_t contact;
        packet_t child[CHILDREN];
        interact(launch, &scene, 0, 0, &ledger, &p, &hit, &contact, child);
        long ending = ESCAPED;
% if ends:
        const mask meets = hit.found;
        if (contact.lost) {
            ending = ABSORBED;
            hit.found = NO_LANES;
            if (meets) {
                const double way = TO_WIDE(hit.t);
                real_of[3] = fma(way, real_of[3], real_of[0]);
                real_of[4] = fma(way, real_of[4], real_of[1]);
                real_of[5] = fma(way, real_of[5], real_of[2]);
            }
        }
% endif
        if (hit.found) {
            real_of[3] = p.ox; real_of[4] = p.oy; real_of[5] = p.oz;
            // what a surface sends on has weight; it may end before it starts
            ending = p.alive ? GOES_ON : !(p.w > 0.0) ? ABSORBED
                   : (ulong)p.generation >= launch->generation_cap ? CAPPED : KILLED;
        }
        long_of[2] = hit.found ? (long)ELEMENT_OF(hit.code) : -1L;
        long_of[5] = ending;
        long_of[6] = ${"meets" if ends else "hit.found"} ? (long)FACE_OF(hit.code) : -1L;
% for k in range(children):
        if (child[${k}].alive) {
            waiting[stack] = (long)n;
            push_rays(&queue, &stack, child[${k}].alive, child + ${k});
        }
% endfor
        parent = (long)n;
        begins = 0;
        n++;
    }
    close_ledger(&ledger);
    count_interactions(launch, &ledger, sum_lanes(ledger.interactions));
    counts[2 * me] = (long)n;
    counts[2 * me + 1] = cut;
}
