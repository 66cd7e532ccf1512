// Cells by key: a hash table of a batch, open addressing with linear probing (hostcode/run/keyed.py).
//
// An entry: key, never 0; cell (3 limbs and a count); 2^62 less the number of the first ray that came
// there; what is known of the key.  In front of all tables a head, whose first integer counts what
// found no place: the host then traces the batch again with a larger table.
// reads and writes: the table, with atomics whatever private_tallies says; one table for all work-items.
#define KEYED_ENTRY 8
#define KEYED_CELL 1
#define KEYED_FIRST 5
#define KEYED_ABOUT 6
#define KEYED_PROBES 128

FN void count_keyed(__global long *head, ulong slot, ulong capacity, ulong key, ulong about, ulong ray, double w) {
    const long mine = (long)key;
    __global long *table = head + KEYED_ENTRY * (1 + slot * capacity);
    const ulong probes = min(capacity, (ulong)KEYED_PROBES);
    for (ulong probe = 0; probe < probes; probe++) {
        // the low bits choose the place: a key is mixed well
        __global long *entry = table + KEYED_ENTRY * ((key + probe) & (capacity - 1));
        long found = *(volatile __global long *)entry;
        if (!found) found = atom_cmpxchg(entry, 0L, mine);
        if (found && found != mine) continue;
        entry[KEYED_ABOUT] = (long)about;  // all who come here write the same
        const double s = ${point("keyed.weight", "w")} * 0x1p31;
        const double t0 = s + LIMB_MAGIC;
        const double r1 = (s - (t0 - LIMB_MAGIC)) * 0x1p32;
        const double t1 = r1 + LIMB_MAGIC;
        const double t2 = (r1 - (t1 - LIMB_MAGIC)) * 0x1p32 + LIMB_MAGIC;
        const long zero = as_long(LIMB_MAGIC);
        const long p0 = as_long(t0) - zero, p1 = as_long(t1) - zero, p2 = as_long(t2) - zero;
        if (p0) atom_add(entry + KEYED_CELL, p0);
        if (p1) atom_add(entry + KEYED_CELL + 1, p1);
        if (p2) atom_add(entry + KEYED_CELL + 2, p2);
        atom_add(entry + KEYED_CELL + 3, 1L);
        // the lowest ray: what is read may be old, and is then lower than what stands there
        const long early = (1L << 62) - (long)ray;
        long seen = *(volatile __global long *)(entry + KEYED_FIRST);
        while (${point("keyed.first", "seen < early")}) {
            const long was = atom_cmpxchg(entry + KEYED_FIRST, seen, early);
            if (was == seen) break;
            seen = was;
        }
        return;
    }
    atom_add(head, 1L);
}
