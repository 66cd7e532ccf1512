// By wavelength: the number of the line of the spectrum.
FN long bin_wavelength(__global const double *edges, long bins, const arrival_t *a) {
    return ${point("wavelength.line", "(long)a->line")};
}
