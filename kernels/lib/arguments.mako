## ray_fields, passes
// The stages' common arguments, and what each work-item makes of them.
#define SCENE_ARGUMENTS __global const launch_t *launch_buffer, __global const double *geometry, __global const double *materials, __global const double *sources, __global const long *codes, __global long *tally
#define QUEUE_ARGUMENTS __global item_t *items, __global long *status, __global double *queue_reals, __global uint *queue_words, __global long *queue_longs
#define RECORD_ARGUMENTS __global double *record_reals, __global uint *record_words

FN scene_t open_scene(__global const double *geometry, __global const double *materials,
                      __global const double *sources, __global const long *codes) {
    const scene_t s = {geometry, materials, sources, codes};
    return s;
}
FN queue_t open_queue(const launch_t *launch, __global double *reals, __global uint *words,
                      __global long *longs, ulong me) {
    const queue_t q = {reals, words, longs, launch->items, launch->stack_capacity, me};
    return q;
}
FN records_t open_records(const launch_t *launch, __global double *reals, __global uint *words,
                          ulong me) {
    const records_t r = {reals, words, launch->record_capacity, me};
    return r;
}
FN void clear_packet(packet_t *p) {
% for field in ray_fields:
    p->${field.name} = ${field.cleared};
% endfor
    p->alive = NO_LANES;
}

// status: 0 work-items with work left, 1 work-items whose segment is too small, 2 interactions, 3 surfaces passed.
FN void report(__global long *status, const item_t *item, uint blocked) {
    if (item->stack || item->next < item->end) atom_add(status, 1L);
    if (blocked) atom_add(status + 1, 1L);
}
// Interactions, also to the row of the batch's tally that counts them.
FN void report_interactions(__global long *status, const launch_t *launch, const ledger_t *ledger) {
    const long n = sum_lanes(ledger->interactions);
    atom_add(status + 2, n);
% if passes:
    atom_add(status + 3, sum_lanes(ledger->passed));
% endif
    count_interactions(launch, ledger, n);
}
