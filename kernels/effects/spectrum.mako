// Spectrum: a ray carries the number of the line that it is of.  What depends on wavelength is tabulated by
// line on the host: a material has a row for each, and the ledger's rows a cell for each.
// reads: beams' lines, in codes.  gives: the line of a launched ray.
FN lint line_of_ray(const launch_t *launch, const scene_t *scene, wide ray) {
    lint line = lsplat(0L);
    for (ulong s = 0; s < launch->n_sources; s++) {
        __global const double *source = scene->sources + s * SOURCE_STRIDE;
        const mask k = IGE(ray, (wide)(source[SOURCE_FIRST_RAY])) & ILT(ray, (wide)(source[SOURCE_END_RAY]));
        line = SELI(k, lsplat(${point("spectrum.line", "scene->codes[launch->beam_lines + s]")}), line);
    }
    return line;
}

// Has what follows booked in the cells of each lane's line.
FN void part_by_line(const launch_t *launch, ledger_t *ledger, lint line) {
    ledger->first_part = (long)launch->line_rows;
    ledger->parts = (long)launch->lines;
    ledger->part = ${point("spectrum.booked", "line")};
}
% if "band_degree" in counts:

// Bands: a ray has a wavelength of its own, uniform per nm in its band, and knows it as the piece of the band
// that it is in and the place there: numbers that depend on wavelength are polynomials of that
// (photizon_cl/compile/grid.py).
// reads: edges of the pieces, draw DECIDE_WAVELENGTH.  gives: piece and place of a launched ray.
#define DECIDE_WAVELENGTH 7u
typedef struct { lint piece; real along; } spot_t;
FN spot_t spot_of_ray(const launch_t *launch, const scene_t *scene, lint line, word lo, word hi) {
    real u, v;
    draw_pair(launch->seed, lo, hi, (luint)(1UL), wsplat(0u), DECIDE_WAVELENGTH, &u, &v);
    __global const double *edges = scene->geometry + launch->band_edges;
    lint low = gather_long(scene->codes + launch->band_pieces, line);
    lint high = gather_long(scene->codes + launch->band_pieces + 1, line);
    const real first = gather(edges, low), last = gather(edges, high);
    const real nm = fma(${point("spectrum.in_band", "u")}, last - first, first);
    // the last piece that does not begin above it
    for (ulong k = 0; k < launch->band_steps; k++) {
        const lint middle = (low + high) >> 1;
        const mask up = LE(gather(edges, middle), nm);
        low = SELI(up, middle, low);
        high = SELI(up, high, middle);
    }
    const real from = gather(edges, low), width = gather(edges, low + 1L) - from;
    spot_t spot;
    spot.piece = low;
    // in single precision two edges may be one
    spot.along = SEL(GT(width, splat(0.0)), clamp((nm - from) / width, splat(0.0), splat(1.0)), splat(0.0));
    return spot;
}
% endif
