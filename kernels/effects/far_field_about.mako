// Far field about an axis of choice: what escapes, binned by its direction in a frame of the far field's
// own; rows by theta between edges, or uniform in cos theta; n_phi columns uniform in phi.
// reads: record (weight, direction); edges: frame (9 numbers), rows, columns.
// writes: one cell, or none beyond the edges.
% if counts["far_field_theta"]:
// The row of the angle from the axis among n rows; edges[2k], edges[2k+1] are the cosine and sine of edge
// k, ascending in the angle, and the direction has a component along the axis and one across it, which is
// not negative.  An edge is passed when the cross product with it is not negative, which is exact to
// rounding at any angle, where cosines alone would not be near the axis.  -1 beyond the edges; the last
// row is closed.
FN int polar_bin(__global const double *edges, int n, double along, double across) {
    if (edges[0] * across < edges[1] * along || edges[2 * n] * across > edges[2 * n + 1] * along) return -1;
    int low = 0, high = n - 1;
    while (low < high) {
        const int k = (low + high + 1) / 2;
        if (${point("far_field_about.passed", "edges[2 * k] * across >= edges[2 * k + 1] * along")}) low = k;
        else high = k - 1;
    }
    return low;
}

% endif
FN void count_escape(__global long *cells, const launch_t *launch, __global const double *edges,
                     const ending_record_t *end) {
    __global const double *frame = edges + launch->far_frame;
% for n, name in enumerate("uvw"):
    const double ${name} = fma(end->x, frame[${3 * n}], fma(end->y, frame[${3 * n + 1}], end->z * frame[${3 * n + 2}]));
% endfor
% if counts["far_field_theta"]:
    const int j = polar_bin(edges + launch->far_rows, (int)launch->n_rows, w, sqrt(fma(u, u, v * v)));
    if (j < 0) return;
% else:
    const int j = linear_bin(edges + launch->far_rows, (int)launch->n_rows, w);
% endif
    const int i = azimuth_bin(edges + launch->phi_edges, (int)launch->n_phi, u, v);
    add_exact(cells + (launch->far_field + (ulong)j * launch->n_phi + i) * CELL, end->w);
}
