## densities
// Directions in which surfaces send rays on.

// d - 2 (d.n) n, with unit length.
FN void reflect(const packet_t *p, const contact_t *c, real *x, real *y, real *z) {
    const real k = R(-2.0) * dot3(p->dx, p->dy, p->dz, c->nx, c->ny, c->nz);
    *x = fma(k, c->nx, p->dx); *y = fma(k, c->ny, p->dy); *z = fma(k, c->nz, p->dz);
    renormalise(x, y, z);
}

// A cosine lobe about the normal on the side that was hit.
// sin^2 theta = u in [0, 1), so cos theta = sqrt(1 - u) > 0 and no ray starts into the surface.
// draws: DECIDE_SCATTER.
FN void scatter_diffusely(ulong seed, const packet_t *p, const contact_t *c, real *x, real *y, real *z) {
    real u, v, s, t;
    draw_pair(seed, p->ray_lo, p->ray_hi, path_of(p), p->generation, DECIDE_SCATTER, &u, &v);
    sincos_turns(${point("directions.turn", "v")}, &s, &t);
    const real sin_theta = ${point("directions.sine", "sqrt(u)")};
    const real side = SEL(c->came_plus, splat(1.0), ${point("directions.other_side", "splat(-1.0)")});
    about_normal(c->nx * side, c->ny * side, c->nz * side,
                 sin_theta * t, sin_theta * s, ${point("directions.cosine", "sqrt(R(1.0) - u)")}, x, y, z);
}
% if densities:

// The density of that, cos theta / pi per steradian; 0 into the surface.
FN real diffuse_density(const contact_t *c, real x, real y, real z) {
    const real side = SEL(c->came_plus, splat(1.0), splat(-1.0));
    return fmax(side * dot3(x, y, z, c->nx, c->ny, c->nz), splat(0.0)) * R(${point("directions.density", "0x1.45f306dc9c883p-2")});
}
% endif
