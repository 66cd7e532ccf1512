## queue_real, queue_word, queue_long: the ray fields the queue stores, by type; interleaved
// The queue of waiting rays: a stack for each work-item (its segment), fields as structure of
// arrays.  No atomics: a segment has one owner.  reads and writes: queue buffers, item->stack.
typedef struct {
    __global double *reals;
    __global uint *words;
    __global long *longs;
    ulong items, capacity, item;
} queue_t;
<%
    place = "(i * (long)q->items + (long)q->item)" if interleaved else "((long)(q->item * q->capacity) + i)"
    field = "(long)(q->items * q->capacity)"
%>
FN lint queue_place(const queue_t *q, lint i) {
    return ${place};
}

// Rays at stack positions i into the lanes set in m.
FN void take_rays(const queue_t *q, lint i, mask m, packet_t *p) {
    const lint at = queue_place(q, SEL(m, i, lsplat(0L)));
    const long field = ${field};
% for n, name in enumerate(queue_real):
    p->${name} = SEL(m, gather(q->reals + ${n} * field, at), p->${name});
% endfor
% for n, name in enumerate(queue_word):
    p->${name} = SELW(m, gather_word(q->words + ${n} * field, at), p->${name});
% endfor
% for n, name in enumerate(queue_long):
    p->${name} = SEL(m, ${"AS_LUINT" if name == "path" else ""}(gather_long(q->longs + ${n} * field, at)), p->${name});
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
% for n, name in enumerate(queue_real):
        q->reals[${n} * field + k] = p->${name};
% endfor
% for n, name in enumerate(queue_word):
        q->words[${n} * field + k] = p->${name};
% endfor
% for n, name in enumerate(queue_long):
        q->longs[${n} * field + k] = (long)p->${name};
% endfor
    }
% else:
    // through memory: a lane is then a load
    union { lint v; long s[LANES]; } place = {at};
% for name in queue_real:
    union { real v; double s[LANES]; } ${name} = {p->${name}};
% endfor
% for name in queue_word:
    union { word v; uint s[LANES]; } ${name} = {p->${name}};
% endfor
% for name in queue_long:
    union { lint v; long s[LANES]; } ${name} = {AS_LINT(p->${name})};
% endfor
    for (uint bits = lane_bits(m); bits; bits &= bits - 1u) {
        const uint l = FIRST_LANE(bits);
        const long k = place.s[l];
% for n, name in enumerate(queue_real):
        q->reals[${n} * field + k] = ${name}.s[l];
% endfor
% for n, name in enumerate(queue_word):
        q->words[${n} * field + k] = ${name}.s[l];
% endfor
% for n, name in enumerate(queue_long):
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

% if records:
// Endings that a detector or the far field counts, for the tally stage.
typedef struct {
    __global double *reals;
    __global uint *words;
    ulong capacity, item;
} records_t;

FN void put_records(const records_t *r, ulong *n_records, const ending_t *end) {
    ulong k = r->item * r->capacity + *n_records;
    const ulong first = k;
% if lanes == 1:
    if (end->m) {
        r->reals[4 * k] = end->w;
        r->reals[4 * k + 1] = end->x;
        r->reals[4 * k + 2] = end->y;
        r->reals[4 * k + 3] = end->z;
        r->words[2 * k] = (uint)end->tag;
        r->words[2 * k + 1] = end->generation;
        k++;
    }
% else:
    if (!ANY(end->m)) return;
% for name in "wxyz":
    union { real v; double s[LANES]; } ${name} = {end->${name}};
% endfor
    union { lint v; long s[LANES]; } tag = {end->tag};
    union { word v; uint s[LANES]; } generation = {end->generation};
    for (uint bits = lane_bits(end->m); bits; bits &= bits - 1u) {
        const uint l = FIRST_LANE(bits);
        r->reals[4 * k] = w.s[l];
        r->reals[4 * k + 1] = x.s[l];
        r->reals[4 * k + 2] = y.s[l];
        r->reals[4 * k + 3] = z.s[l];
        r->words[2 * k] = (uint)tag.s[l];
        r->words[2 * k + 1] = generation.s[l];
        k++;
    }
% endif
    *n_records += k - first;
}
% endif
