## private_tallies
// The same for one number, for the stage that bins records one at a time.
% if private_tallies:
#define ADD_LIMB(cell, value) (*(cell) += (value))
% else:
#define ADD_LIMB(cell, value) atom_add((cell), (value))
% endif
FN void add_exact(__global long *cell, double w) {
    ${point("cells.begin", "const double s = ")}w * 0x1p31;
    const double t0 = s + LIMB_MAGIC;
    const double r1 = (s - (t0 - LIMB_MAGIC)) * 0x1p32;
    const double t1 = r1 + LIMB_MAGIC;
    const double t2 = (r1 - (t1 - LIMB_MAGIC)) * 0x1p32 + LIMB_MAGIC;
    const long zero = as_long(LIMB_MAGIC);
    const long p0 = as_long(t0) - zero, p1 = as_long(t1) - zero, p2 = as_long(t2) - zero;
    if (p0) ADD_LIMB(cell, p0);
    if (p1) ADD_LIMB(cell + 1, p1);
    if (p2) ADD_LIMB(cell + 2, p2);
    ADD_LIMB(cell + 3, 1L);
}
