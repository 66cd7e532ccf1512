## cls: the element class; rendered once a class
<% inward = "inward" in cls.traits %>
// The wall of a convex body of revolution about the local axis, between two planes across it, its rims
// included.  With F(p) = x^2 + y^2 - P(z), P quadratic, the body is F < 0; along a ray
// F = a t^2 + 2 b t + c, and with s^2 = b^2 - a c the ray is inside from
//   t_in = (-b - s)/a = c/(-b + s)   to   t_out = (-b + s)/a = c/(-b - s):
// F falls at the one and rises at the other, whatever the sign of a.  Where a <= 0 only one of them is on
// the body's own nappe, which the heights of the rims tell; a ray along a generator (a = b = 0) has no
// root.  A ray that left the wall on its outside never meets it again, since the body is convex; one
// that left it on its inside meets it again at -2 b/a, if a > 0.
//
// Row: REVOLVED_, see photizon_cl/scene/elements/revolved.py.
//
// f, b: F and half its slope along the ray; size: of the terms of F.
typedef struct { real f, b, size; } form_${cls.suffix};

// What the element's own file says: a; where on the ray F is best taken to solve it; F there; half the
// length of its gradient at a point of the wall; the height over the wall; whether a point is within
// the rims, give or take so much along the axis and across it.
FN real bend_${cls.suffix}(__global const double *row, local_${cls.suffix} r);
FN real anchor_${cls.suffix}(__global const double *row, local_${cls.suffix} r, real a);
FN form_${cls.suffix} form_at_${cls.suffix}(__global const double *row, local_${cls.suffix} r, real t);
FN real steepness_${cls.suffix}(__global const double *row, real x, real y, real z);
FN real height_${cls.suffix}(__global const double *row, local_${cls.suffix} r, real f);
FN mask in_rims_${cls.suffix}(__global const double *row, real x, real y, real z, real along, real across);
% if "polished" in cls.traits:
// Whether the roots have to be polished, since the wall is long, flat or pointed: then F at one end of
// it says little of the other.
FN bool polishes_${cls.suffix}(__global const double *row);
% endif
% if "pointed" in cls.traits:
// Where a ray that is inside has left the body at the latest: rounding may lose a root at the apex.
FN real latest_${cls.suffix}(__global const double *row, local_${cls.suffix} r);
% endif

// s^2 with the products' rounding errors carried along.
FN real discriminant_${cls.suffix}(real a, form_${cls.suffix} q) {
    const real bb = q.b * q.b, af = a * q.f;
    return (bb - af) + (fma(q.b, q.b, -bb) - fma(a, q.f, -af));
}

// Whether the ray meets the wall at t within its rims, to the rounding of its coordinates there and of
// t, which is `slide`: much where the ray grazes the wall, and no more than its tangent leaves it.
// s: that of the root.
FN mask within_${cls.suffix}(__global const double *row, local_${cls.suffix} r, real a, real t, real s, real near) {
    const real x = fma(t, r.dx, r.x), y = fma(t, r.dy, r.y), z = fma(t, r.dz, r.z);
    // what is farther away than the wall is not at its rims
    near += fmin((fabs(x) + fabs(y) + fabs(z)) * R(4.0 * UNIT_ROUNDOFF), splat(row[REVOLVED_MOST] - row[REVOLVED_NEAR]));
    const real rise = R(0.5) * near * (steepness_${cls.suffix}(row, x, y, z) + near);
    // rise s / (s^2 + |a| rise / 2), without a product of three lengths, which may leave the range
    const real slide = rise / fma(R(0.5) * fabs(a), rise / s, s);
    return in_rims_${cls.suffix}(row, x, y, z, fma(slide, fabs(r.dz), near),
                                 fma(slide, fabs(r.dx) + fabs(r.dy), near));
}

% if "polished" in cls.traits:
// The root near t from F there.
FN real polish_${cls.suffix}(__global const double *row, local_${cls.suffix} r, real a, real t) {
    const form_${cls.suffix} q = form_at_${cls.suffix}(row, r, t);
    const real s = sqrt(fmax(discriminant_${cls.suffix}(a, q), splat(0.0)));
    const real most = q.b + copysign(s, q.b), step = q.f / most;
    return SEL(LT(fabs(step), splat(INFINITY)), t - step, t);
}
% endif

FN mask hit_${cls.suffix}(__global const double *row, long code, const packet_t *p, lint left,
                      const scene_t *scene, search_t *search, real *t_out, lint *face_out) {
    const real zero = splat(0.0);
    const local_${cls.suffix} r = to_local_${cls.suffix}(row, p);
    const real a = bend_${cls.suffix}(row, r);
    const mask departed = IEQ(left, lsplat(code)), free_lanes = ~departed & p->alive;
    const mask inside = departed & ${"INE" if inward else "IEQ"}(p->left & 2L, lsplat(0L));
    *face_out = lsplat(0L);
    const form_${cls.suffix} start = form_at_${cls.suffix}(row, r, zero);
    const real near = fma(fabs(r.x) + fabs(r.y) + fabs(r.z), splat(4.0 * UNIT_ROUNDOFF), splat(row[REVOLVED_NEAR]));
    real chord = R(2.0) * fabs(start.b) / a;
% if "polished" in cls.traits:
    const bool polishes = polishes_${cls.suffix}(row);
    // twice: the chord of a ray that grazes the wall it left is good to no more than a few digits
    if (polishes) chord = fmax(polish_${cls.suffix}(row, r, a, polish_${cls.suffix}(row, r, a, chord)), zero);
% endif
    const mask chord_ends = GT(a, zero) & within_${cls.suffix}(row, r, a, chord, fabs(start.b), near);
    real t = chord;
    mask ok = inside & chord_ends;
% if "pointed" in cls.traits:
    const real latest = latest_${cls.suffix}(row, r);
    t = SEL(chord_ends, chord, latest);
    ok = inside & (chord_ends | ${point("revolved.latest", "LT(latest, splat(INFINITY))")});
% endif
    if (ANY(free_lanes)) {
        const real at = anchor_${cls.suffix}(row, r, a);
        const form_${cls.suffix} q = form_at_${cls.suffix}(row, r, at);
        real square = discriminant_${cls.suffix}(a, q);
% if "polished" in cls.traits:
        if (polishes) {
            // whether the ray meets the body at all is best asked where it is deepest in it
            const form_${cls.suffix} deep = form_at_${cls.suffix}(row, r, at - q.b / a);
            const mask better = LT(fma(deep.b, deep.b, fabs(a) * deep.size), fma(q.b, q.b, fabs(a) * q.size));
            square = SEL(better, discriminant_${cls.suffix}(a, deep), square);
        }
% endif
        const real s = sqrt(fmax(square, zero));
        const real most = -(q.b + copysign(s, q.b)), one = most / a, other = SEL(EQ(most, zero), zero, q.f / most);
        real t1 = at + fmin(one, other), t2 = at + fmax(one, other);
% if "polished" in cls.traits:
        if (polishes) {
            t1 = polish_${cls.suffix}(row, r, a, t1);
            t2 = polish_${cls.suffix}(row, r, a, t2);
        }
% endif
        const mask meets = GE(square, zero) | LT(start.f, zero) | LE(a, zero);
        mask ok1 = meets & GE(t1, zero) & within_${cls.suffix}(row, r, a, t1, s, near);
        mask ok2 = meets & GE(t2, zero) & within_${cls.suffix}(row, r, a, t2, s, near);
        const real height = height_${cls.suffix}(row, r, start.f);
        mask on_wall = free_lanes & LE(fabs(height), near);
        // a ray that starts in line with the wall, beyond a rim, goes in or out
        ok1 &= ~on_wall;
        t2 = SEL(on_wall, chord, t2);
        ok2 = SELM(on_wall, LT(start.b, zero) & chord_ends, ok2);
% if "contact" in effects:
        const double most_near = row[REVOLVED_MOST], middle = 0.5 * (row[REVOLVED_LOW] + row[REVOLVED_HIGH]);
        const mask beside = free_lanes & LE(fabs(height), splat(64.0 * most_near))
            & LE(fabs(r.z - R(middle)), splat(fma(128.0, most_near, row[REVOLVED_HIGH] - middle)));
% else:
        const mask beside = on_wall & in_rims_${cls.suffix}(row, r.x, r.y, r.z, near, near);
% endif
        search->doubtful |= beside;
        if (search->careful && ANY(beside)) {
% if "contact" in effects:
            real nx = zero, ny = zero, nz = zero;
            normal_${cls.suffix}(scene, lsplat(code), beside, p->ox, p->oy, p->oz, &nx, &ny, &nz);
            mask on_minus, cross;
            on_wall = starts_on(search, p, beside, code, on_wall, ${"-" if inward else ""}height, splat(most_near), nx, ny, nz,
                                ${"-" if inward else ""}start.b, &on_minus, &cross);
            // beside the rim a point may have been put back onto another face that ends there
            const real beside_rim = ${point("revolved.beside", "splat(8.0 * most_near)")};
            cross &= in_rims_${cls.suffix}(row, r.x, r.y, r.z, beside_rim, beside_rim);
% else:
            on_wall = beside;
            const mask cross = crosses(p, on_wall, -start.b);
% endif
            t1 = SEL(on_wall, zero, t1);
            ok1 = SELM(on_wall, cross, ok1);
            t2 = SEL(on_wall, chord, t2);
            ok2 = SELM(on_wall, LT(start.b, zero) & chord_ends, ok2);
        }
        t = SEL(free_lanes, SEL(ok1, t1, t2), t);
        ok = SELM(free_lanes, ok1 | ok2, ok);
    }
    *t_out = t;
    return ok & p->alive;
}
% if inward:

// A ray inside ends on the inside, whatever the rounding of d.n says.
FN void sides_${cls.suffix}(const packet_t *p, const hit_t *h, mask m, contact_t *c) {
    c->from_plus |= m & IEQ(p->left >> 2, h->code) & INE(p->left & 2L, lsplat(0L));
}
% endif
