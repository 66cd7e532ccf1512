// Philox4x32-10 (Salmon, Moraes, Dror, Shaw, SC'11), and how photizon_cl keys it.
//
// key     = the 64-bit seed
// counter = (ray number: 48 bits, decision: 4 bits, path position: 56 bits, generation: 20 bits),
//           packed as c0 = ray[31:0], c1 = ray[47:32] | decision << 16 | path[55:44] << 20,
//           c2 = path[31:0], c3 = generation | path[43:32] << 20.
// Every draw of a run has a counter of its own; a draw that is not made shifts no other.
## Decision 4 is that of effects/choice, 5 that of effects/importance, 6 that of effects/scatter, 7 that of
## effects/spectrum, which define them.
#define PHILOX_M0 0xD2511F53u
#define PHILOX_M1 0xCD9E8D57u
#define PHILOX_W0 0x9E3779B9u
#define PHILOX_W1 0xBB67AE85u

#define DECIDE_DIRECTION 0u
#define DECIDE_POSITION 1u
#define DECIDE_SCATTER 2u
#define DECIDE_ROULETTE 3u

% if lanes == 1:
FN void philox4x32_10(word *c0, word *c1, word *c2, word *c3, uint k0, uint k1) {
    word x0 = *c0, x1 = *c1, x2 = *c2, x3 = *c3;
% for r in range(point("philox.rounds", 10)):
    {
        const ulong p0 = (ulong)x0 * PHILOX_M0, p1 = (ulong)x2 * PHILOX_M1;
        x0 = (uint)(p1 >> 32) ^ x1 ^ (k0 + ${r}u * PHILOX_W0);
        x2 = (uint)(p0 >> 32) ^ x3 ^ (k1 + ${r}u * PHILOX_W1);
        x1 = (uint)p1;
        x3 = (uint)p0;
    }
% endfor
    *c0 = x0; *c1 = x1; *c2 = x2; *c3 = x3;
}
% else:
// Words stay in 64-bit lanes, where the 32 x 32 -> 64 bit product is one instruction.
FN void philox4x32_10(word *c0, word *c1, word *c2, word *c3, uint k0, uint k1) {
    luint x0 = TO_LUINT(*c0), x1 = TO_LUINT(*c1), x2 = TO_LUINT(*c2), x3 = TO_LUINT(*c3);
% for r in range(point("philox.rounds", 10)):
    {
        const luint p0 = (x0 & 0xFFFFFFFFUL) * (ulong)PHILOX_M0, p1 = (x2 & 0xFFFFFFFFUL) * (ulong)PHILOX_M1;
        x0 = (p1 >> 32) ^ x1 ^ (ulong)(k0 + ${r}u * PHILOX_W0);
        x2 = (p0 >> 32) ^ x3 ^ (ulong)(k1 + ${r}u * PHILOX_W1);
        x1 = p1;
        x3 = p0;
    }
% endfor
    *c0 = TO_WORD(x0); *c1 = TO_WORD(x1); *c2 = TO_WORD(x2); *c3 = TO_WORD(x3);
}
% endif

% if real == "double":
// Two words to a double in [0, 1): 53 bits, every step exact.
FN real u01_closed_open(word hi, word lo) {
    return fma(TO_REAL(hi), splat(0x1p-32), ${point("philox.low_word", "TO_REAL(lo >> 11)")} * R(0x1p-53));
}
% else:
// Two words to a float in [0, 1): the double that they make, cut to 24 bits from its first one on.
// Rounded to nearest it could be 1, and a chance of 1/2 would be less than that; cut, it is below
// another float where the double is.  Below 2^-8 all of `hi` is kept, and the sum is rounded.
FN real u01_closed_open(word hi, word lo) {
    const word cut = (wsplat(0xFFFFFFFFu) >> clz(hi)) >> 24;
    return fma(TO_REAL(hi & ~cut), splat(0x1p-32), ${point("philox.low_word", "TO_REAL(lo >> 11)")} * R(0x1p-53));
}
% endif

// The two uniforms in [0, 1) of one decision of one ray.
FN void draw_pair(ulong seed, word ray_lo, word ray_hi, luint path, word generation, uint decision,
                  real *u, real *v) {
    word c0 = ray_lo;
    word c1 = ${point("philox.ray", "ray_hi")} | ${point("philox.decision", "(decision << 16)")} | (TO_WORD(path >> 44) << 20);
    word c2 = TO_WORD(path);
    word c3 = ${point("philox.generation", "generation")} | (TO_WORD(path >> 32) << 20);
    philox4x32_10(&c0, &c1, &c2, &c3, (uint)seed, (uint)(seed >> 32));
    *u = u01_closed_open(c0, c1);
    *v = u01_closed_open(c2, c3);
}
