// By azimuth about the detector's axis, from u towards v; edges as `azimuth_bin` takes them.
FN long bin_azimuth(__global const double *edges, long bins, const arrival_t *a) {
    return azimuth_bin(edges, (int)bins, ${point("azimuth.plane", "a->u, a->v")});
}
