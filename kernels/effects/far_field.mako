// Far field: what escapes, binned by direction; n_mu bins uniform in cos theta about world +z, n_phi
// uniform in phi.  reads: record (weight, direction).  writes: one cell.
FN void count_escape(__global long *cells, const launch_t *launch, __global const double *edges,
                     const ending_record_t *end) {
    const int j = linear_bin(edges + launch->mu_edges, (int)launch->n_mu, end->z);
    const int i = azimuth_bin(edges + launch->phi_edges, (int)launch->n_phi, end->x, end->y);
    add_exact(cells + (launch->far_field + (ulong)j * launch->n_phi + ${point("far_field.column", "i")}) * CELL, end->w);
}
