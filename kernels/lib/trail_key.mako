// Keys of paths: 64 bits that a sequence of faces and events is mixed into, step by step.
//
// Two sequences have one key with probability 2^-64 a pair: of 10^6 paths any two with 3e-8.
// photizon_cl/result/trails.py makes the same key from a sequence.

// A key behind one more step.
FN luint mixed_trail(luint trail, luint step) {
    luint h = (trail ^ step) * 0x9E3779B97F4A7C15UL + 0x632BE59BD9B4E019UL;
    h = (h ^ (h >> 32)) * 0xD6E8FEB86659FD93UL;
    h = (h ^ (h >> 29)) * 0xD6E8FEB86659FD93UL;
    return h ^ (h >> 32);
}

// A step: element, name of the face, event (event.mako).
#define TRAIL_STEP(element, name, event) (AS_LUINT(element) << 20 | AS_LUINT(name) << 4 | (event))
// The last step, at a detector, by its number; never 0.
#define TRAIL_END 15UL
FN luint path_key(luint trail, luint detector) {
    const luint h = mixed_trail(trail, detector << 20 | TRAIL_END);
    return h ? h : (luint)(1UL);
}
