// Exact tallies: a weight as three signed pieces, units 2^-31, 2^-63 and 2^-95.
//
// w = (p0 * 2^64 + p1 * 2^32 + p2) * 2^-95 for 0 <= w <= 4, the last piece rounded to nearest: a
// double of at least 2^-42 is represented without error.  Pieces are added to 64-bit integers, so
// a sum does not depend on the order of its terms.  Adding 1.5 * 2^52 leaves the nearest integer
// in the low bits; differences of two images need no subtraction of that constant.
#define LIMB_MAGIC 0x1.8p52
typedef struct { lint p0, p1, p2; } image_t;

FN image_t image_of(weight w) {
    image_t r;
    const wide s = TO_WIDE(w) * 0x1p31;
    const wide t0 = s + LIMB_MAGIC;
    const wide r1 = (s - (t0 - LIMB_MAGIC)) * 0x1p32;
    const wide t1 = r1 + LIMB_MAGIC;
    const wide r2 = (r1 - (t1 - LIMB_MAGIC)) * 0x1p32;
    const wide t2 = r2 + LIMB_MAGIC;
    const long zero = as_long(LIMB_MAGIC);
    r.p0 = AS_LINT(t0) - zero;
    r.p1 = ${careful("tally", "AS_LINT(t1) - zero", "lsplat(0L)")};
    r.p2 = ${careful("tally", "AS_LINT(t2) - zero", "lsplat(0L)")};
    return r;
}
FN image_t image_sum(image_t a, image_t b) {
    image_t r;
    r.p0 = a.p0 + b.p0;
    r.p1 = a.p1 + b.p1;
    r.p2 = a.p2 + b.p2;
    return r;
}
FN image_t image_difference(image_t a, image_t b) {
    image_t r;
    r.p0 = a.p0 - b.p0;
    r.p1 = a.p1 - b.p1;
    r.p2 = a.p2 - b.p2;
    return r;
}
