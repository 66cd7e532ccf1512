## option: u, v or w
// By the coordinate along ${option} of the detector's own frame, between ascending edges.
FN long bin_along_${option}(__global const double *edges, long bins, const arrival_t *a) {
    return linear_bin(edges, (int)bins, ${point("along.coordinate", "a->" + option)});
}
