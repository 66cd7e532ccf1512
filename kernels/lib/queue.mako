## ray_fields, ray_real, ray_word, ray_long: what a ray carries, by type, weights among the reals;
## ending_fields, ending_real, ending_word;
## records, interleaved
// The queue of waiting rays: a stack for each work-item (its segment), fields as structure of
// arrays.  No atomics: a segment has one owner.  reads and writes: queue buffers, item->stack.
typedef struct {
    __global double *reals;
    __global uint *words;
    __global long *longs;
    ulong items, capacity, item;
} queue_t;
FN queue_t open_queue(const launch_t *launch, __global double *reals, __global uint *words,
                      __global long *longs, ulong me) {
    const queue_t q = {reals, words, longs, launch->items, launch->stack_capacity, me};
    return q;
}
<%
    place = "(i * (long)q->items + (long)q->item)" if interleaved else "((long)(q->item * q->capacity) + i)"
    field = "(long)(q->items * q->capacity)"
    unsigned = {f.name for f in ray_fields if f.type == "ulong"}
    weights = {f.name for f in ray_fields if f.type == "weight"}
%>
FN lint queue_place(const queue_t *q, lint i) {
    return ${place};
}

// Rays at stack positions i into the lanes set in m.
FN void take_rays(const queue_t *q, lint i, mask m, packet_t *p) {
    const lint at = queue_place(q, SELI(m, i, lsplat(0L)));
    const long field = ${field};
% for n, name in enumerate(ray_real):
    p->${name} = ${"SEL_WEIGHT(m, gather_weight" if name in weights else "SEL(m, gather"}(q->reals + ${n} * field, at), p->${name});
% endfor
% for n, name in enumerate(ray_word):
    p->${name} = SELW(m, gather_word(q->words + ${n} * field, at), p->${name});
% endfor
% for n, name in enumerate(ray_long):
    p->${name} = SELI(m, ${"AS_LUINT" if name in unsigned else ""}(gather_long(q->longs + ${n} * field, at)), p->${name});
% endfor
    p->alive |= m;
}

// The rays in the lanes set in m to stack positions i.
FN void put_rays(const queue_t *q, lint i, mask m, const packet_t *p) {
    const lint at = queue_place(q, i);
    const long field = ${field};
% if lanes == 1:
    if (m) {
        const long k = at;
% for n, name in enumerate(ray_real):
        q->reals[${n} * field + k] = p->${name};
% endfor
% for n, name in enumerate(ray_word):
        q->words[${n} * field + k] = p->${name};
% endfor
% for n, name in enumerate(ray_long):
        q->longs[${n} * field + k] = (long)p->${name};
% endfor
    }
% else:
    // through memory: a lane is then a load
    union { lint v; long s[LANES]; } place = {at};
% for name in ray_real:
    union { ${"weight" if name in weights else "real"} v; ${"weight_scalar" if name in weights else "scalar"} s[LANES]; } ${name} = {p->${name}};
% endfor
% for name in ray_word:
    union { word v; uint s[LANES]; } ${name} = {p->${name}};
% endfor
% for name in ray_long:
    union { lint v; long s[LANES]; } ${name} = {AS_LINT(p->${name})};
% endfor
    for (uint bits = lane_bits(m); bits; bits &= bits - 1u) {
        const uint l = FIRST_LANE(bits);
        const long k = place.s[l];
% for n, name in enumerate(ray_real):
        q->reals[${n} * field + k] = ${name}.s[l];
% endfor
% for n, name in enumerate(ray_word):
        q->words[${n} * field + k] = ${name}.s[l];
% endfor
% for n, name in enumerate(ray_long):
        q->longs[${n} * field + k] = ${name}.s[l];
% endfor
    }
% endif
}

// Pushes the rays in the lanes set in m.
FN void push_rays(const queue_t *q, ulong *stack, mask m, const packet_t *p) {
    uint n;
    const lint rank = rank_lanes(m, &n);
    if (n) put_rays(q, rank + (long)*stack, m, p);
    *stack += n;
}

// Endings that a detector or the far field counts, for the tally stage.
typedef struct {
    __global double *reals;
    __global uint *words;
    ulong capacity, item;
} records_t;
FN records_t open_records(const launch_t *launch, __global double *reals, __global uint *words,
                          ulong me) {
    const records_t r = {reals, words, launch->record_capacity, me};
    return r;
}
% if records:

FN void put_records(const records_t *r, ulong *n_records, const ending_t *end) {
    ulong k = r->item * r->capacity + *n_records;
    const ulong first = k;
<% reals, words = len(ending_real), len(ending_word) %>
% if lanes == 1:
    if (end->m) {
% for n, name in enumerate(ending_real):
        r->reals[${reals} * k + ${n}] = end->${name};
% endfor
% for n, name in enumerate(ending_word):
        r->words[${words} * k + ${n}] = end->${name};
% endfor
        k++;
    }
% else:
    if (!ANY(end->m)) return;
<% weights = {f.name for f in ending_fields if f.type == "weight"} %>
% for name in ending_real:
    union { ${"weight" if name in weights else "real"} v; ${"weight_scalar" if name in weights else "scalar"} s[LANES]; } ${name} = {end->${name}};
% endfor
% for name in ending_word:
    union { word v; uint s[LANES]; } ${name} = {end->${name}};
% endfor
    for (uint bits = lane_bits(end->m); bits; bits &= bits - 1u) {
        const uint l = FIRST_LANE(bits);
% for n, name in enumerate(ending_real):
        r->reals[${reals} * k + ${n}] = ${name}.s[l];
% endfor
% for n, name in enumerate(ending_word):
        r->words[${words} * k + ${n}] = ${name}.s[l];
% endfor
        k++;
    }
% endif
    *n_records += k - first;
}
% endif
