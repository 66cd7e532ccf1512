// Absorber: all weight ends here.
// reads: nothing.  gives: nothing goes on.
FN void meet_absorber(const encounter_t *event, const material_t *material, outcome_t *outcome) {
}
