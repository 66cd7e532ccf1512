## counts (scatter.<kernel>: number of a model), effects, extras (rays that it sends besides), pairs, densities, coats
<%
    models = sorted((n, name.removeprefix("scatter.")) for name, n in counts.items() if name.startswith("scatter."))
%>
// Scatter: of what a surface sends on, a share TIS goes aside, about the direction in which it was sent; where
// nothing is sent on, about that of a mirror.
//
// The share is one of the weight that arrives where the surface says how much leaves in all, and one of each
// child's weight at a border of two media (`relative`).  Where rays go on as two the scattered ray goes on
// beside the other, else one of both, with the weight of both and the chance of each.
// reads: outcome (both children), codes (which lobe a face has), draws DECIDE_SCATTER and, of one of two,
// DECIDE_ASIDE.
// writes: outcome; the ledger, what the parts are rounded by, and what does not end here after all.
#define DECIDE_ASIDE 6u
#define ASIDE ${1 + extras}

FN mask try_lobe(const lobe_t *s, ulong seed, mask m, draws_t *draws, real u, real v, real *x, real *y) {
    mask taken = NO_LANES;
% for number, model in models:
    {
        const mask mine = m & IEQ(s->model, lsplat(${number}L));
        real px = splat(0.0), py = splat(0.0);
        if (ANY(mine)) {
            taken |= try_${model}(s, seed, mine, draws, u, v, &px, &py);
            *x = SEL(mine, px, *x); *y = SEL(mine, py, *y);
        }
    }
% endfor
    return taken & LT(fma(*x, *x, *y * *y), ${point("scatter.horizon", "splat(1.0)")});
}

// A direction drawn from a lobe.
FN void draw_lobe(ulong seed, const packet_t *p, luint path, const lobe_t *s, real *x, real *y, real *z) {
    draws_t draws = first_draws(seed, p, path, DECIDE_SCATTER);
    real a = s->a, b = s->b;
    mask left = s->m;
    for (uint k = 0; k < SCATTER_TRIES; k++) {
        const real u = u01_closed_open(draws.c0, draws.c1), v = u01_closed_open(draws.c2, draws.c3);
        real px = splat(0.0), py = splat(0.0);
        const mask taken = left & try_lobe(s, seed, left, &draws, u, v, &px, &py);
        a = SEL(taken, px, a); b = SEL(taken, py, b);
        left &= ~taken;
        if (!ANY(left)) break;
        next_draws(seed, left, &draws);
    }
    const real up = sqrt(fmax(fma(-a, a, fma(-b, b, splat(1.0))), splat(0.0)));
    about_normal(s->nx, s->ny, s->nz, a, b, up, x, y, z);
    renormalise(x, y, z);
}
% if densities:

// The density of that per steradian; 0 into the surface.
FN real density_lobe(const lobe_t *s, real x, real y, real z) {
    real a, b, bsdf = splat(0.0);
    along_face(s->nx, s->ny, s->nz, x, y, z, &a, &b);
    a -= s->a; b -= s->b;
    const real square = fma(a, a, b * b);
% for number, model in models:
    {
        const mask mine = s->m & IEQ(s->model, lsplat(${number}L));
        if (ANY(mine)) bsdf = SEL(mine, bsdf_${model}(s, square), bsdf);
    }
% endfor
    const real up = fmax(dot3(x, y, z, s->nx, s->ny, s->nz), splat(0.0));
    return SEL(GT(s->tis, splat(0.0)), ${point("scatter.density", "bsdf * up / s->tis")}, splat(0.0));
}
% endif

// The scattered ray, of weight w; where rays are sent towards targets w is what it weighs then, and ratio that
// over what it was.
FN void send_aside(const launch_t *launch, const scene_t *scene, const packet_t *p, const contact_t *c,
                   ledger_t *ledger, luint path, const lobe_t *s, weight *w, weight *ratio, real *x, real *y, real *z) {
    draw_lobe(launch->seed, p, path, s, x, y, z);
    *ratio = weight_splat(1.0);
% if densities:
    const aim_t aim = aim_ray(launch, scene, p, c, path, s->m, *w, s->nx, s->ny, s->nz, x, y, z);
    if (ANY(aim.m)) {
        const real by_lobe = density_lobe(s, *x, *y, *z);
        *w = weigh_aimed(launch, ledger, &aim, by_lobe, *w, *w, ratio);
    }
% endif
}

FN void scatter(const launch_t *launch, const scene_t *scene, const packet_t *p, const hit_t *h, const contact_t *c,
                ledger_t *ledger, lint element, mask found, mask takes, outcome_t *outcome) {
    const lint place = SELI(found, ${"material_of_face(h->code)" if "face-surfaces" in effects else "element"}, lsplat(0L));
    const lint where = gather_long(scene->codes + launch->scatter, place);
    const mask m = found & IGE(where, lsplat(0L));
    if (!ANY(m)) return;
    const ulong steps = launch->scatter_steps;
    const mask relative = m & INE(where & 1L, lsplat(0L)), sends = m & WEIGHT_GT(outcome->w, weight_splat(0.0));
    real mx, my, mz;
    reflect(p, c, &mx, &my, &mz);
    const lobe_t lobe = lobe_about(scene, steps, launch->scatter_heads, m, where, c, outcome->went_plus, SEL(sends, outcome->dx, mx),
                                   SEL(sends, outcome->dy, my), SEL(sends, outcome->dz, mz));
% if coats:
    // of a child that a coating does not let be there nothing is scattered
    const weight whole = SEL_WEIGHT(sends, outcome->w, SEL_WEIGHT(relative, weight_splat(0.0), p->w));
% else:
    const weight whole = SEL_WEIGHT(sends, outcome->w, p->w);
% endif
    const weight aside = fmin(SEL_WEIGHT(relative, whole, p->w) * TO_WEIGHT(${point("scatter.share", "lobe.tis")}), whole);
    const mask some = m & WEIGHT_GT(aside, weight_splat(0.0));
    // what is scattered: the only ray that goes on${", one beside the first" if extras else ""}${", one beside the second" if extras > 1 else ""}
    lobe_t lobes[ASIDE];
    weight w[ASIDE], ratio[ASIDE];
    luint path[ASIDE];
    real x[ASIDE], y[ASIDE], z[ASIDE];
    lobes[0] = lobe;
    lobes[0].m = some & ~sends;
    path[0] = path_of(p);
% if extras:
    const mask beside = some & sends;
    lobes[1] = lobe;
    lobes[1].m = beside;
    w[1] = aside;
    path[1] = child_path(SELI(outcome->splits, child_path(p->path, 0u), p->path), 1u);
% else:
    real u, v;
    draw_pair(launch->seed, p->ray_lo, p->ray_hi, path_of(p), p->generation, DECIDE_ASIDE, &u, &v);
    lobes[0].m |= some & sends & ${point("scatter.chance", "WEIGHT_LT(TO_WEIGHT(u) * whole, aside)")};
% endif
    w[0] = SEL_WEIGHT(sends, whole, aside);
    const weight goes = w[0];
% if extras > 1:
    lobes[2] = lobe_about(scene, steps, launch->scatter_heads, relative & outcome->splits, where, c, c->came_plus, outcome->second_dx,
                          outcome->second_dy, outcome->second_dz);
    w[2] = outcome->second_w * TO_WEIGHT(lobes[2].tis);
    const weight of_second = w[2];
    lobes[2].m &= WEIGHT_GT(of_second, weight_splat(0.0));
    path[2] = child_path(child_path(p->path, 1u), 1u);
% endif
    for (int k = 0; k < ASIDE; k++) {
        x[k] = p->dx; y[k] = p->dy; z[k] = p->dz;
        ratio[k] = weight_splat(1.0);
        if (ANY(lobes[k].m)) send_aside(launch, scene, p, c, ledger, path[k], lobes + k, w + k, ratio + k, x + k, y + k, z + k);
    }
    const mask only = lobes[0].m;
    if (ANY(only)) {
        // what does not end here after all
        const image_t none = image_of(weight_splat(0.0));
        book(ledger, element, only & ~sends & takes, image_difference(none, ${point("scatter.booked", "image_of(goes)")}));
        send_on(outcome, only, x[0], y[0], z[0], w[0], wsplat(SCATTERED));
% if "ratio" in ray_real:
        outcome->ratio = SEL_WEIGHT(only, ratio[0], outcome->ratio);
% endif
    }
% if extras:
    if (ANY(beside)) {
        const weight stays = whole - aside;
        // to the last bit: what both weigh may be another number than what is divided
        const image_t both = image_sum(image_of(stays), image_of(aside));
        book(ledger, element, beside & takes, image_difference(image_of(whole), both));
        outcome->w = SEL_WEIGHT(beside, ${point("scatter.stays", "stays")}, outcome->w);
    }
% endif
% if extras > 1:
    outcome->second_w = SEL_WEIGHT(lobes[2].m, outcome->second_w - of_second, outcome->second_w);
% endif
% for k in range(extras):
    {
        extra_t *extra = outcome->extra + ${k};
        extra->m = lobes[${k + 1}].m;
        extra->plus = ${"outcome->went_plus" if k == 0 else "c->came_plus"};
        extra->dx = x[${k + 1}]; extra->dy = y[${k + 1}]; extra->dz = z[${k + 1}];
        extra->w = w[${k + 1}];
        extra->path = path[${k + 1}];
% if "ratio" in ray_real:
        extra->ratio = ratio[${k + 1}];
% endif
    }
% endfor
}
