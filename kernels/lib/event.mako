## surfaces (kinds in use: .splits), pairs (whether a surface may give two rays), passes, events (whether
## what happened is asked for), extras (rays that may go on beside two), densities (whether that of what scatters is),
## amplitudes (whether it is asked how light goes on that is polarised); strides; counts (band_degree); coats (whether
## there are coatings)
// What a surface is told of a ray that meets it, and what it answers.
//
// Every surface has one function, meet_<kind>(event, material, outcome).  It writes the outcome of the
// lanes in event->m and of no others.  An outcome begins as: nothing goes on, on the side that the ray
// came from.

typedef struct {
    mask m;                 // lanes that meet a surface of the kind
    const packet_t *p;      // the ray, with its weight before
    const contact_t *c;     // where it meets the face: point, normal, side
    ulong seed;             // of every draw
} encounter_t;

// What happens to a ray that goes on.
#define PASSED 0u
#define REFLECTED 1u
#define TRANSMITTED 2u
#define TOTALLY_REFLECTED 3u
#define SCATTERED 4u

// Rows of the material table: `only` for all lanes, where a kind has just one, else `row` of each.
<%
    degree, stride = counts.get("band_degree", 0), strides.material
%>
typedef struct {
    __global const double *table;
    lint row;
    long only;
% if degree:
    real along;   // place in the piece of the band: what a row has are the lowest coefficients
% endif
% if coats:
    const scene_t *scene;
    lint coating;       // of each lane twice where in codes its coating's head stands, negative of none, and
                        // 1 more where the element takes what does not go on
    lint coating_head;  // that place, and of lanes without a coating another's
% endif
} material_t;

FN real material_number(const material_t *material, int column) {
% if degree:
    real x = gather(material->table + column + ${degree * stride}, material->row);
% for k in range(degree - 1, -1, -1):
    x = fma(x, material->along, gather(material->table + column + ${k * stride}, material->row));
% endfor
    return ${point("event.number", "x")};
% endif
    if (material->only >= 0) return splat(material->table[material->only + column]);
    return gather(material->table + column, material->row);
}

// The same for what a weight is multiplied by: it must not be rounded to what lengths are.
FN weight weight_number(const material_t *material, int column) {
% if degree:
    weight x = gather_weight(material->table + column + ${degree * stride}, material->row);
% for k in range(degree - 1, -1, -1):
    x = fma(x, TO_WEIGHT(material->along), gather_weight(material->table + column + ${k * stride}, material->row));
% endfor
    return ${point("event.weight", "x")};
% endif
    if (material->only >= 0) return weight_splat(material->table[material->only + column]);
    return gather_weight(material->table + column, material->row);
}

% if extras:
// A ray that goes on beside those two: always a scattered one.  plus: whether on the + side; path: its place in
// the launched ray's tree.
typedef struct {
    mask m, plus;
    real dx, dy, dz;
    weight w;
    luint path;
% if "ratio" in ray_real:
    weight ratio;
% endif
} extra_t;

% endif
// dx, dy, dz, w: the ray that goes on in its lane, none where w is 0.  went_plus: whether on the + side.
// splits: lanes in which a second ray goes on, on the side that the ray came from, with direction second_d
// and weight second_w.  passes: lanes in which nothing happened: the ray goes on in its generation.
// event, second_event: what happened to each, where an effect asks.
typedef struct {
    real dx, dy, dz;
    weight w;
    mask went_plus;
% if pairs:
    mask splits;
    real second_dx, second_dy, second_dz;
    weight second_w;
% endif
% if extras:
    extra_t extra[${extras}];
% endif
% if passes:
    mask passes;
% endif
% if events:
    word event;
% if pairs:
    word second_event;
% endif
% endif
% if amplitudes:
    real stokes_q, stokes_u, stokes_v;   // of the ray's light, over its power: 0 where it is unpolarised
% if pairs:
    real second_stokes_q, second_stokes_u, second_stokes_v;
% endif
% endif
% if densities:
    mask drawn, drawn_second;   // lanes in which a ray has a direction that was drawn, and the second one has
    weight drawn_w;             // its weight, whichever direction it takes
% if "ratio" in ray_real:
    weight ratio;               // by how much that was multiplied for the direction
% endif
% endif
} outcome_t;

FN outcome_t no_outcome(const packet_t *p, const contact_t *c) {
    outcome_t o;
    o.dx = p->dx; o.dy = p->dy; o.dz = p->dz;
    o.w = weight_splat(0.0);
    o.went_plus = c->came_plus;
% if pairs:
    o.splits = NO_LANES;
    o.second_dx = p->dx; o.second_dy = p->dy; o.second_dz = p->dz;
    o.second_w = weight_splat(0.0);
% endif
% for k in range(extras):
    o.extra[${k}].m = NO_LANES; o.extra[${k}].plus = c->came_plus;
    o.extra[${k}].dx = p->dx; o.extra[${k}].dy = p->dy; o.extra[${k}].dz = p->dz;
    o.extra[${k}].w = weight_splat(0.0);
    o.extra[${k}].path = p->path;
% if "ratio" in ray_real:
    o.extra[${k}].ratio = weight_splat(1.0);
% endif
% endfor
% if passes:
    o.passes = NO_LANES;
% endif
% if events:
    o.event = wsplat(PASSED);
% if pairs:
    o.second_event = wsplat(PASSED);
% endif
% endif
% if amplitudes:
    o.stokes_q = splat(0.0); o.stokes_u = splat(0.0); o.stokes_v = splat(0.0);
% if pairs:
    o.second_stokes_q = splat(0.0); o.second_stokes_u = splat(0.0); o.second_stokes_v = splat(0.0);
% endif
% endif
% if densities:
    o.drawn = NO_LANES;
    o.drawn_second = NO_LANES;
    o.drawn_w = weight_splat(0.0);
% if "ratio" in ray_real:
    o.ratio = weight_splat(1.0);
% endif
% endif
    return o;
}

// The ray goes on with a direction and a weight, on the side that it came from.
FN void send_on(outcome_t *o, mask m, real dx, real dy, real dz, weight w, word event) {
    o->dx = SEL(m, dx, o->dx); o->dy = SEL(m, dy, o->dy); o->dz = SEL(m, dz, o->dz);
    o->w = SEL_WEIGHT(m, w, o->w);
% if events:
    o->event = SELW(m, event, o->event);
% endif
% if amplitudes:
    // unpolarised, unless the surface goes on to say how it is
    o->stokes_q = SEL(${point("event.unpolarised", "m")}, splat(0.0), o->stokes_q);
    o->stokes_u = SEL(m, splat(0.0), o->stokes_u); o->stokes_v = SEL(m, splat(0.0), o->stokes_v);
% endif
}
% if pairs:

// A second ray goes on beside it.
FN void send_second(outcome_t *o, mask m, real dx, real dy, real dz, weight w, word event) {
% if sum(s.splits for s in surfaces) == 1:
    // no other kind sends one: what lanes without one hold is not read
    o->second_dx = dx; o->second_dy = dy; o->second_dz = dz;
    o->second_w = w;
% else:
    o->second_dx = SEL(m, dx, o->second_dx); o->second_dy = SEL(m, dy, o->second_dy);
    o->second_dz = SEL(m, dz, o->second_dz);
    o->second_w = SEL_WEIGHT(m, w, o->second_w);
% endif
% if events:
    o->second_event = SELW(m, event, o->second_event);
% endif
    o->splits |= m;
}
% endif
% if densities:

// A ray's direction was drawn from the density that the surface's density_<kind> gives, and its weight would
// be w in any other direction too.  second: lanes of m in which that is the second ray.  A lane of m in
// which the draw led nowhere (no ray goes on, with a chance that the density leaves) belongs to m.
FN void scattered(outcome_t *o, mask m, mask second, weight w) {
    o->drawn |= m;
    o->drawn_second |= m & second;
    o->drawn_w = SEL_WEIGHT(m, w, o->drawn_w);
}
% endif
