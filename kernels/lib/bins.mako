## ending_fields
// An ending as the tally stage reads it: one number of each.
typedef struct {
% for field in ending_fields:
    ${{"real": "double", "weight": "double", "word": "uint"}[field.type]} ${field.name};  // ${field.meaning}
% endfor
} ending_record_t;

// Bins by exact edge tests, one number at a time.

// An arrival as filters see it: its place in the detector's own frame, in m, and its generation.
typedef struct {
    double u, v, w;
    uint generation;
% if "line" in ending_word:
    uint line;  // of the spectrum
% endif
} arrival_t;

// The bin of x among n bins with ascending edges[0..n]; the first and last bin take what rounding
// put outside.  Half-open upwards, the last bin closed.
FN int linear_bin(__global const double *edges, int n, double x) {
    const double first = edges[0], width = (edges[n] - first) / n;
    int k = (int)clamp((x - first) / width, 0.0, (double)(n - 1));
    while (k > 0 && x < edges[k]) k--;
    while (k < n - 1 && x >= edges[k + 1]) k++;
    return k;
}

// The bin of the azimuth of (x, y) among n equal bins from 0; edges[2k], edges[2k+1] are the cosine
// and sine of edge k.  An edge is passed when the cross product with it is not negative.
FN int azimuth_bin(__global const double *edges, int n, double x, double y) {
    if (y == 0.0) return x < 0.0 ? n / 2 : 0;
    int low = y > 0.0 ? 0 : n / 2;
    int high = y > 0.0 ? n / 2 : n - 1;
    while (low < high) {
        const int k = (low + high + 1) / 2;
        if (edges[2 * k] * y >= edges[2 * k + 1] * x) low = k;
        else high = k - 1;
    }
    return low;
}
