## recorded, ending_fields, ending_real, ending_word; private_tallies, keyed
// The tally stage: endings into cells.  One number at a time, since scattered cells gain nothing from
// lanes; kept out of the bounce loop, which it would slow by 40 %.
// from: records.  to: the batch's tally.
% if private_tallies:
// Few work-items, each adding to a copy of its own without atomics: work-item g takes segments g,
// g + copies, ...  `merge_stage` adds the copies up.
% else:
// Work-item g takes every `parts`-th record of segment g / parts; atomic sums.
% endif
__kernel void tally_stage(__global const launch_t *launch_buffer, __global const long *codes,
                          __global const double *detector_numbers, __global const double *edges,
                          __global const item_t *items, __global const double *record_reals,
                          __global const uint *record_words, __global long *tally, ulong parts${"," if keyed else ""}
% if keyed:
                          __global long *keyed_tables, ulong keyed_capacity
% endif
                          ) {
    const launch_t settings = open_launch(launch_buffer);
    const launch_t *launch = &settings;
% if private_tallies:
    if (get_global_id(0) >= parts) return;
    tally += get_global_id(0) * launch->slots * launch->n_cells * CELL;
    for (ulong me = get_global_id(0); me < launch->items; me += parts) {
    const ulong first = 0, step = 1;
% else:
    {
    const ulong me = get_global_id(0) / parts;
    if (me >= launch_buffer->items) return;
    const ulong first = get_global_id(0) % parts, step = parts;
% endif
    const item_t item = items[me];
    __global long *cells = tally + item.slot * launch->n_cells * CELL;
% if keyed:
    keyed_t keyed;
    open_keyed(&keyed, keyed_tables, item.slot, keyed_capacity);
% endif
    for (ulong j = first; j < item.records; j += step) {
        const ulong k = me * launch->record_capacity + j;
        ending_record_t end;
% for n, name in enumerate(ending_real):
        end.${name} = record_reals[${len(ending_real)} * k + ${n}];
% endfor
% for n, name in enumerate(ending_word):
        end.${name} = record_words[${len(ending_word)} * k + ${n}];
% endfor
% if "escapes" in recorded:
        if (end.tag == UINT_MAX) count_escape(cells, launch, edges, &end);
% endif
% if "arrivals" in recorded:
        if (end.tag != UINT_MAX) count_arrival(cells, ${"&keyed, " if keyed else ""}launch, codes, detector_numbers, edges, &end);
% endif
    }
% if keyed:
    settle_keyed(&keyed);
% endif
    }
}

% if private_tallies:
// Adds the copies into the tally and clears them.  One work-item an integer.
__kernel void merge_stage(__global const launch_t *launch_buffer, __global long *copies,
                          __global long *tally, ulong n_copies) {
    const ulong n = launch_buffer->slots * launch_buffer->n_cells * CELL;
    const ulong i = get_global_id(0);
    // without work-items, at the first launch, nothing has set the copies
    if (i >= n || launch_buffer->items == 0) return;
    long sum = 0;
    for (ulong c = 0; c < n_copies; c++) {
        sum += copies[c * n + i];
        copies[c * n + i] = 0;
    }
    tally[i] += sum;
}
% endif
