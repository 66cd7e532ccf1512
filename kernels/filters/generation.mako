// By generation: surface interactions before the arrival; the last entry collects all that have more.
FN long bin_generation(__global const double *edges, long bins, const arrival_t *a) {
    return min(${point("generation.entry", "(long)a->generation")}, bins - 1);
}
