## surfaces (kinds in use: .kind, .number, .single, .scatters), pairs, counts (of a target's numbers)
// Importance sampling: scattered rays are sent towards targets more often than their surfaces send them.
//
// One-sample multiple importance sampling (E. Veach, thesis, Stanford 1997, 9.2.4): with the chance a the
// direction is drawn from the targets' density p_t = sum q_k p_k, sum q_k = 1, else the one that the surface
// drew, from p_s, stays.  Its weight is multiplied by p_s / ((1 - a) p_s + a p_t), which is never more than
// 1 / (1 - a), and has the mean 1 over directions.  A target that cannot be seen from a place (it lies below
// the surface's horizon, or the place is in its plane, on its side that does not count or inside its ball)
// has no part there: what is chosen from what was known before the draw leaves every expectation as it is.
// Neither does a smaller a where the ray could come out more than twice as heavy as it was launched: there a
// is what just leaves it that heavy.  So no weight grows without end, however often a ray scatters.
//
// A flat target is a point of it, uniform by area: p = r^2 / (A |cos|).  Any other is a ball around it, and
// the directions of the cone that it fills, uniform by solid angle: p = 1 / (2 pi (1 - cos)).
//
// reads: outcome (the drawn ray), densities of surfaces, targets, draw DECIDE_TOWARD.
// writes: outcome (direction and weight of the drawn ray); row importance.balance, what its weight lost.
<%
    scattering = [s for s in surfaces if s.scatters]
    stride = counts["target_numbers"]
%>
#define DECIDE_TOWARD 5u
#define HEAVIEST ${point("importance.heaviest", "2.0")}
// Numbers of a target (photizon_cl/compile/effects/importance.py), and shapes (photizon_cl/geometry/targets.py).
% for name, place in counts.items():
% if name.startswith("TARGET_"):
#define ${name} ${place}
% endif
% endfor
#define IS_BALL(t) ((t)[TARGET_SHAPE] == ${counts["target_ball"]}.0)
#define IS_RING(t) ((t)[TARGET_SHAPE] == ${counts["target_ring"]}.0)

// A target from a place: the way to its centre; of a flat one how high that is along its normal, of a
// ball 1 - cos of the cone's half-angle; the lanes from which it can be seen at all.
typedef struct { real x, y, z, height; mask seen; } sight_t;

// up: the normal on the side on which the ray goes on.
FN sight_t see_target(__global const double *t, const contact_t *c, real upx, real upy, real upz) {
    sight_t s;
    s.x = R(t[TARGET_X]) - c->x; s.y = R(t[TARGET_Y]) - c->y; s.z = R(t[TARGET_Z]) - c->z;
    const real reach = splat(t[TARGET_REACH]);
    s.seen = GT(dot3(s.x, s.y, s.z, upx, upy, upz), -reach);
    if (IS_BALL(t)) {
        // sin^2 = R^2 / D^2, and 1 - cos = sin^2 / (1 + cos): no difference of nearly equal numbers
        const real d = sqrt(dot3(s.x, s.y, s.z, s.x, s.y, s.z));
        const real sine = reach / d, cosine = sqrt(fmax((R(1.0) - sine) * (R(1.0) + sine), splat(0.0)));
        s.height = sine * sine / (R(1.0) + cosine);
        s.seen &= LT(sine, splat(1.0 - 0x1p12 * UNIT_ROUNDOFF));
    } else {
        s.height = dot3(s.x, s.y, s.z, splat(t[TARGET_NX]), splat(t[TARGET_NY]), splat(t[TARGET_NZ]));
        const real about = fabs(s.x) + fabs(s.y) + fabs(s.z) + reach;
        s.seen &= GT(fabs(s.height), about * R(0x1p12 * UNIT_ROUNDOFF));
        // the side that counts is where the normal points to: from there the centre is behind it
        s.seen &= LE(R(t[TARGET_SIDE]) * s.height, splat(0.0));
    }
    return s;
}

// A direction towards a target from u and v in [0, 1], and its density per steradian.
FN real draw_target(__global const double *t, const sight_t *s, real u, real v, real *x, real *y, real *z) {
    real density, si, co;
    if (IS_BALL(t)) {
        sincos_turns(v, &si, &co);
        const real d = R(1.0) / sqrt(dot3(s->x, s->y, s->z, s->x, s->y, s->z));
        const real h = ${point("importance.height", "u")} * s->height, sine = sqrt(h * (R(2.0) - h));
        about_normal(s->x * d, s->y * d, s->z * d, sine * co, sine * si, R(1.0) - h, x, y, z);
        density = R(0x1.45f306dc9c883p-3) / s->height;
    } else {
        const real a = splat(t[TARGET_A]), b = splat(t[TARGET_B]);
        real p, q;
        if (IS_RING(t)) {
            sincos_turns(v, &si, &co);
            const real r = sqrt(fma(u, (a - b) * (a + b), b * b));
            p = r * co; q = r * si;
        } else {
            p = fma(splat(2.0), u, splat(-1.0)) * a;
            q = fma(splat(2.0), v, splat(-1.0)) * b;
        }
        *x = fma(p, splat(t[TARGET_UX]), fma(q, splat(t[TARGET_VX]), s->x));
        *y = fma(p, splat(t[TARGET_UY]), fma(q, splat(t[TARGET_VY]), s->y));
        *z = fma(p, splat(t[TARGET_UZ]), fma(q, splat(t[TARGET_VZ]), s->z));
        const real rr = dot3(*x, *y, *z, *x, *y, *z), r = sqrt(rr), k = R(1.0) / r;
        *x *= k; *y *= k; *z *= k;
        density = ${point("importance.by_area", "rr * r * R(t[TARGET_PER_AREA]) / fabs(s->height)")};
    }
    renormalise(x, y, z);
    return density;
}

// The density with which that gives a direction: 0 where it leads past the target.
FN real density_target(__global const double *t, const sight_t *s, real x, real y, real z) {
    if (IS_BALL(t)) {
        const real b = dot3(s->x, s->y, s->z, x, y, z);
        const real lx = fma(-b, x, s->x), ly = fma(-b, y, s->y), lz = fma(-b, z, s->z);
        const mask meets = GT(b, splat(0.0)) & LE(dot3(lx, ly, lz, lx, ly, lz), splat(t[TARGET_A] * t[TARGET_A]));
        return SEL(meets, R(0x1.45f306dc9c883p-3) / s->height, splat(0.0));
    }
    const real along = dot3(x, y, z, splat(t[TARGET_NX]), splat(t[TARGET_NY]), splat(t[TARGET_NZ]));
    const real k = R(1.0) / along, r = s->height * k;
    const real p = fma(r, dot3(x, y, z, splat(t[TARGET_UX]), splat(t[TARGET_UY]), splat(t[TARGET_UZ])),
                       -dot3(s->x, s->y, s->z, splat(t[TARGET_UX]), splat(t[TARGET_UY]), splat(t[TARGET_UZ])));
    const real q = fma(r, dot3(x, y, z, splat(t[TARGET_VX]), splat(t[TARGET_VY]), splat(t[TARGET_VZ])),
                       -dot3(s->x, s->y, s->z, splat(t[TARGET_VX]), splat(t[TARGET_VY]), splat(t[TARGET_VZ])));
    mask meets = GT(r, splat(0.0));
    if (IS_RING(t)) {
        const real pp = fma(p, p, q * q);
        meets &= LE(pp, splat(t[TARGET_A] * t[TARGET_A])) & GE(pp, splat(t[TARGET_B] * t[TARGET_B]));
    } else {
        meets &= LE(fabs(p), splat(t[TARGET_A])) & LE(fabs(q), splat(t[TARGET_B]));
    }
    return SEL(meets, r * r * R(t[TARGET_PER_AREA]) * fabs(k), splat(0.0));
}

// The density with which surfaces send a ray into a direction.
FN real density_scattered(const launch_t *launch, const scene_t *scene, const packet_t *p, const hit_t *h,
                          const contact_t *c, mask m, lint row, real x, real y, real z) {
    real density = splat(0.0);
% for surface in scattering:
    {
        const material_t material = {scene->materials, row, ${f"scene->codes[launch->material_of_kind + {surface.number}]" if surface.single else "-1"}${", p->along" if "piece" in ray_long else ""}};
        const encounter_t event = {m${f" & IEQ(SURFACE_OF(h->code), lsplat({surface.number}L))" if len(surfaces) > 1 else ""}, p, c, launch->seed};
        if (ANY(event.m)) density = SEL(event.m, density_${surface.kind}(&event, &material, x, y, z), density);
    }
% endfor
    return density;
}

// A ray that may be sent towards targets: the lanes in which it may, and in which it is; the chance a that it
// is; the share of the targets that can be seen, and their density into the direction that it takes.
typedef struct { mask m, sent; real a, seen, density; } aim_t;

// Chooses whether a ray is sent towards a target.  m: lanes that have a direction drawn from a density; path: the
// ray's place in its tree, which its draw is keyed by; drawn_w: its weight in any direction; up: the normal on
// the side on which it goes on.  x, y, z: the direction that its surface drew, and the one that it takes.
FN aim_t aim_ray(const launch_t *launch, const scene_t *scene, const packet_t *p, const contact_t *c, luint path,
                 mask m, weight drawn_w, real upx, real upy, real upz, real *x, real *y, real *z) {
    aim_t aim;
    aim.sent = NO_LANES;
    // the weight over the heaviest that it may become
% if "launched" in ray_real:
    const weight part = drawn_w / (p->launched * WT(HEAVIEST));
% else:
    const weight part = drawn_w * WT(1.0 / HEAVIEST);
% endif
    // the chance a, at most as large as weights allow
    const real a = fmin(splat(launch->toward_fraction), TO_REAL(weight_splat(1.0) - part));
    aim.a = a;
    aim.m = m & WEIGHT_GT(drawn_w, weight_splat(0.0)) & GT(a, splat(0.0));
    aim.seen = splat(0.0);
    aim.density = splat(0.0);
    if (!ANY(aim.m)) return aim;
    real u, v;
    draw_pair(launch->seed, p->ray_lo, p->ray_hi, path, p->generation, DECIDE_TOWARD, &u, &v);

    // the target that is drawn, if any: each has its own part of [0, 1), and what of u lies below a, over a,
    // is a new number there, and again within the part
    const real choice = u / a;
    __global const double *targets = scene->geometry + launch->targets;
    real seen = splat(0.0);         // share of the targets that can be seen
    real density = splat(0.0);      // of the targets, into the surface's own direction
    real aimed = splat(0.0);        // of the targets, into the one that is drawn
    real ax = *x, ay = *y, az = *z;
    lint drawn = lsplat(-1L);
    for (long k = 0; k < (long)launch->n_targets; k++) {
        __global const double *t = targets + k * ${stride};
        const sight_t s = see_target(t, c, upx, upy, upz);
        seen += SEL(s.seen, splat(t[TARGET_SHARE]), splat(0.0));
        density += SEL(s.seen, R(t[TARGET_SHARE]) * density_target(t, &s, *x, *y, *z), splat(0.0));
        const mask mine = aim.m & s.seen & GE(choice, splat(t[TARGET_FIRST])) & LT(choice, splat(t[TARGET_END]));
        if (ANY(mine)) {
            real tx, ty, tz;
            const real again = clamp((choice - R(t[TARGET_FIRST])) * R(t[TARGET_PER_SHARE]), splat(0.0), splat(1.0));
            const real own = draw_target(t, &s, again, v, &tx, &ty, &tz);
            aimed = SEL(mine, R(t[TARGET_SHARE]) * own, aimed);
            ax = SEL(mine, tx, ax); ay = SEL(mine, ty, ay); az = SEL(mine, tz, az);
            drawn = SELI(mine, lsplat(k), drawn);
        }
    }
    aim.m &= GT(seen, splat(0.0));
    if (!ANY(aim.m)) return aim;
    const mask sent = aim.m & IGE(drawn, lsplat(0L));
    for (long k = 0; launch->n_targets > 1 && k < (long)launch->n_targets; k++) {
        // what was drawn at a target's edge counts as met, wherever rounding put it
        const mask other = sent & INE(drawn, lsplat(k));
        if (!ANY(other)) continue;
        __global const double *t = targets + k * ${stride};
        const sight_t s = see_target(t, c, upx, upy, upz);
        aimed += SEL(other & s.seen, R(t[TARGET_SHARE]) * density_target(t, &s, ax, ay, az), splat(0.0));
    }
    *x = SEL(sent, ax, *x); *y = SEL(sent, ay, *y); *z = SEL(sent, az, *z);
    aim.sent = sent;
    aim.seen = seen;
    aim.density = SEL(sent, aimed, density);
    return aim;
}

// What such a ray weighs, given the density with which its surface sends it into the direction that it takes; w:
// what it would weigh in its surface's own direction, and `ratio` its weight over drawn_w.
FN weight weigh_aimed(const launch_t *launch, ledger_t *ledger, const aim_t *aim, real by_surface, weight w,
                      weight drawn_w, weight *ratio) {
    const real density = aim->density;
    const real both = fma(aim->a, ${point("importance.mixture", "density")}, fma(-aim->a, aim->seen, splat(1.0)) * by_surface);
    // a direction that the surface never takes has no weight: the ray ends
    const real factor = SEL(GT(by_surface, splat(0.0)), by_surface / both, splat(0.0));
    // where the surface's own draw led nowhere, nothing goes on unless another direction was drawn
    const mask goes = WEIGHT_GT(w, weight_splat(0.0)) | aim->sent;
    const weight after = SEL_WEIGHT(goes, drawn_w * TO_WEIGHT(${point("importance.ratio", "factor")}), weight_splat(0.0));
    const image_t lost = image_difference(image_of(w), ${point("importance.booked", "image_of(after)")});
    book_row(launch, ledger, ROW_IMPORTANCE_BALANCE, aim->m, lost);
    *ratio = SEL_WEIGHT(aim->m & WEIGHT_GT(after, weight_splat(0.0)), TO_WEIGHT(factor), weight_splat(1.0));
    return SEL_WEIGHT(aim->m, after, w);
}

FN void send_toward(const launch_t *launch, const scene_t *scene, const packet_t *p, const hit_t *h,
                    const contact_t *c, ledger_t *ledger, lint row, outcome_t *outcome) {
    if (!ANY(outcome->drawn)) return;
% if pairs:
    const mask second = outcome->drawn_second;
    const real up = SEL((second & c->came_plus) | (~second & outcome->went_plus), splat(1.0), splat(-1.0));
    real x = SEL(second, outcome->second_dx, outcome->dx), y = SEL(second, outcome->second_dy, outcome->dy);
    real z = SEL(second, outcome->second_dz, outcome->dz);
    const weight w = SEL_WEIGHT(second, SEL_WEIGHT(outcome->splits, outcome->second_w, weight_splat(0.0)), outcome->w);
% else:
    const real up = SEL(outcome->went_plus, splat(1.0), splat(-1.0));
    real x = outcome->dx, y = outcome->dy, z = outcome->dz;
    const weight w = outcome->w;
% endif
    const aim_t aim = aim_ray(launch, scene, p, c, path_of(p), outcome->drawn, outcome->drawn_w, up * c->nx,
                              up * c->ny, up * c->nz, &x, &y, &z);
    const mask m = aim.m;
    if (!ANY(m)) return;
    const real by_surface = density_scattered(launch, scene, p, h, c, m, row, x, y, z);
    weight ratio;
    const weight after = weigh_aimed(launch, ledger, &aim, by_surface, w, outcome->drawn_w, &ratio);
% if pairs:
    const mask first = m & ~second, other = m & second;
    outcome->second_dx = SEL(other, x, outcome->second_dx); outcome->second_dy = SEL(other, y, outcome->second_dy);
    outcome->second_dz = SEL(other, z, outcome->second_dz);
    outcome->second_w = SEL_WEIGHT(other, after, outcome->second_w);
    outcome->splits = (outcome->splits & ~other) | (other & WEIGHT_GT(after, weight_splat(0.0)));
% else:
    const mask first = m;
% endif
    outcome->dx = SEL(first, x, outcome->dx); outcome->dy = SEL(first, y, outcome->dy);
    outcome->dz = SEL(first, z, outcome->dz);
    outcome->w = SEL_WEIGHT(first, after, outcome->w);
% if "ratio" in ray_real:
    outcome->ratio = SEL_WEIGHT(m & WEIGHT_GT(after, weight_splat(0.0)), ratio, outcome->ratio);
% endif
}
