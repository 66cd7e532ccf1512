## effects, lanes, ledger (names of the rows behind the elements'), ledger_rows (number of rows kept in
## registers, 0 for none), n_elements where that is > 0; books: whether the stage keeps one at all;
## counts (ledger_parts: 1 where rows are divided)
// The ledger of one work-item: what elements absorb, what escapes, what roulette and the generation
// cap take.  Rows: element 0 ... n-1, then the named ones.
//
// Few rows: partial sums per lane in registers, added to the batch's tally when the work-item
// returns.  Many rows: added to the tally at once.  Either way the sums are exact integers.
// Rows that are divided are many; `first_part` and `parts` say in which cell those of each begin, `part` is
// the one of each lane.  An effect writes these at `travel`, and the host adds the parts up.
% for n, name in enumerate(ledger):
#define ROW_${name.upper().replace(".", "_")} ${n}
% endfor

typedef struct {
    __global long *tally;
    lint interactions;
% if passes:
    lint passed;
% endif
% for r in range(ledger_rows):
    lint a${r}, b${r}, c${r};
% endfor
% if "ledger_parts" in counts:
    long first_part, parts;
    lint part;
% endif
} ledger_t;
<%
    divided = "ledger_parts" in counts
    cell_of = lambda row, l: f"(ledger->first_part + {row} * ledger->parts + {lane('ledger->part', l)})" if divided else row
%>

FN void open_ledger(ledger_t *ledger, __global long *tally) {
    ledger->tally = tally;
    ledger->interactions = lsplat(0L);
% if passes:
    ledger->passed = lsplat(0L);
% endif
% for r in range(ledger_rows):
    ledger->a${r} = lsplat(0L); ledger->b${r} = lsplat(0L); ledger->c${r} = lsplat(0L);
% endfor
% if divided:
    ledger->first_part = 0L;
    ledger->parts = 1L;
    ledger->part = lsplat(0L);
% endif
}

% if books and not ledger_rows:
FN void add_limbs(__global long *cell, long a, long b, long c) {
    if (a) atom_add(cell, a);
    if (b) atom_add(cell + 1, b);
    if (c) atom_add(cell + 2, c);
}
% endif

// Has an element's row fetched before what it absorbs is booked: an atomic addition waits for it, and
// another core may have it.
FN void expect(const ledger_t *ledger, lint element, mask m) {
% if "acceleration" in effects and not ledger_rows and not divided:
% for l in range(lanes):
    if (${lane("m", l)}) FETCH_TO_WRITE(ledger->tally + ${lane("element", l)} * CELL);
% endfor
% endif
}

// Books the image on row[lane], an element or `escaped`, of each lane in m.
FN void book(ledger_t *ledger, lint row, mask m, image_t image) {
% for r in range(n_elements + 1 if ledger_rows else 0):
    {
        const lint k = INT_MASK(m & IEQ(row, lsplat(${r}L)));
        ledger->a${r} += image.p0 & k; ledger->b${r} += image.p1 & k; ledger->c${r} += image.p2 & k;
    }
% endfor
% if books and not ledger_rows:
% for l in range(lanes):
    if (${lane("m", l)})
        add_limbs(ledger->tally + ${cell_of(lane("row", l), l)} * CELL, ${lane("image.p0", l)}, ${lane("image.p1", l)}, ${lane("image.p2", l)});
% endfor
% endif
}

// Books the image on one of the rows behind the elements'.
FN void book_row(const launch_t *launch, ledger_t *ledger, int which, mask m, image_t image) {
% if ledger_rows:
    // `which` is a constant where this is called: the comparisons vanish
% for k in range(len(ledger)):
    if (which == ${k}) {
        ledger->a${n_elements + k} += image.p0 & INT_MASK(m);
        ledger->b${n_elements + k} += image.p1 & INT_MASK(m);
        ledger->c${n_elements + k} += image.p2 & INT_MASK(m);
    }
% endfor
% else:
    book(ledger, lsplat((long)launch->n_elements + which), m, image);
% endif
}

FN void close_ledger(ledger_t *ledger) {
% for r in range(ledger_rows):
    {
        const long a = sum_lanes(ledger->a${r}), b = sum_lanes(ledger->b${r}), c = sum_lanes(ledger->c${r});
        if (a) atom_add(ledger->tally + ${r} * CELL, a);
        if (b) atom_add(ledger->tally + ${r} * CELL + 1, b);
        if (c) atom_add(ledger->tally + ${r} * CELL + 2, c);
    }
% endfor
}

// Adds weights to cells that an effect has of its own: of each lane in m its w, and one to the count, to
// cell `first` + number.  0 <= w <= 4, which the weight of a ray keeps: what is longer must be scaled
// (Effect.scale).  A cell that was given another number is filled up, and the host ends the run.
FN void count_weights(const ledger_t *ledger, ulong first, lint number, mask m, weight w) {
% if books:
    const mask fits = WEIGHT_GE(w, weight_splat(0.0)) & WEIGHT_LE(w, weight_splat(4.0));
    const image_t image = image_of(SEL_WEIGHT(fits, w, weight_splat(0.0)));
% for l in range(lanes):
    if (${lane("m", l)}) {
        __global long *cell = ledger->tally + (first + (ulong)${lane("number", l)}) * CELL;
        if (!${lane("fits", l)}) atom_xchg(cell, 3L << 61);
        atom_add(cell, ${lane("image.p0", l)});
        if (${lane("image.p1", l)}) atom_add(cell + 1, ${lane("image.p1", l)});
        if (${lane("image.p2", l)}) atom_add(cell + 2, ${lane("image.p2", l)});
        atom_add(cell + 3, 1L);
    }
% endfor
% endif
}

// Interactions have a row of their own, the last cell of a batch's tally; only its count is used.
FN void count_interactions(const launch_t *launch, const ledger_t *ledger, long n) {
    atom_add(ledger->tally + (launch->n_cells - 1) * CELL + 3, ${point("ledger.interactions", "n")});
}
