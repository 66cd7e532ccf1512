// Fixed: one reflectance and one transmittance for every angle, from both sides.
// reads: both.  gives: the parts.
FN void coat_fixed(const film_t *film, mask m, weight *r, weight *t) {
    *r = weight_number(film->material, FIXED_COATING_REFLECTANCE);
    *t = weight_number(film->material, FIXED_COATING_TRANSMITTANCE);
}
