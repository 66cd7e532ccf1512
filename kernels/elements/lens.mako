## cls: the element class; rendered once a class
// Lens: two faces, each a conic of revolution about the axis or a plane, and the edge, a cylinder between
// their rims.  Faces: 0 front (its vertex up the axis), 1 back, 2 edge; normals out of the glass.
// Row: LENS_, see photizon_cl/scene/elements/general_lens.py.
//
// It need not be convex, so each face is a closed surface by itself, as lib/quadric.mako has it.  A ray is
// in the glass or outside of it, which it knows from the face that it left, or which the signs at its start
// say: inside it meets the first face that it goes out of, outside the first one that it goes into.  One
// that left a face to the outside can only meet that face again, where it is concave: the lens lies within
// the cylinder of its edge.
<%
    sheets = (("front", 0, ""), ("back", 1, "-"))
    faces = ("front", "back", "edge")
%>
% for name, n, sign in sheets:
FN quadric_t ${name}_${cls.suffix}(__global const double *row) {
    quadric_t q;
    q.c = R(row[LENS_${name.upper()}_CURVATURE]); q.kappa = R(row[LENS_${name.upper()}_KAPPA]); q.m = R(1.0); q.g = R(0.0);
    return q;
}
% endfor
FN quadric_t edge_${cls.suffix}(__global const double *row) {
    quadric_t q;
    q.c = R(1.0 / row[LENS_RIM]); q.kappa = R(0.0); q.m = R(0.0); q.g = R(-row[LENS_RIM]);
    return q;
}

// Whether a point of a face is within its rims, give or take so much along the axis and across it.
% for name, n, sign in sheets:
FN mask in_${name}_${cls.suffix}(__global const double *row, real x, real y, real w, real along, real across) {
    const double sag = row[LENS_${name.upper()}_SAG];
    const real most = across + R(row[LENS_RIM]);
    return GE(w, R(fmin(-sag, 0.0)) - along) & LE(w, R(fmax(-sag, 0.0)) + along) & LE(fma(x, x, y * y), most * most);
}
% endfor
FN mask in_edge_${cls.suffix}(__global const double *row, real x, real y, real w, real along, real across) {
    return LE(fabs(w), along + R(row[LENS_HALF])) & ALL_LANES_IF(row[LENS_HALF] > 0.0);
}

// Whether the ray meets a face at t within its rims, to the rounding of its coordinates there and of t, which on the
// edge is then put to where the ray is within them: other elements may stand between.
% for name in faces:
FN mask within_${name}_${cls.suffix}(__global const double *row, const quadric_t *q, const meridian_t *r, real a, real *t, real s,
                              real near) {
    const real x = fma(*t, r->dx, r->x), y = fma(*t, r->dy, r->y), w = fma(*t, r->dw, r->w);
    // of the place over the middle, whose height w was taken from; what is farther away than the lens is not at
    // its rims
    near ${point("lens.grown", "+=")} fmin((fabs(x) + fabs(y) + fabs(w) + fabs(splat(${"row[LENS_HALF]" if name == "edge" else f"row[LENS_{name.upper()}_VERTEX]"}))) * R(4.0 * UNIT_ROUNDOFF), splat(row[LENS_MOST] - row[LENS_NEAR]));
    const real slide = quadric_slide(q, a, quadric_steepness(q, x, y, w), s, near);
    const mask there = in_${name}_${cls.suffix}(row, x, y, w, fma(slide, fabs(r->dw), near),
                              fma(slide, fabs(r->dx) + fabs(r->dy), near));
% if name == "edge":
    // a ray may graze it for as long as one likes, while the others bend away; of little, as in a corner, t is right
    const real tall = fma(near, R(16.0), splat(row[LENS_HALF])), rim = clamp(w, -tall, tall);
    *t = SEL(there & NE(w, rim), ${point("lens.beside", "(rim - r->w) / r->dw")}, *t);
% endif
    return there & GE(*t, splat(0.0));
}
% endfor

FN mask hit_${cls.suffix}(__global const double *row, long code, const packet_t *p, lint left,
                      const scene_t *scene, search_t *search, real *t_out, lint *face_out) {
    const real zero = splat(0.0);
    const local_${cls.suffix} r = to_local_${cls.suffix}(row, p);
    const mask ours = IEQ(ELEMENT_OF(left), lsplat(ELEMENT_OF(code))) & p->alive;
    const lint left_face = FACE_OF(left);
    const mask to_inside = IEQ(p->left & 2L, lsplat(0L));
    const real near = fma(fabs(r.x) + fabs(r.y) + fabs(r.z), splat(4.0 * UNIT_ROUNDOFF), splat(row[LENS_NEAR]));
    const mask alive = p->alive;
% for name, n, sign in sheets:
    const quadric_t q${n} = ${name}_${cls.suffix}(row);
    const meridian_t r${n} = {r.x, r.y, ${sign}r.z - R(row[LENS_${name.upper()}_VERTEX]), r.dx, r.dy, ${sign}r.dz};
    const bool polishes${n} = row[LENS_${name.upper()}_POLISHES] != 0.0;
    const real at${n} = -dot3(r${n}.x, r${n}.y, r${n}.w, r.dx, r.dy, r${n}.dw);
% endfor
    const quadric_t q2 = edge_${cls.suffix}(row);
    const meridian_t r2 = {r.x, r.y, r.z, r.dx, r.dy, r.dz};
    const bool polishes2 = false;
    // the point nearest to the axis: there b is nothing but rounding
    const real at2 = -fma(r.x, r.dx, r.y * r.dy) / fma(r.dx, r.dx, r.dy * r.dy);
% for n, name in enumerate(faces):
    const mask left${n} = ours & IEQ(left_face, lsplat(${n}L));
    const real a${n} = quadric_bend(&q${n}, &r${n});
    const quadric_form_t start${n} = quadric_at(&q${n}, &r${n}, zero);
    const real height${n} = R(0.5) * start${n}.f / quadric_steepness(&q${n}, r.x, r.y, r${n}.w);
% endfor
    // beyond a face's heights its function says nothing of the glass
% for name, n, sign in sheets:
    mask in${n};
    {
        const double sag = row[LENS_${name.upper()}_SAG];
        in${n} = LT(r${n}.w, splat(fmin(-sag, 0.0))) | (LE(r${n}.w, splat(fmax(-sag, 0.0))) & LE(start${n}.f, zero));
    }
% endfor
    mask in2 = LE(start2.f, zero);
    // the start on faces that were not left: a ray that does not hit them there goes on as if it had left them
% if "contact" in effects:
    const real most = splat(row[LENS_MOST]);
% for n, name in enumerate(faces):
    const mask beside${n} = alive & ~left${n} & LE(fabs(height${n}), R(64.0) * most)
        & in_${name}_${cls.suffix}(row, r.x, r.y, r${n}.w, R(128.0) * most, R(128.0) * most);
    mask starts${n} = NO_LANES, begins${n} = NO_LANES, goes_minus${n} = NO_LANES;
% endfor
    const mask beside = beside0 | beside1 | beside2;
    search->doubtful |= beside;
    mask is_in = in0 & in1 & in2;
    if (search->careful && ANY(beside)) {
        const mask within = ours & to_inside;
        mask cross;
% for n, name in enumerate(faces):
        mask minus${n}, on${n};
        {
            real nx, ny, nz, x = r.x, y = r.y, z = r.z, wx, wy, wz;
            shape_${cls.suffix}(scene, lsplat(ELEMENT_OF(code) * ROW), lsplat(${n}L), &x, &y, &z, &nx, &ny, &nz);
            turn_${cls.suffix}(row, nx, ny, nz, &wx, &wy, &wz);
            const real d_n = dot3(p->dx, p->dy, p->dz, wx, wy, wz);
            goes_minus${n} = LT(d_n, zero);
            // inside it is on the inside of all its faces
            on${n} = ~ours & starts_on(search, p, beside${n}, WITH_FACE(code, ${n}L), LE(fabs(height${n}), near) & ~within,
                                   SEL(within, R(-64.0) * most, height${n}), most, wx, wy, wz, d_n, &minus${n}, &cross);
        }
        // beyond its rims, and there on the face gone on with, rounding says nothing of what is within them
        const mask was${n} = SELM(on${n}, minus${n}, in${n} | (~beside${n} & ${point("lens.beyond", f"LE(height{n}, R(64.0) * most)")}\
${"" if name == "edge" else f" & LE(r{n}.w, R(fmax(-row[LENS_{name.upper()}_SAG], 0.0)) + R(128.0) * most)"}));
% endfor
        // it hits the lens where it goes from its outside to its inside or back; and where it goes in by one
        // face although it leaves another one behind at once, as at a rim, which belongs to both
        const mask was_in = was0 & was1 & was2;
        is_in = SELM(beside, ${" & ".join(f"SELM(on{n}, goes_minus{n}, was{n})" for n in range(3))}, is_in);
        const mask hits = (on0 | on1 | on2) & (was_in ^ is_in), moves = INE(p->left, lsplat(NO_FACE));
% for n, (a, b) in enumerate(((1, 2), (0, 2), (0, 1))):
        starts${n} = moves & ${point("lens.touched", f"(hits | (was{a} & was{b}))")} & on${n} & (minus${n} ^ goes_minus${n});
        begins${n} = ${point("lens.begun", f"on{n}")};
% endfor
    }
% else:
% for n, name in enumerate(faces):
    const mask on${n} = alive & ~ours & LE(fabs(height${n}), near) & in_${name}_${cls.suffix}(row, r.x, r.y, r${n}.w, near, near);
    in${n} = SELM(on${n}, LT(start${n}.b, zero), in${n});
% endfor
    const mask is_in = in0 & in1 & in2;
    search->doubtful |= on0 | on1 | on2;
% for n in range(3):
    // at an edge a ray that goes in hits the face, one that goes out leaves it behind
    const mask starts${n} = crosses(p, on${n} & is_in, start${n}.b);
% endfor
% endif
    const mask inside = SELM(ours, to_inside, is_in), asked = alive & ~(ours & ~to_inside);
    real best = splat(INFINITY);
    lint face = lsplat(0L);
% for n, name in enumerate(faces):
    {
        real t, s;
% if name == "edge":
        const real slack = zero, rounding = zero, least = zero;
% else:
        // What is in the glass gets out of a face that bulges, though it graze it, and on that side of it that its
        // normal there tells.
        const real crossing = splat(8.0 * fma(fabs(row[LENS_${name.upper()}_CURVATURE]), row[LENS_MOST], 2.0 * UNIT_ROUNDOFF));
% if "contact" in effects:
        const real rounding = fabs(a${n}) * R(row[LENS_MOST]), least = SEL(inside, crossing, sqrt(rounding));
        const real slack = SEL(inside & ALL_LANES_IF(q${n}.c > R(0.0)), splat(INFINITY), fma(R(2.0) * fabs(a${n}), near, rounding));
% else:
        const real rounding = SEL(inside, fabs(a${n}) * R(row[LENS_MOST]), splat(-INFINITY)), least = SEL(inside, crossing, zero);
        const real slack = SEL(inside & ALL_LANES_IF(q${n}.c > R(0.0)), splat(INFINITY), zero);
% endif
% endif
        const mask meets = quadric_crossing(&q${n}, &r${n}, a${n}, start${n}, at${n}, inside, polishes${n}, slack, rounding, least, &t, &s);
        mask ok = asked & ~left${n} & meets & within_${name}_${cls.suffix}(row, &q${n}, &r${n}, a${n}, &t, s, near);
% if "contact" in effects:
        // of a face that it starts on and does not hit, on whichever side, the near root is no hit either
        ok &= ~begins${n};
        const mask chords = left${n} | (begins${n} & (inside ^ ~goes_minus${n}));
% else:
        const mask chords = left${n};
% endif
        if (ANY(chords)) {
% if name == "edge":
            // a chord of the edge is as good as its ray is steep to the axis, however small it is
            const real across = fmax(fabs(start2.b), R(0.25) * sqrt(a2 / q2.c));
% else:
            const real across = fabs(start${n}.b);
% endif
            real chord = quadric_chord(&q${n}, &r${n}, a${n}, start${n}, polishes${n});
            ok = SELM(chords, SELM(inside, GT(a${n}, zero), ${point("lens.hollow", f"LT(a{n}, zero)")})
                          & within_${name}_${cls.suffix}(row, &q${n}, &r${n}, a${n}, &chord, across, near), ok);
            t = SEL(chords, chord, t);
        }
        // in a corner, rounding may have put the start of a ray that is inside behind the other face
        const mask corner = ours & inside & ~left${n} & LE(fabs(height${n}), near) & GT(start${n}.b, zero)
            & in_${name}_${cls.suffix}(row, r.x, r.y, r${n}.w, near, near);
        const mask here = ${point("lens.corner", "corner")} | starts${n};
        t = SEL(here, zero, t);
        ok |= here;
        const mask closer = ok & LT(t, best);
        best = SEL(closer, t, best);
        face = SELI(closer, lsplat(${n}L), face);
    }
% endfor
    // from inside there is always an exit, no farther than the box around the lens, whatever rounding says
    const mask lost = ${point("lens.lost", "alive & inside & ~LT(best, splat(INFINITY))")};
    if (ANY(lost)) {
        real to_edge, s;
        quadric_crossing(&q2, &r2, a2, start2, at2, ALL_LANES, false, zero, zero, zero, &to_edge, &s);
        const mask up = GT(r.dz, zero);
        const real end = SEL(up, splat(fmax(row[LENS_HALF], row[LENS_FRONT_VERTEX])), splat(-fmax(row[LENS_HALF], row[LENS_BACK_VERTEX])));
        real to_end = (end - r.z) / r.dz;
        to_edge = SEL(LT(fabs(to_edge), splat(INFINITY)), fmax(to_edge, zero), splat(INFINITY));
        to_end = SEL(LT(fabs(to_end), splat(INFINITY)), fmax(to_end, zero), splat(INFINITY));
        const mask by_face = LT(to_end, to_edge) | ALL_LANES_IF(row[LENS_HALF] == 0.0);
        best = SEL(lost, fmin(to_edge, to_end), best);
        face = SELI(lost, SELI(by_face, SELI(up, lsplat(0L), lsplat(1L)), lsplat(2L)), face);
    }
    *t_out = best;
    *face_out = face;
    return alive & LT(best, splat(INFINITY));
}

FN void shape_${cls.suffix}(const scene_t *scene, lint row, lint face, real *px, real *py, real *pz,
                        real *nx, real *ny, real *nz) {
    const mask edge = IEQ(face, lsplat(2L)), back = IEQ(face, lsplat(1L));
    const real rim = gather(scene->geometry + LENS_RIM, row), tall = gather(scene->geometry + LENS_HALF, row);
    const lint column = row + SELI(back, lsplat(LENS_BACK_CURVATURE - LENS_FRONT_CURVATURE), lsplat(0L));
    const real c = gather(scene->geometry + LENS_FRONT_CURVATURE, column), kappa = gather(scene->geometry + LENS_FRONT_KAPPA, column);
    const real sag = gather(scene->geometry + LENS_FRONT_SAG, column), vertex = gather(scene->geometry + LENS_FRONT_VERTEX, column);
    const real sign = SEL(back, splat(-1.0), splat(1.0)), ck = c * kappa;
    real x = *px, y = *py, w = fma(sign, *pz, -vertex);
    for (int step = 0; step < ${point("lens.projections", 2)}; step++) {
        const real cx = c * x, cy = c * y, g = fma(ck, w, splat(1.0));
        const real f = fma(cx, x, fma(cy, y, w * (g + R(1.0))));
        const real k = R(-0.5) * f / fma(cx, cx, fma(cy, cy, g * g));
        x = fma(k, cx, x); y = fma(k, cy, y); w = fma(k, g, w);
    }
    const real across = sqrt(fma(x, x, y * y)), scale = SEL(GT(across, rim), rim / across, splat(1.0));
    x *= scale; y *= scale;
    w = clamp(w, fmin(-sag, splat(0.0)), fmax(-sag, splat(0.0)));
    const real gx = c * x, gy = c * y, gw = fma(ck, w, splat(1.0));
    const real n = R(1.0) / sqrt(fma(gx, gx, fma(gy, gy, gw * gw)));
    const real away = sqrt(fma(*px, *px, *py * *py)), ux = *px / away, uy = *py / away;
    *px = SEL(edge, rim * ux, x);
    *py = SEL(edge, rim * uy, y);
    *pz = SEL(edge, clamp(*pz, -tall, tall), sign * (w + vertex));
    *nx = SEL(edge, ux, n * gx);
    *ny = SEL(edge, uy, n * gy);
    *nz = SEL(edge, splat(0.0), sign * (n * gw));
}

// A ray that left one of its faces is where it went, whatever the rounding of d.n says.
FN void sides_${cls.suffix}(const packet_t *p, const hit_t *h, mask m, contact_t *c) {
    const mask same = m & IEQ(ELEMENT_OF(p->left >> 2), ELEMENT_OF(h->code)) & INE(p->left, lsplat(NO_FACE));
    const mask inside = IEQ(p->left & 2L, lsplat(0L));
    c->from_minus |= same & inside;
    c->from_plus |= same & ~inside;
}
