## passes
// What a work-item tells the host when a launch ends.

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
