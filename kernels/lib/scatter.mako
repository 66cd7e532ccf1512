## counts (SCATTER_ …: places in a lobe's head; places in models' rows), densities
// Lobes: what a surface scatters about a direction, by a BSDF of Delta = |beta - beta_0|, the distance of
// the two directions' projections on the tangent plane.
//
// The share that is scattered is TIS = the integral of the BSDF over the disc |beta| <= 1; the direction has
// the density BSDF cos(theta) / TIS per steradian.  beta is tried from a law without the horizon until one is
// above it: each is the density, cut off, so that all that are taken have exactly that.  At least an eighth of
// what is tried is taken (one in fifty of a table that grows); after SCATTER_TRIES, of which there is a chance
// below 10^-35, a ray goes on in the direction that the lobe is about.
#define SCATTER_TRIES 4096u
#define SCATTER_TERMS 8
% for name, place in counts.items():
% if name.isupper() and not name.startswith("TARGET_"):
#define ${name} ${place}
% endif
% endfor

// m: lanes that scatter; head: where in `codes` it stands where in `table` each lane's lobe has what (integers,
// which a float need not hold); row: where the numbers of its model stand; model: the number of that;
// a, b: beta_0 along the face; n: the normal on the side on which the ray goes on; middle: |beta_0|; depth: what
// that leaves of 1.
typedef struct {
    mask m;
    __global const double *table;
    __global const long *codes;
    lint head, row, model;
    real a, b, middle, depth, nx, ny, nz, tis;
} lobe_t;

FN real lobe_number(const lobe_t *s, int column) { return gather(s->table + column, s->row); }
FN lint lobe_place(const lobe_t *s, int column) { return gather_long(s->codes + column, s->head); }

// Two components of a vector along the face: those that about_normal puts together.
FN void along_face(real nx, real ny, real nz, real x, real y, real z, real *a, real *b) {
    const real sign = SEL(GE(nz, splat(0.0)), splat(1.0), splat(-1.0));
    const real k = R(-1.0) / (sign + nz);
    const real m = nx * ny * k;
    *a = dot3(x, y, z, fma(sign * nx, nx * k, splat(1.0)), sign * m, -sign * nx);
    *b = dot3(x, y, z, m, fma(ny, ny * k, sign), -ny);
}

// Where in an ascending list of n numbers, `stride` apart from `first` on, the last one is that is not above x.
FN lint place_in(__global const double *table, lint first, lint n, long stride, ulong steps, real x) {
    lint at = lsplat(0L);
    for (long step = (long)steps; step > 0; step >>= 1) {
        const lint next = at + step;
        const mask there = ILT(next, n);
        const mask up = there & LE(gather(table, first + SELI(there, next, at) * stride), x);
        at = SELI(up, next, at);
    }
    return at;
}

// TIS by the depth 1 - |beta_0| of the disc's rim: polynomials in pieces (photizon_cl/scene/scatters/total.py).
FN real lobe_total(const lobe_t *s, ulong steps) {
    const lint n = lobe_place(s, SCATTER_PIECES), edges = lobe_place(s, SCATTER_EDGES);
    const lint at = place_in(s->table, edges, n, 1L, steps, s->depth);
    const real low = gather(s->table, edges + at);
    const lint terms = lobe_place(s, SCATTER_TERM_PLACE) + at * (SCATTER_TERMS + 1L);
    const real x = clamp(fma(s->depth - low, gather(s->table, terms), splat(-1.0)), splat(-1.0), splat(1.0));
    real total = gather(s->table + SCATTER_TERMS, terms);
    for (int k = SCATTER_TERMS - 1; k > 0; k--) total = fma(total, x, gather(s->table + k, terms));
    return ${point("scatter.total", "clamp(total, splat(0.0), splat(1.0))")};
}

// The lobe of lanes in m about a direction, on the side of the face on which that goes.
FN lobe_t lobe_about(const scene_t *scene, ulong steps, ulong some_head, mask m, lint where, const contact_t *c, mask plus,
                     real x, real y, real z) {
    lobe_t s;
    s.m = m;
    s.table = scene->geometry;
    s.codes = scene->codes;
    // lanes that scatter nothing read of one that does
    s.head = SELI(m, where >> 1, lsplat((long)some_head));
    s.row = lobe_place(&s, SCATTER_ROW);
    s.model = lobe_place(&s, SCATTER_MODEL);
    const real side = SEL(plus, splat(1.0), splat(-1.0));
    s.nx = side * c->nx; s.ny = side * c->ny; s.nz = side * c->nz;
    along_face(s.nx, s.ny, s.nz, x, y, z, &s.a, &s.b);
    s.middle = fmin(sqrt(fma(s.a, s.a, s.b * s.b)), splat(1.0));
    // 1 - |beta_0|, small towards grazing incidence
    const real cosine = fmin(fabs(dot3(x, y, z, s.nx, s.ny, s.nz)), splat(1.0));
    s.depth = cosine * cosine / (R(1.0) + s.middle);
    s.tis = lobe_total(&s, steps);
    return s;
}

// Numbers for as many tries as it takes: the first block is that of a decision, each further one the cipher
// of the block before (output feedback): two draws of a run have one counter with a chance of 2^-128 a pair.
typedef struct { word c0, c1, c2, c3; } draws_t;

FN void next_draws(ulong seed, mask m, draws_t *d) {
    draws_t e = *d;
    philox4x32_10(&e.c0, &e.c1, &e.c2, &e.c3, (uint)seed, (uint)(seed >> 32));
    d->c0 = SELW(m, e.c0, d->c0); d->c1 = SELW(m, e.c1, d->c1);
    d->c2 = SELW(m, e.c2, d->c2); d->c3 = SELW(m, e.c3, d->c3);
}

FN draws_t first_draws(ulong seed, const packet_t *p, luint path, uint decision) {
    draws_t d = {p->ray_lo, p->ray_hi | (decision << 16) | (TO_WORD(path >> 44) << 20), TO_WORD(path),
                 p->generation | (TO_WORD(path >> 32) << 20)};
    next_draws(seed, ALL_LANES, &d);
    return d;
}

// How far from beta_0 there is anything of the disc.
FN real lobe_reach(const lobe_t *s) { return R(1.0) + s->middle; }

// A place at a distance from beta_0, in any direction: v in [0, 1).
FN void place_about(const lobe_t *s, real r, real v, real *x, real *y) {
    real si, co;
    sincos_turns(v, &si, &co);
    *x = fma(r, co, s->a);
    *y = fma(r, si, s->b);
}

// t in [1, top] with the density t^(p - 1), and the integral of that: (t^p - 1)/p.
// Where p log t is small, 1 and t^p are nearly equal, and series in that take their place; their terms
// fall by 1/16 each.
typedef struct { real p, log_top, whole; mask small; } power_law_t;
FN power_law_t power_law(real p, real top) {
    power_law_t law;
    law.p = p;
    law.log_top = natural_log(top);
    const real y = p * law.log_top;
    law.small = LT(fabs(y), splat(0.0625));
    real series = splat(1.0);
% for k in range(12, 1, -1):
    series = fma(y * R(1.0 / ${k}.0), series, splat(1.0));
% endfor
    law.whole = SEL(law.small, law.log_top * series, (exponential(y) - R(1.0)) / SEL(law.small, splat(1.0), p));
    return law;
}
FN real drawn_from(const power_law_t *law, real top, real u) {
    const real part = u * law->whole, y = law->p * part;
    real series = splat(0.0);
% for k in range(14, 0, -1):
    series = fma(-y, series, splat(1.0 / ${k}.0));
% endfor
    const real few = exponential(part * series);
    const real many = power(fmax(R(1.0) + y, splat(0.0)), R(1.0) / SEL(law->small, splat(1.0), law->p));
    return clamp(SEL(law->small, few, many), splat(1.0), top);
}
