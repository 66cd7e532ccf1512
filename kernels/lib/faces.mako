## effects
// A ray starts within rounding on another face, `code`, whose normal there is n: is that face hit at
// distance zero?
// - A launched ray leaves every face it starts on.
% if "contact" in effects:
// - Else it is hit if the ray goes through to the other side of it than it is on: the side that it
//   came from on its last way of any length, or, for a face it has left since, the side it then was
//   on.  The last three faces left are remembered: up to three may lie in one place.
% endif
// - Where that says nothing (the edges of two faces), the sign of the distance decides.
FN mask crosses(const search_t *search, const packet_t *p, long code, real nx, real ny, real nz,
                real d_n, real h_d) {
    const mask launched = EQ(p->left, lsplat(NO_FACE));
    mask crossing = LE(h_d, splat(0.0));
% if "contact" in effects:
    const real came = dot3(p->came_x, p->came_y, p->came_z, nx, ny, nz);
    mask on_minus = GT(came, splat(0.0)), known = NE(came, splat(0.0));
% for memory in ("earlier", "before"):
    {
        const mask here = EQ(p->${memory} >> 2, lsplat(code));
        on_minus = SEL(here, EQ(p->${memory} & 2L, lsplat(0L)), on_minus);
        known |= here;
    }
% endfor
    crossing = SEL(known, on_minus ^ LT(d_n, splat(0.0)), crossing);
% endif
    return ~launched & crossing;
}
