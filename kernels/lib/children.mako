// Path positions: the launched ray is 1, the children of p are 2p and 2p + 1.  These are all
// different for 54 splits in a row.  Below that the number is mixed and marked by its top bit, so
// that it never meets an unmixed one; siblings always differ (last bit), and two cousins of one
// launched ray meet with probability 2^-54 a pair.
FN luint child_path(luint p, uint side) {
    const luint q = ${point("children.sibling", "(p << 1) | (ulong)side")};
    luint h = p * 0x9E3779B97F4A7C15UL;
    h = (h ^ (h >> 32)) * 0xD6E8FEB86659FD93UL;
    h = (h ^ (h >> 29)) * 0xD6E8FEB86659FD93UL;
    h = h ^ (h >> 32);
    h = (1UL << 55) | ((h << 1) & ((1UL << 55) - 1UL))${point("children.mixed_sibling", " | (ulong)side")};
    return SELI(INE(p >> 54, (luint)(0UL)), h, q);
}
