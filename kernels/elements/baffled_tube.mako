## cls: the element class; rendered once a class
// Square tube, open at both ends, with plates across it that have a square hole.
// Faces: 0 +u wall, 1 -u wall, 2 +v wall, 3 -v wall (normals away from the axis), 4 + i the plate
// number i + 1 at z = L (i + 1)/(N + 1) (normal along the axis).
// Row: 0-2 centre of the entrance, 3 h, 4 h with its rounding bound, 5 h less that bound, 6 L, 7 N,
// 8 half hole less its rounding bound, 9 rounding bound of a coordinate, 15-23 frame.
<%def name="starts(face, within, height, speed, nx, ny, nz)">
% if "contact" in effects:
        // noted from farther beside the face than it is hit from, as for flat faces
        mask beside = met & LE(fabs(off), 64.0 * most);
        if (ANY(beside)) beside &= ${within("128.0 * most")};
        search->doubtful |= beside;
        if (search->careful && ANY(beside)) {
            real nx, ny, nz;
            turn_${cls.suffix}(row, ${nx}, ${ny}, ${nz}, &nx, &ny, &nz);
            mask on_minus, cross;
            const mask here = starts_on(search, p, beside, WITH_FACE(code, ${face}), on, ${height}, most, nx, ny, nz, ${speed},
                                        &on_minus, &cross);
            t = SEL(here, splat(0.0), t);
            ok = SEL(here, cross & NE(${speed}, splat(0.0)) & ${within("8.0 * most")}, ok);
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
    const mask ours = EQ(WITHOUT_FACE(left), lsplat(code)) & p->alive;
    const lint left_face = FACE_OF(left);
    const real reach = (fabs(r.x) + fabs(r.y) + fabs(r.z)) * (4.0 * UNIT_ROUNDOFF);
    const real near = reach + row[9];
    const real wide = reach + row[4];
    const real low = -near, high = near + row[6];
% if "contact" in effects:
    const real most = splat(fma(2.0 * row[3] + row[6], 4.0 * UNIT_ROUNDOFF, row[9])), around = fmax(fabs(r.x), fabs(r.y));
    const double middle = 0.5 * row[6];
% endif
    real best = splat(INFINITY);
    lint face = lsplat(0L);
    mask found = lsplat(0L);
% for n, (w, o, sign) in enumerate((("x", "y", 1), ("x", "y", -1), ("y", "x", 1), ("y", "x", -1))):
    {
        const real off = ${"" if sign == 1 else "-"}row[3] - r.${w};
        const mask on = LE(fabs(off), near), met = p->alive & ~(ours & EQ(left_face, lsplat(${n}L)));
        real t = SEL(on, splat(0.0), off / r.d${w});
        mask ok = met & NE(r.d${w}, splat(0.0)) & GE(t, splat(0.0))
            & LE(fabs(fma(t, r.d${o}, r.${o})), wide)
            & GE(fma(t, r.dz, r.z), low) & LE(fma(t, r.dz, r.z), high);
${starts(f"{n}L", lambda m: f"LE(fabs(r.{o}), {m} + row[3]) & LE(fabs(r.z - middle), {m} + middle)",
         f"off * {-sign}.0", f"r.d{w} * {sign}.0", *(f"splat({sign}.0)" if v == w else "splat(0.0)" for v in "xyz"))}
        const mask closer = ok & LT(t, best);
        best = SEL(closer, t, best);
        face = SEL(closer, lsplat(${n}L), face);
        found |= ok;
    }
% endfor
    const int plates = (int)row[7];
    for (int i = 0; i < plates; i++) {
        const real off = row[6] * (i + 1) / (plates + 1) - r.z;
        const mask on = LE(fabs(off), near), met = p->alive & ~(ours & EQ(left_face, lsplat(4L + i)));
        real t = SEL(on, splat(0.0), off / r.dz);
        const real x = fabs(fma(t, r.dx, r.x)), y = fabs(fma(t, r.dy, r.y));
        mask ok = met & NE(r.dz, splat(0.0)) & GE(t, splat(0.0))
            & LE(fmax(x, y), wide) & GE(fmax(x, y), row[8] - reach);
${starts("4L + i", lambda m: f"LE(around, {m} + row[3]) & GE(around, row[8] - {m})", "-off", "r.dz",
         "splat(0.0)", "splat(0.0)", "splat(1.0)")}
        const mask closer = ok & LT(t, best);
        best = SEL(closer, t, best);
        face = SEL(closer, lsplat(4L + i), face);
        found |= ok;
    }
    *t_out = best;
    *face_out = face;
    return found;
}

FN void shape_${cls.suffix}(const scene_t *scene, lint row, lint face, real *x, real *y, real *z,
                        real *nx, real *ny, real *nz) {
    const real h = gather(scene->geometry + 3, row), inner = gather(scene->geometry + 5, row);
    const real length = gather(scene->geometry + 6, row), plates = gather(scene->geometry + 7, row);
    const mask wall = LT(face, lsplat(4L)), u_wall = LT(face, lsplat(2L)), v_wall = wall & ~u_wall;
    const real sign = SEL(EQ(face & 1L, lsplat(1L)), splat(-1.0), splat(1.0));
    const real plate = length * TO_REAL(face - 3L) / (plates + 1.0);
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
FN real beside_plates_${cls.suffix}(const scene_t *scene, lint row, const packet_t *p, const hit_t *h, real x, real y, real z) {
    const lint code = h->code;
    const real length = gather(scene->geometry + 6, row), plates = gather(scene->geometry + 7, row);
    const real i = clamp(rint(z * (plates + 1.0) / length), splat(1.0), fmax(plates, splat(1.0)));
    const real at = length * i / (plates + 1.0);
    const real room = fma(fabs(x) + fabs(y) + fabs(z), splat(16.0 * UNIT_ROUNDOFF), 4.0 * gather(scene->geometry + 9, row));
    const mask near = LT(FACE_OF(code), lsplat(4L)) & GT(plates, splat(0.0)) & LT(fabs(z - at), 0.5 * room);
    __global const double *w = scene->geometry + ROW_FRAME + 6;
    const real dz = dot3(p->dx, p->dy, p->dz, gather(w, row), gather(w + 1, row), gather(w + 2, row));
    const lint plate = WITH_FACE(WITHOUT_FACE(code), TO_LINT(i) + 3L);
    mask above = SEL(EQ(p->left >> 2, plate), NE(p->left & 2L, lsplat(0L)), LT(dz, splat(0.0)));
% if "contact" in effects:
    if (ANY(near)) {
        mask below;
        const mask known = known_side(&h->noted, near, plate, &below);
        above = SEL(known & NE(p->left >> 2, plate), ~below, above);
    }
% endif
    return SEL(near, at + SEL(above, room, -room), z);
}
