// A table of the BSDF: linear between nodes.
// A node: Delta, the BSDF there, its slope behind, the larger value of the two around the way to the next node,
// and the integral of those times Delta up to here.  Delta is tried under these steps, and taken with the
// chance of the line under them.
// reads: nodes.  gives: beta; BSDF.
#define NODE 5L
#define NODE_STEPS 128UL
FN mask try_table(const lobe_t *s, ulong seed, mask m, draws_t *draws, real u, real v, real *x, real *y) {
    __global const double *table = s->table;
    const lint first = lobe_place(s, SCATTER_NODES), n = lobe_place(s, SCATTER_NODE_COUNT);
    const real far = lobe_reach(s);
    const lint last = first + NODE * place_in(table, first, n, NODE, NODE_STEPS, far);
    const real node = gather(table, last);
    const real whole = gather(table + 4, last) + R(0.5) * gather(table + 3, last) * (far - node) * (far + node);
    const real sought = u * whole;
    const lint at = first + NODE * place_in(table, first + 4L, n, NODE, NODE_STEPS, sought);
    const real most = gather(table + 3, at), low = gather(table, at);
    const mask some = GT(most, splat(0.0));
    const real more = R(2.0) * (sought - gather(table + 4, at)) / SEL(some, most, splat(1.0));
    const real r = sqrt(fma(low, low, more));
    place_about(s, r, v, x, y);
    next_draws(seed, m, draws);
    const real line = fma(gather(table + 2, at), r - low, gather(table + 1, at));
    return m & some & LT(u01_closed_open(draws->c0, draws->c1) * most, ${point("table.line", "line")});
}
% if densities:

FN real bsdf_table(const lobe_t *s, real square) {
    const lint first = lobe_place(s, SCATTER_NODES), n = lobe_place(s, SCATTER_NODE_COUNT);
    const real r = sqrt(square);
    const lint at = first + NODE * place_in(s->table, first, n, NODE, NODE_STEPS, r);
    const real behind = r - gather(s->table, at);
    const real line = fma(gather(s->table + 2, at), behind, gather(s->table + 1, at));
    // behind the last node there is nothing
    const mask beyond = IEQ(at, first + NODE * (n - 1L)) & GT(behind, splat(0.0));
    return SEL(beyond, splat(0.0), fmax(line, splat(0.0)));
}
% endif
