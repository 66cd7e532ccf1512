## keyed: whether an effect keeps cells by key; hooks
## forms: the tallies that detectors have, each with .filters (stem and option of each)
// A detector counts arrivals on one side of an element: in a power cell, or in tallies of cells, each a
// product of filters whose first one changes fastest.
//
// Its integers: side (1: from the + side), power cell, number of tallies; then of each tally its form,
// its first cell, and of each filter its bins and where in `edges` theirs stand.
// Its numbers: centre (3), frame (9).
#define DETECTOR_SIDE 0
#define DETECTOR_POWER 1
#define DETECTOR_TALLIES 2
#define DETECTOR_HEAD 3
#define TALLY_FORM 0
#define TALLY_CELL 1
#define TALLY_BINS(filter) (2 + 2 * (filter))
#define TALLY_EDGES(filter) (3 + 2 * (filter))
#define DETECTOR_TALLY ${2 + 2 * max((len(form.filters) for form in forms), default=0)}
#define DETECTOR_NUMBERS 12
FN void count_arrival(__global long *cells, ${"keyed_t *keyed, " if keyed else ""} const launch_t *launch, __global const long *codes,
                      __global const double *numbers, __global const double *edges,
                      const ending_record_t *end) {
    const long which = codes[launch->detector_of + (end->tag >> 1)];
    __global const long *d = codes + codes[launch->detectors + which];
    if (${point("detector.other_side", "(end->tag & 1u) != (uint)d[DETECTOR_SIDE]")}) return;
% for statement in hooks["arrival"]:
${statement}
% endfor
    // the power of a detector with tallies is the sum of one, which the host takes
    if (!d[DETECTOR_TALLIES]) add_exact(cells + d[DETECTOR_POWER] * CELL, end->w);
% if forms:
    arrival_t a;
    a.generation = end->generation;
% if "line" in ending_word:
    a.line = end->line;
% endif
    __global const double *row = numbers + which * DETECTOR_NUMBERS;
    const double px = end->x - row[0], py = end->y - row[1], pz = end->z - row[2];
% for n, name in enumerate("uvw"):
    a.${name} = fma(px, row[${3 + 3 * n}], fma(py, row[${4 + 3 * n}], pz * row[${5 + 3 * n}]));
% endfor
    for (long k = 0; k < d[DETECTOR_TALLIES]; k++) {
        __global const long *t = d + DETECTOR_HEAD + k * DETECTOR_TALLY;
        long cell = t[TALLY_CELL];
% for number, form in enumerate(forms):
        ${"else " if number else ""}if (${point("detector.form", f"t[TALLY_FORM] == {number}")}) {
% for n, (stem, option) in enumerate(form.filters):
            cell += ${"".join(f"t[TALLY_BINS({m})] * " for m in range(n))}bin_${stem}${"_" + option if option else ""}(edges + t[TALLY_EDGES(${n})], t[TALLY_BINS(${n})], &a);
% endfor
        }
% endfor
        add_exact(cells + cell * CELL, end->w);
    }
% endif
}
