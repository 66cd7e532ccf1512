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
% for l in range(lanes):
    if (${lane("m", l)}) {
        const long k = ${lane("at", l)};
% for n, name in enumerate(queue_real):
        q->reals[${n} * field + k] = ${lane("p->" + name, l)};
% endfor
% for n, name in enumerate(queue_word):
        q->words[${n} * field + k] = ${lane("p->" + name, l)};
% endfor
% for n, name in enumerate(queue_long):
        q->longs[${n} * field + k] = (long)${lane("p->" + name, l)};
% endfor
    }
% endfor
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
    if (!ANY(end->m)) return;
    uint n;
    const lint rank = rank_lanes(end->m, &n);
    const long base = (long)(r->item * r->capacity) + (long)*n_records;
% for l in range(lanes):
    if (${lane("end->m", l)}) {
        const long k = base + ${lane("rank", l)};
        r->reals[4 * k] = ${lane("end->w", l)};
        r->reals[4 * k + 1] = ${lane("end->x", l)};
        r->reals[4 * k + 2] = ${lane("end->y", l)};
        r->reals[4 * k + 3] = ${lane("end->z", l)};
        r->words[2 * k] = (uint)${lane("end->tag", l)};
        r->words[2 * k + 1] = ${lane("end->generation", l)};
    }
% endfor
    *n_records += n;
}
% endif
