// Cells by key: a hash table of a batch, open addressing with linear probing (hostcode/run/keyed.py).
//
// An entry: key, never 0; cell (3 limbs and a count); 2^62 less the number of the first ray that came
// there; what is known of the key.  In front of all tables a head, whose first integer counts what
// found no place: the host then traces the batch again with a larger table.
// reads and writes: the table, one for all work-items, with atomics alone whatever private_tallies says;
// but what is known of a key is written by the work-item that gave the entry its key, and by no other.
// A key stays where it is, and sums and the lowest ray depend on no order.
#define KEYED_ENTRY 8
#define KEYED_CELL 1
#define KEYED_FIRST 5
#define KEYED_ABOUT 6
#define KEYED_PROBES 128

// A work-item's way to the table, and what it has counted of one key and not yet added: most scenes send
// one path many times in a row, and every atomic operation waits for the entry.
typedef struct {
    __global long *head;
    ulong slot, capacity;
    ulong key, about;  // key 0: nothing is held
    long p0, p1, p2, count, early;
} keyed_t;

FN void open_keyed(keyed_t *keyed, __global long *head, ulong slot, ulong capacity) {
    keyed->head = head; keyed->slot = slot; keyed->capacity = capacity;
    keyed->key = 0;
}

// Adds what is held to the table.
FN void settle_keyed(const keyed_t *keyed) {
    if (!keyed->key) return;
    const long mine = (long)keyed->key, early = keyed->early;
    __global long *table = keyed->head + KEYED_ENTRY * (1 + keyed->slot * keyed->capacity);
    const ulong probes = min(keyed->capacity, (ulong)KEYED_PROBES);
    for (ulong probe = 0; probe < probes; probe++) {
        // the low bits choose the place: a key is mixed well
        __global long *entry = table + KEYED_ENTRY * ((keyed->key + probe) & (keyed->capacity - 1));
        const long found = atom_cmpxchg(entry, 0L, mine);
        if (found && found != mine) continue;
        if (!found) entry[KEYED_ABOUT] = (long)keyed->about;
        if (keyed->p0) atom_add(entry + KEYED_CELL, keyed->p0);
        if (keyed->p1) atom_add(entry + KEYED_CELL + 1, keyed->p1);
        if (keyed->p2) atom_add(entry + KEYED_CELL + 2, keyed->p2);
        atom_add(entry + KEYED_CELL + 3, keyed->count);
        // the first turn finds out what stands there, unless nothing does
        long seen = 0;
        while (${point("keyed.first", "seen < early")}) {
            const long was = atom_cmpxchg(entry + KEYED_FIRST, seen, early);
            if (was == seen) break;
            seen = was;
        }
        return;
    }
    atom_add(keyed->head, 1L);
}

FN void count_keyed(keyed_t *keyed, ulong key, ulong about, ulong ray, double w) {
    if (${point("keyed.other", "key != keyed->key")}) {
        settle_keyed(keyed);
        keyed->key = key; keyed->about = about;
        keyed->p0 = keyed->p1 = keyed->p2 = keyed->count = keyed->early = 0;
    }
    const double s = ${point("keyed.weight", "w")} * 0x1p31;
    const double t0 = s + LIMB_MAGIC;
    const double r1 = (s - (t0 - LIMB_MAGIC)) * 0x1p32;
    const double t1 = r1 + LIMB_MAGIC;
    const double t2 = (r1 - (t1 - LIMB_MAGIC)) * 0x1p32 + LIMB_MAGIC;
    const long zero = as_long(LIMB_MAGIC);
    keyed->p0 += as_long(t0) - zero; keyed->p1 += as_long(t1) - zero; keyed->p2 += as_long(t2) - zero;
    keyed->count++;
    const long early = (1L << 62) - (long)ray;
    keyed->early = ${point("keyed.earliest", "max(keyed->early, early)")};
}
