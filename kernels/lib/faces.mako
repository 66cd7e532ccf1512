## classes: every element class of the program; effects
// The outward unit normal of the face `code` at a point on it, for each lane in m.
FN void face_normal(const scene_t *scene, lint code, mask m, real x, real y, real z,
                    real *nx, real *ny, real *nz) {
    *nx = splat(0.0); *ny = splat(0.0); *nz = splat(0.0);
% for cls in classes:
    normal_${cls.suffix}(scene, code, m & EQ(CLASS_OF(code), lsplat(${cls.number}L)), x, y, z, nx, ny, nz);
% endfor
}

// A ray starts within rounding on another face, `code`, whose normal there is n: is that face hit at
// distance zero?
// - A launched ray leaves every face it starts on.
// - Where the face just left is parallel (faces in contact), the ray hits this one only if it goes
//   through to the other side of it than it is on: the side it was on when it came to the face just
//   left, or, where it left this very face and has not moved since, the side it then was on.  The
//   last three faces left are remembered: up to three may lie in one place.
// - Elsewhere (an edge) the sign of the distance decides.
FN mask crosses(const search_t *search, const packet_t *p, long code, real nx, real ny, real nz,
                real d_n, real h_d) {
    const mask launched = EQ(p->left, lsplat(NO_FACE));
    const real parallel = dot3(nx, ny, nz, search->mx, search->my, search->mz);
    const mask contact = GE(fabs(parallel), splat(1.0 - 0x1p-20));
    mask on_minus = LT(parallel, splat(0.0)) ^ EQ(p->left & 1L, lsplat(0L));
% if "contact" in effects:
% for memory in ("earlier", "before"):
    on_minus = SEL(EQ(p->${memory} >> 2, lsplat(code)), EQ(p->${memory} & 2L, lsplat(0L)), on_minus);
% endfor
% endif
    const mask goes_minus = LT(d_n, splat(0.0));
    return ~launched & SEL(contact, on_minus ^ goes_minus, LE(h_d, splat(0.0)));
}
