## effects
// A detector counts arrivals on one side of an absorbing element.
// Columns of its integers: 0 side (1: from the + side), 1 power cell, 2 ladder cell, 3 ladder
// entries, 4 map cell, 5 nx, 6 ny, 7 x edges, 8 y edges, 9 shape (0 flat, 1 sphere).
// Columns of its numbers: 0-2 centre, 3-11 frame.
#define DETECTOR_INTEGERS 10
#define DETECTOR_NUMBERS 12

FN void count_arrival(__global long *cells, const launch_t *launch, __global const long *codes,
                      __global const double *numbers, __global const double *edges,
                      double w, double x, double y, double z, uint tag, uint generation) {
    const long which = codes[launch->detector_of + (tag >> 1)];
    __global const long *d = codes + launch->detectors + which * DETECTOR_INTEGERS;
    if ((tag & 1u) != (uint)d[0]) return;
    // the power of a detector with a ladder or a map is their sum, which the host takes
    if (!(d[3] || d[5])) add_exact(cells + d[1] * CELL, w);
% if "ladder" in effects:
    if (d[3]) {
        const long g = min((long)generation, d[3] - 1);
        add_exact(cells + (d[2] + g) * CELL, w);
    }
% endif
% if "map" in effects:
    if (d[5]) {
        __global const double *row = numbers + which * DETECTOR_NUMBERS;
        const double px = x - row[0], py = y - row[1], pz = z - row[2];
        const double u = fma(px, row[3], fma(py, row[4], pz * row[5]));
        const double v = fma(px, row[6], fma(py, row[7], pz * row[8]));
        int i, j;
        if (d[9]) {
            const double h = fma(px, row[9], fma(py, row[10], pz * row[11]));
            i = azimuth_bin(edges + d[7], (int)d[5], u, v);
            j = linear_bin(edges + d[8], (int)d[6], h);
        } else {
            i = linear_bin(edges + d[7], (int)d[5], u);
            j = linear_bin(edges + d[8], (int)d[6], v);
        }
        add_exact(cells + (d[4] + j * d[5] + i) * CELL, w);
    }
% endif
}
