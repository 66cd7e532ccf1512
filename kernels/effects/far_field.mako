// Far field: what escapes, binned by direction; n_mu bins uniform in cos theta about world +z, n_phi
// uniform in phi.  reads: record (weight, direction).  writes: one cell.
FN void count_escape(__global long *cells, const launch_t *launch, __global const double *edges,
                     double w, double dx, double dy, double dz) {
    const int j = linear_bin(edges + launch->mu_edges, (int)launch->n_mu, dz);
    const int i = azimuth_bin(edges + launch->phi_edges, (int)launch->n_phi, dx, dy);
    add_exact(cells + (launch->far_field + (ulong)j * launch->n_phi + i) * CELL, w);
}
