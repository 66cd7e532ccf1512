## cls: the element class; rendered once a class
// Square tube, open at both ends, with plates across it that have a square hole.
// Faces: 0 +u wall, 1 -u wall, 2 +v wall, 3 -v wall (normals away from the axis), 4 + i the plate
// number i + 1 at z = L (i + 1)/(N + 1) (normal along the axis).
// Row: BAFFLED_TUBE_, see photizon_cl/scene/elements/baffled_tube.py.
<%def name="starts(face, within, height, speed, nx, ny, nz)">
% if "contact" in effects:
        // noted from farther beside the face than it is hit from, as for flat faces
        mask beside = met & ${point("baffled_tube.beside", "LE(fabs(off), R(64.0) * most)")};
        if (ANY(beside)) beside &= ${within("R(128.0) * most")};
        search->doubtful |= beside;
        if (search->careful && ANY(beside)) {
            real nx, ny, nz;
            turn_${cls.suffix}(row, ${nx}, ${ny}, ${nz}, &nx, &ny, &nz);
            mask on_minus, cross;
            const mask here = starts_on(search, p, beside, WITH_FACE(code, ${face}), on, ${height}, most, nx, ny, nz, ${speed},
                                        &on_minus, &cross);
            t = SEL(here, splat(0.0), t);
            ok = SELM(here, cross & NE(${speed}, splat(0.0)) & ${within("R(8.0) * most")}, ok);
        }
% else:
        const mask here = on & ok;
        search->doubtful |= here;
        if (search->careful && ANY(here)) ok &= ~on | crosses(p, here, ${height} * (${speed}));
% endif
</%def>
FN mask hit_${cls.suffix}(__global const double *row, long code, const packet_t *p, lint left,
                      const scene_t *scene, search_t *search, real *t_out, lint *face_out) {
    const local_${cls.suffix} r = to_local_${cls.suffix}(row, p);
    const mask ours = IEQ(WITHOUT_FACE(left), lsplat(code)) & p->alive;
    const lint left_face = FACE_OF(left);
    const real reach = (fabs(r.x) + fabs(r.y) + fabs(r.z)) * R(4.0 * UNIT_ROUNDOFF);
    const real near = reach + R(row[BAFFLED_TUBE_NEAR]);
    const real outer = reach + R(row[BAFFLED_TUBE_OUTER]);
    const real low = -near, high = near + R(row[BAFFLED_TUBE_LENGTH]);
% if "contact" in effects:
    const real most = splat(fma(2.0 * row[BAFFLED_TUBE_HALF] + row[BAFFLED_TUBE_LENGTH], 4.0 * UNIT_ROUNDOFF, row[BAFFLED_TUBE_NEAR])), around = fmax(fabs(r.x), fabs(r.y));
    const scalar middle = R(0.5 * row[BAFFLED_TUBE_LENGTH]);
% endif
    real best = splat(INFINITY);
    lint face = lsplat(0L);
    mask found = NO_LANES;
% for n, (w, o, sign) in enumerate((("x", "y", 1), ("x", "y", -1), ("y", "x", 1), ("y", "x", -1))):
    {
        const real off = R(${"" if sign == 1 else "-"}row[BAFFLED_TUBE_HALF]) - r.${w};
        const mask on = LE(fabs(off), near), met = p->alive & ~(ours & IEQ(left_face, lsplat(${n}L)));
        real t = SEL(on, splat(0.0), off / r.d${w});
        mask ok = met & NE(r.d${w}, splat(0.0)) & GE(t, splat(0.0))
            & LE(fabs(fma(t, r.d${o}, r.${o})), outer)
            & GE(fma(t, r.dz, r.z), low) & LE(fma(t, r.dz, r.z), high);
${starts(f"{n}L", lambda m: f"LE(fabs(r.{o}), {m} + R(row[BAFFLED_TUBE_HALF])) & LE(fabs(r.z - middle), {m} + middle)",
         f"off * R({-sign}.0)", f"r.d{w} * R({sign}.0)", *(f"splat({sign}.0)" if v == w else "splat(0.0)" for v in "xyz"))}
        const mask closer = ok & LT(t, best);
        best = SEL(closer, t, best);
        face = SELI(closer, lsplat(${n}L), face);
        found |= ok;
    }
% endfor
    const int plates = (int)row[BAFFLED_TUBE_PLATES];
    for (int i = 0; i < plates; i++) {
        const real off = R(row[BAFFLED_TUBE_LENGTH] * (i + 1) / (plates + 1)) - r.z;
        const mask on = LE(fabs(off), near), met = p->alive & ~(ours & IEQ(left_face, lsplat(4L + i)));
        real t = SEL(on, splat(0.0), off / r.dz);
        const real x = fabs(fma(t, r.dx, r.x)), y = fabs(fma(t, r.dy, r.y));
        mask ok = met & NE(r.dz, splat(0.0)) & GE(t, splat(0.0))
            & LE(fmax(x, y), outer) & GE(fmax(x, y), R(row[BAFFLED_TUBE_HOLE]) - reach);
${starts("4L + i", lambda m: f"LE(around, {m} + R(row[BAFFLED_TUBE_HALF])) & GE(around, R(row[BAFFLED_TUBE_HOLE]) - {m})", "-off", "r.dz",
         "splat(0.0)", "splat(0.0)", "splat(1.0)")}
        const mask closer = ok & LT(t, best);
        best = SEL(closer, t, best);
        face = SELI(closer, lsplat(4L + i), face);
        found |= ok;
    }
    *t_out = best;
    *face_out = face;
    return found;
}

FN void shape_${cls.suffix}(const scene_t *scene, lint row, lint face, real *x, real *y, real *z,
                        real *nx, real *ny, real *nz) {
    const real h = gather(scene->geometry + BAFFLED_TUBE_HALF, row), inner = gather(scene->geometry + BAFFLED_TUBE_INNER, row);
    const real length = gather(scene->geometry + BAFFLED_TUBE_LENGTH, row), plates = gather(scene->geometry + BAFFLED_TUBE_PLATES, row);
    const mask wall = ILT(face, lsplat(4L)), u_wall = ILT(face, lsplat(2L)), v_wall = wall & ~u_wall;
    const real sign = SEL(IEQ(face & 1L, lsplat(1L)), splat(-1.0), splat(1.0));
    const real plate = length * TO_REAL(face - 3L) / (plates + R(1.0));
    *x = SEL(u_wall, sign * h, clamp(*x, -inner, inner));
    *y = SEL(v_wall, sign * h, clamp(*y, -inner, inner));
    *z = SEL(wall, clamp(*z, splat(0.0), length), plate);
    *nx = SEL(u_wall, sign, splat(0.0));
    *ny = SEL(v_wall, sign, splat(0.0));
    *nz = SEL(wall, splat(0.0), splat(1.0));
}

// A wall met within rounding of a plate: the height of the hit moved off the plate, to the side that
// the ray is on.  That is the side of the plate it left, if it comes from there, and else where it
// comes from.
FN real moved_${cls.suffix}(const scene_t *scene, lint row, const packet_t *p, const hit_t *h, real x, real y, real z) {
    const lint code = h->code;
    const real length = gather(scene->geometry + BAFFLED_TUBE_LENGTH, row), plates = gather(scene->geometry + BAFFLED_TUBE_PLATES, row);
    const real i = clamp(rint(z * (plates + R(1.0)) / length), splat(1.0), fmax(plates, splat(1.0)));
    const real at = length * i / (plates + R(1.0));
    const real room = fma(fabs(x) + fabs(y) + fabs(z), splat(16.0 * UNIT_ROUNDOFF), R(4.0) * gather(scene->geometry + BAFFLED_TUBE_NEAR, row));
    const mask near = ILT(FACE_OF(code), lsplat(4L)) & GT(plates, splat(0.0)) & LT(fabs(z - at), R(0.5) * room);
    __global const double *w = scene->geometry + ROW_FRAME + 6;
    const real dz = dot3(p->dx, p->dy, p->dz, gather(w, row), gather(w + 1, row), gather(w + 2, row));
    const lint plate = WITH_FACE(WITHOUT_FACE(code), TO_LINT(i) + 3L);
    mask above = SELM(IEQ(p->left >> 2, plate), INE(p->left & 2L, lsplat(0L)), LT(dz, splat(0.0)));
% if "contact" in effects:
    if (ANY(near)) {
        mask below;
        const mask known = known_side(&h->noted, near, plate, &below);
        above = SELM(known & INE(p->left >> 2, plate), ~below, above);
    }
% endif
    return SEL(near, at + SEL(above, room, -room), z);
}

// A ray inside ends on the inside of a wall, whatever the rounding of d.n says; both sides of a plate
// are inside.
FN void sides_${cls.suffix}(const packet_t *p, const hit_t *h, mask m, contact_t *c) {
    const mask same = m & IEQ(WITHOUT_FACE(p->left >> 2), WITHOUT_FACE(h->code));
    const mask was_inside = IEQ(p->left & 2L, lsplat(0L));
    const mask plate = IGE(FACE_OF(h->code), lsplat(4L));
% if "contact" in effects:
    // ... unless it is in a corner, where its side of every face is known
    const mask inward = GT(h->t, splat(0.0));
% else:
    const mask inward = ALL_LANES;
% endif
    c->from_minus |= same & ~plate & inward & (was_inside | IGE(FACE_OF(p->left >> 2), lsplat(4L)));
    c->inner |= m & plate;
}
