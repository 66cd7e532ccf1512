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
// What is found here is noted for the next search: ${64 // counts["note_bits"] * counts["note_words"] - 1} faces in order, so
// that the order of the search does not matter, and in the lowest place, by `turn_page`, the face that
// the ray left.
#define SLOT_BITS ${counts["note_bits"]}
#define NO_SLOT ${hex(2**counts["note_bits"] - 1)}L
// Element and face, over whether it is on the + side: 16 bits are enough for 2047 elements.  Of a
// tube's plates (faces from 4 on) those eight apart share a number.  NO_SLOT is none of them.
#define SLOT_FACE(face) SELI(ILT(face, lsplat(4L)), face, ((face) & 7L) + 4L)
#define SLOT_OF(element, face) ((((element) << 4) + SLOT_FACE(face)) << 1)

// The lanes of m that a list of notes knows to be on one side of a face; on_minus: whether that is the
// - side.
FN mask known_side(const notes_t *notes, mask m, lint code, mask *on_minus) {
    const lint slot = SLOT_OF(ELEMENT_OF(code), FACE_OF(code));
    mask here = NO_LANES;
    *on_minus = here;
    for (int k = 0; k < 64; k += SLOT_BITS) {
% for n in range(counts["note_words"]):
        {
            const lint one = notes->word${n} >> k & NO_SLOT;
            const mask minus = IEQ(one, slot);
            *on_minus |= minus;
            here |= minus | IEQ(one, slot | 1L);
        }
% endfor
    }
    return ${point("faces.known", "here & m")};
}

// Puts a slot in its place among those of a word from bit `k` on; gives the one that has to go.
FN lint put_slot(lint *word, int k, lint slot) {
    for (; k < 64; k += SLOT_BITS) {
        const lint old = *word >> k & NO_SLOT;
        const mask first = ILT(slot, old);
        *word ^= SELI(first, old ^ slot, lsplat(0L)) << k;
        // a face may be found more than once in a search
        slot = SELI(first, old, SELI(IEQ(slot, old), lsplat(NO_SLOT), slot));
    }
    return slot;
}

FN void note(search_t *search, mask m, long code, mask on_minus) {
    const lint slot = SLOT_OF(ELEMENT_OF(code), FACE_OF(code)) | (INT_MASK(~on_minus) & 1L);
    lint rest = SELI(m, slot, lsplat(NO_SLOT));
% for n in range(counts["note_words"]):
    rest = put_slot(&search->noted.word${n}, ${"SLOT_BITS" if n == counts["note_words"] - 1 else 0}, rest);
% endfor
}

// What was noted becomes what is remembered.
FN void turn_page(packet_t *p, const hit_t *h) {
    const lint slot = SLOT_OF(ELEMENT_OF(p->left >> 2), FACE_OF(p->left >> 2)) | (p->left >> 1 & 1L);
% for n in range(counts["note_words"] - 1):
    p->note${n} = ${point("faces.remembered", f"h->noted.word{n}")};
% endfor
<% last = counts["note_words"] - 1 %>
    p->note${last} = (${point("faces.remembered", f"h->noted.word{last}")} & ~NO_SLOT) | ${point("faces.departed", "SELI(IEQ(p->left, lsplat(NO_FACE)), lsplat(NO_SLOT), slot)")};
}

// The lanes of m that are on the - side of a face, which is noted.  below: what the sign of the
// distance says; sure: it is large enough to be believed whatever else is known; vague: it may be
// rounding alone.  slack: how far along the normal the last segment must have come to be believed.
FN mask side_of(search_t *search, const packet_t *p, mask m, long code, mask sure, mask below, mask vague,
                real slack, real nx, real ny, real nz, real d_n) {
    const real came = dot3(p->came_x, p->came_y, p->came_z, nx, ny, nz);
    const mask given = INE(p->left, lsplat(NO_FACE))
        & EQ(fabs(p->came_x) + fabs(p->came_y) + fabs(p->came_z), splat(0.0));
    // a ray that came along the face, as one launched on it, is on the side it leaves it to
    const mask leaves = vague & ~given & NE(d_n, splat(0.0));
    mask is_minus = SELM(leaves, LT(d_n, splat(0.0)), below);
    is_minus = SELM(GT(fabs(came), slack), GT(came, splat(0.0)), is_minus);
    is_minus = SELM(sure, below, is_minus);
    notes_t notes;
% for n in range(counts["note_words"]):
    notes.word${n} = p->note${n};
% endfor
    mask was_minus;
    const mask known = known_side(&notes, m, lsplat(code), &was_minus);
    is_minus = SELM(known, was_minus, is_minus);
    note(search, m, code, is_minus);
    return m & is_minus;
}

// The lanes of `beside` that start on a face, whatever their distance from it says: those within its
// rounding, and those that are known to be on the other side than their distance says.
// beside: within 64 times the rounding, so that a ray is either known to be on one side of the face
// or has come so far to it that its way there says on which.  on: within the rounding.  height: over
// the face, on the + side.  near: the rounding, the same all over the face.  minus: whether the ray is
// on the - side; crosses: whether it hits the face.
FN mask starts_on(search_t *search, const packet_t *p, mask beside, long code, mask on, real height, real near,
                  real nx, real ny, real nz, real d_n, mask *minus, mask *crosses) {
    const mask below = LT(height, splat(0.0)), goes_minus = LT(d_n, splat(0.0));
    const mask on_minus = side_of(search, p, beside, code, GT(fabs(height), R(16.0) * near), below, on, R(32.0) * near,
                                  nx, ny, nz, d_n);
    *minus = on_minus;
    *crosses = ${point("faces.launched_in_contact", "INE(p->left, lsplat(NO_FACE))")} & (on_minus ^ goes_minus);
    return beside & (on | (on_minus ^ below));
}
% else:

FN mask crosses(const packet_t *p, mask m, real h_d) {
    return m & ${point("faces.launched", "INE(p->left, lsplat(NO_FACE))")} & LE(h_d, splat(0.0));
}
% endif
