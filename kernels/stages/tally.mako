## effects, with detectors or the far field in use
// The tally stage: endings into cells.  One number at a time, since atomics on scattered cells gain
// nothing from lanes; kept out of the bounce loop, which it would slow by 40 %.
// from: records.  to: the batch's tally.  Work-item g takes every `parts`-th record of segment g / parts.
__kernel void tally_stage(__global const launch_t *launch_buffer, __global const long *codes,
                          __global const double *detector_numbers, __global const double *edges,
                          __global const item_t *items, __global const double *record_reals,
                          __global const uint *record_words, __global long *tally, ulong parts) {
    const ulong me = get_global_id(0) / parts;
    if (me >= launch_buffer->items) return;
    const launch_t settings = open_launch(launch_buffer);
    const launch_t *launch = &settings;
    const item_t item = items[me];
    __global long *cells = tally + item.slot * launch->n_cells * CELL;
    for (ulong j = get_global_id(0) % parts; j < item.records; j += parts) {
        const ulong k = me * launch->record_capacity + j;
        const double w = record_reals[4 * k];
        const double x = record_reals[4 * k + 1], y = record_reals[4 * k + 2], z = record_reals[4 * k + 3];
        const uint tag = record_words[2 * k];
% if "far-field" in effects:
        if (tag == UINT_MAX) count_escape(cells, launch, edges, w, x, y, z);
% endif
% if "detector" in effects:
        if (tag != UINT_MAX)
            count_arrival(cells, launch, codes, detector_numbers, edges, w, x, y, z, tag, record_words[2 * k + 1]);
% endif
    }
}
