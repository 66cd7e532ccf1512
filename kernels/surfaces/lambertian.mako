// Lambertian: cosine lobe about the normal on the side that was hit, weight times reflectance.
// sin^2 theta = u in [0, 1), so cos theta = sqrt(1 - u) > 0 and no ray starts into the surface.
// reads: normal, side, material 0 (reflectance), draw DECIDE_SCATTER.
// writes: direction and weight after, side.
FN void meet_lambertian(mask m, const packet_t *p, const contact_t *c, real reflectance, ulong seed,
                        real *dx, real *dy, real *dz, real *after, mask *went_plus) {
    real u, v, s, t, x, y, z;
    draw_pair(seed, p->ray_lo, p->ray_hi, path_of(p), p->generation, DECIDE_SCATTER, &u, &v);
    sincos_turns(v, &s, &t);
    const real sin_theta = sqrt(u);
    const real side = SEL(c->came_plus, splat(1.0), splat(-1.0));
    about_normal(c->nx * side, c->ny * side, c->nz * side,
                 sin_theta * t, sin_theta * s, sqrt(1.0 - u), &x, &y, &z);
    *dx = SEL(m, x, *dx); *dy = SEL(m, y, *dy); *dz = SEL(m, z, *dz);
    *after = SEL(m, p->w * reflectance, *after);
    *went_plus = SEL(m, c->came_plus, *went_plus);
}
