## effects
// A ray starts within rounding on another face, `code`, whose normal there is n (lanes in m): is that
// face hit at distance zero?
// - A launched ray leaves every face it starts on.
% if "contact" in effects:
// - Else it is hit if the ray goes through to the other side of it than it is on.  That is the side it
//   is known to have been on where it last started, if it was within rounding of the face there too;
//   else the side that it came from on its last way of any length.
% endif
// - Where that says nothing (the edges of two faces), the sign of the distance decides.
% if "contact" in effects:
//
// What is found here is noted for the next search: seven faces in order, so that the order of the
// search does not matter, and in the lowest place, by `turn_page`, the face that the ray left.
#define SLOT_BITS 16
#define NO_SLOT 0xFFFFL
// Element and face in 15 bits, over whether it is on the + side.  The first 2048 elements have numbers
// of their own; the multiple keeps apart those that a scene made of rows of 2^n would bring together.
// NO_SLOT is none of them.
#define SLOT_KEY(x) (((x) & 0x7FFFL) - ((((x) & 0x7FFFL) + 1L) >> 15))
#define SLOT_OF(element, face) (SLOT_KEY((((element) + ((element) >> 11) * 1109L) << 4) + (face)) << 1)

// The lanes of m that are known to be on one side of a face; on_minus: whether that is the - side.
FN mask remembers(const packet_t *p, mask m, long code, mask *on_minus) {
    const long slot = SLOT_OF(ELEMENT_OF(code), FACE_OF(code));
    mask here = lsplat(0L);
    *on_minus = here;
    for (int k = 0; k < 64; k += SLOT_BITS) {
        const lint one = p->before >> k & NO_SLOT, other = p->earlier >> k & NO_SLOT;
        const mask minus = EQ(one, lsplat(slot)) | EQ(other, lsplat(slot));
        *on_minus |= minus;
        here |= minus | EQ(one, lsplat(slot | 1L)) | EQ(other, lsplat(slot | 1L));
    }
    return here & m;
}

// Puts a slot in its place among those of a word from bit `k` on; gives the one that has to go.
FN lint put_slot(lint *word, int k, lint slot) {
    for (; k < 64; k += SLOT_BITS) {
        const lint old = *word >> k & NO_SLOT;
        const mask first = LT(slot, old);
        *word ^= SEL(first, old ^ slot, lsplat(0L)) << k;
        // a face may be found more than once in a search
        slot = SEL(first, old, SEL(EQ(slot, old), lsplat(NO_SLOT), slot));
    }
    return slot;
}

FN void note(search_t *search, mask m, long code, mask on_minus) {
    const lint slot = SLOT_OF(ELEMENT_OF(code), FACE_OF(code)) | (~on_minus & 1L);
    put_slot(&search->noted_before, SLOT_BITS, put_slot(&search->noted, 0, SEL(m, slot, lsplat(NO_SLOT))));
}

// What was noted becomes what is remembered.
FN void turn_page(packet_t *p, const hit_t *h) {
    const lint slot = SLOT_OF(p->left >> 34, p->left >> 18 & 0xFFFFL) | (p->left >> 1 & 1L);
    p->before = (h->noted_before & ~NO_SLOT) | SEL(EQ(p->left, lsplat(NO_FACE)), lsplat(NO_SLOT), slot);
    p->earlier = h->noted;
}

// The lanes of m that are on the - side of a face, which is noted.  below: what the sign of the
// distance says; sure: it is large enough to be believed whatever else is known; vague: it may be
// rounding alone.  slack: how far along the normal the last segment must have come to be believed.
FN mask side_of(search_t *search, const packet_t *p, mask m, long code, mask sure, mask below, mask vague,
                real slack, real nx, real ny, real nz, real d_n) {
    const real came = dot3(p->came_x, p->came_y, p->came_z, nx, ny, nz);
    const mask given = NE(p->left, lsplat(NO_FACE))
        & EQ(fabs(p->came_x) + fabs(p->came_y) + fabs(p->came_z), splat(0.0));
    // a ray that came along the face, as one launched on it, is on the side it leaves it to
    const mask leaves = vague & ~given & NE(d_n, splat(0.0));
    mask is_minus = SEL(leaves, LT(d_n, splat(0.0)), below);
    is_minus = SEL(GT(fabs(came), slack), GT(came, splat(0.0)), is_minus);
    is_minus = SEL(sure, below, is_minus);
    mask was_minus;
    const mask known = remembers(p, m, code, &was_minus);
    is_minus = SEL(known, was_minus, is_minus);
    note(search, m, code, is_minus);
    return m & is_minus;
}
% endif

FN mask crosses(search_t *search, const packet_t *p, mask m, long code, real nx, real ny, real nz,
                real d_n, real h_d) {
    const mask hit = m & NE(p->left, lsplat(NO_FACE));
% if "contact" in effects:
    const mask goes_minus = LT(d_n, splat(0.0)), below = LE(h_d, splat(0.0)) ^ goes_minus;
    return hit & (side_of(search, p, m, code, lsplat(0L), below, lsplat(-1L), splat(0.0), nx, ny, nz, d_n) ^ goes_minus);
% else:
    return hit & LE(h_d, splat(0.0));
% endif
}
