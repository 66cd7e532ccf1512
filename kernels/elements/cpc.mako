## cls: the element class; rendered once a class
// Compound parabolic concentrator: the wall of a body of revolution about the axis, from the exit
// aperture (z = 0, radius a') to the entrance (z = L).  One face, normal away from the axis.
//
// The meridian is a parabola tilted by the acceptance angle (Winston, Minano, Benitez, ch. 4):
//   G(r, z) = (C r + S z)^2 + B r - D z - E = 0,   C = cos, S = sin of the acceptance angle,
//   B = 2 a' (1 + S)^2, D = 2 a' C (2 + S), E = a'^2 (1 + S)(3 + S).
// Solved for r: R(z) = 2 Q / (P + sqrt(alpha + beta z)), Q = E + D z - S^2 z^2, P = 2 C S z + B.
// R is concave, so the body is convex and f(t) = R(z(t)) - r(t) is a concave function along any ray:
// it has at most two roots, and Newton's iteration from a point where f < 0 runs up to the nearer
// root without ever passing it.  No quartic, and nothing to deflate: which root is wanted follows
// from the side the ray starts on.
//
// Lengths are scaled by a power of two so that a' is about 1.
// Row: CPC_, see photizon_cl/scene/elements/cpc.py; all but the position and the frame scaled.
typedef struct { real f, slope; } profile_${cls.suffix};

FN profile_${cls.suffix} profile_at_${cls.suffix}(__global const double *row, local_${cls.suffix} r, real t) {
    profile_${cls.suffix} out;
    const real x = fma(t, r.dx, r.x), y = fma(t, r.dy, r.y), z = fma(t, r.dz, r.z);
    const real radius = sqrt(fma(x, x, y * y));
    const real flat_speed = sqrt(fma(r.dx, r.dx, r.dy * r.dy));
    const real q = fma(z, fma(-z, splat(row[CPC_SINE] * row[CPC_SINE]), splat(row[CPC_D])), splat(row[CPC_E]));
    const real wall = R(2.0) * q / (fma(z, splat(2.0 * row[CPC_COSINE] * row[CPC_SINE]), splat(row[CPC_B]))
                                 + sqrt(fmax(fma(z, splat(row[CPC_BETA]), splat(row[CPC_ALPHA])), splat(0.0))));
    const real w = fma(wall, splat(row[CPC_COSINE]), z * R(row[CPC_SINE]));
    const real wall_slope = (R(row[CPC_D]) - R(2.0 * row[CPC_SINE]) * w) / fma(w, splat(2.0 * row[CPC_COSINE]), splat(row[CPC_B]));
    const real speed = SEL(GT(radius, splat(0.0)), fma(x, r.dx, y * r.dy) / radius, flat_speed);
    out.f = wall - radius;
    out.slope = fma(wall_slope, r.dz, -speed);
    return out;
}

FN mask hit_${cls.suffix}(__global const double *row, long code, const packet_t *p, lint left,
                      const scene_t *scene, search_t *search, real *t_out, lint *face_out) {
    local_${cls.suffix} r = to_local_${cls.suffix}(row, p);
    const scalar scale = R(row[CPC_SCALE]);
    r.x *= scale; r.y *= scale; r.z *= scale;
    const real zero = splat(0.0), far = splat(INFINITY);
    const mask nowhere = NO_LANES;
    // the part of the ray between the apertures, rims included
    const real size = fabs(r.x) + fabs(r.y) + fabs(r.z);
    const real room = fma(size, splat(4.0 * UNIT_ROUNDOFF), splat(fma(row[CPC_LENGTH], 8.0 * UNIT_ROUNDOFF, row[CPC_NEAR])));
    const real below = -room, above = room + R(row[CPC_LENGTH]);
    const real ta = (below - r.z) / r.dz, tb = (above - r.z) / r.dz;
    const mask along = EQ(r.dz, zero);
    const mask between = GE(r.z, below) & LE(r.z, above);
    real first = SEL(along, SEL(between, zero, far), fmax(fmin(ta, tb), zero));
    real last = SEL(along, SEL(between, far, -far), fmax(ta, tb));
    // and inside the cylinder around it
    const real aa = fma(r.dx, r.dx, r.dy * r.dy), bb = fma(r.x, r.dx, r.y * r.dy);
    const real cc = fma(r.x, r.x, r.y * r.y) - R(row[CPC_OUTER] * row[CPC_OUTER]);
    const real root = sqrt(fmax(fma(bb, bb, -aa * cc), zero));
    const real q = -(bb + copysign(root, bb));
    const mask axial = EQ(aa, zero);
    const real u0 = q / aa, u1 = SEL(EQ(q, zero), zero, cc / q);
    const mask meets = SELM(axial, LE(cc, zero), GE(fma(bb, bb, -aa * cc), zero));
    first = SEL(axial, first, fmax(first, fmin(u0, u1)));
    // where it leaves the cylinder first it leaves through the wall, whatever the rounding there says
    const mask by_aperture = axial | LE(last, fmax(u0, u1));
    last = SEL(axial, last, fmin(last, fmax(u0, u1)));
    const mask departed = IEQ(left, lsplat(code));
    const mask inside_departed = departed & IEQ(p->left & 2L, lsplat(0L));
    mask possible = p->alive & (inside_departed | (~departed & meets & LE(first, last)));
% if "contact" in effects:
    // a ray that starts beside the wall remembers on which side, also where it goes away for good; whether
    // it is noted must not depend on the other lanes
    const double most = fma(2.0 * row[CPC_OUTER] + row[CPC_LENGTH], 8.0 * UNIT_ROUNDOFF, row[CPC_NEAR]);
    const double wide = 128.0 * most;
    const mask around = ~departed & p->alive & LE(cc, splat(wide * (wide + 2.0 * row[CPC_OUTER])))
        & LE(fabs(r.z - R(0.5 * row[CPC_LENGTH])), splat(wide + 0.5 * row[CPC_LENGTH]));
% else:
    const mask around = nowhere;
% endif
    if (!ANY(possible | ${point("cpc.around", "around")})) {
        *t_out = far;
        *face_out = lsplat(0L);
        return NO_LANES;
    }
    const profile_${cls.suffix} start = profile_at_${cls.suffix}(row, r, zero);
    const real near = fma(size, splat(8.0 * UNIT_ROUNDOFF), splat(row[CPC_NEAR]));
    mask on_wall = LE(fabs(start.f), near), starts = nowhere;
% if "contact" in effects:
    const mask beside = around & LE(fabs(start.f), ${point("cpc.beside", "splat(64.0 * most)")});
    search->doubtful |= beside;
    on_wall = nowhere;
    if (search->careful && ANY(beside)) {
        real nx = zero, ny = zero, nz = zero;
        normal_${cls.suffix}(scene, lsplat(code), beside, p->ox, p->oy, p->oz, &nx, &ny, &nz);
        mask on_minus, cross;
        on_wall = starts_on(search, p, beside, code, LE(fabs(start.f), near), -start.f / scale, splat(most / scale), nx, ny, nz,
                            -start.slope, &on_minus, &cross);
        starts = on_wall & cross & between;
    }
% else:
    on_wall &= ~departed & possible & between;
    search->doubtful |= on_wall;
    if (search->careful && ANY(on_wall)) starts = crosses(p, on_wall, start.slope);
% endif
    possible &= ~on_wall | starts | GT(start.slope, zero);
    const profile_${cls.suffix} enters = profile_at_${cls.suffix}(row, r, first);
    const mask inside = inside_departed | (on_wall & GT(start.slope, zero)) | (~on_wall & GE(enters.f, zero));
    // from inside the way out is sought from the far end backwards, from outside the way in forwards
    last = fmax(last, zero);
    real t = SEL(inside, last, first);
    mask active = possible & ~starts;
    mask ok = active;
    for (int step = 0; step < 100 && ANY(active); step++) {
        const profile_${cls.suffix} g = profile_at_${cls.suffix}(row, r, t);
        const mask reached = GE(g.f, zero);
        // reached at the first step from inside: it leaves through an aperture
        ok &= ~(active & inside & by_aperture & reached & ALL_LANES_IF(step == 0) & GT(g.f, zero));
        // the wrong slope from outside: it passes by
        const mask passes = active & ~inside & ~reached & LE(g.slope, zero);
        ok &= ~passes;
        const real next = t - g.f / g.slope;
        const mask moves = SELM(inside, LT(next, t), GT(next, t));
        const mask goes_on = active & ~reached & ~passes & moves;
        t = SEL(goes_on, next, t);
        active = goes_on;
    }
    t = SEL(starts, zero, fmax(t, zero));
    ok = (ok & (inside | LE(t, last))) | starts;
    *t_out = t / scale;
    *face_out = lsplat(0L);
    return ok & p->alive & possible;
}

FN void shape_${cls.suffix}(const scene_t *scene, lint row, lint face, real *px, real *py, real *pz,
                        real *nx, real *ny, real *nz) {
    const real scale = gather(scene->geometry + CPC_SCALE, row), length = gather(scene->geometry + CPC_LENGTH, row);
    const real c = gather(scene->geometry + CPC_COSINE, row), s = gather(scene->geometry + CPC_SINE, row);
    const real b = gather(scene->geometry + CPC_B, row), d = gather(scene->geometry + CPC_D, row);
    const real e = gather(scene->geometry + CPC_E, row);
    const real x = *px * scale, y = *py * scale;
    real z = *pz * scale, r = sqrt(fma(x, x, y * y));
    const real ux = x / r, uy = y / r;
    real gr = r, gz = r, k = r;
    for (int step = 0; step < 2; step++) {
        const real w = fma(c, r, s * z);
        const real g = fma(w, w, fma(b, r, -fma(d, z, e)));
        gr = fma(R(2.0) * c, w, b);
        gz = fma(R(2.0) * s, w, -d);
        k = fma(gr, gr, gz * gz);
        r = fma(-g / k, gr, r);
        z = clamp(fma(-g / k, gz, z), splat(0.0), length);
    }
    const real w = fma(c, r, s * z);
    gr = fma(R(2.0) * c, w, b);
    gz = fma(R(2.0) * s, w, -d);
    const real n = R(1.0) / sqrt(fma(gr, gr, gz * gz));
    *px = ux * r / scale; *py = uy * r / scale; *pz = z / scale;
    *nx = ux * gr * n; *ny = uy * gr * n; *nz = gz * n;
}
