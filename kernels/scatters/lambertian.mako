// Lambertian scatter: the same BSDF everywhere, beta uniform over the disc.
// reads: height.  gives: beta, never beyond the horizon; BSDF.
FN mask try_lambertian(const lobe_t *s, ulong seed, mask m, draws_t *draws, real u, real v, real *x, real *y) {
    real si, co;
    sincos_turns(v, &si, &co);
    const real r = sqrt(u);
    *x = r * co; *y = r * si;
    return m;
}
% if densities:

FN real bsdf_lambertian(const lobe_t *s, real square) { return lobe_number(s, DIFFUSE_HEIGHT); }
% endif
