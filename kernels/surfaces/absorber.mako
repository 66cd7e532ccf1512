// Absorber: all weight ends here.
// reads: nothing.  writes: weight after.
FN void meet_absorber(mask m, real *after) {
    *after = SEL(m, splat(0.0), *after);
}
