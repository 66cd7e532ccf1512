## cls: the element class (.opening); rendered once a class
// Sphere${", with a port" if cls.opening else ""}.
// Row: SPHERE_, see photizon_cl/scene/elements/sphere.py.
//
// With f the origin seen from the centre and b = -f.d: the closest approach is b along the ray at
// distance |l|, and the roots are b -+ s, s^2 = R^2 - |l|^2.  The larger root in magnitude is taken
// as it stands and the other from the product of the roots.  A ray that left this sphere has one
// root at 0, which is removed, and the other at 2b, reached only from inside.  A tangent ray (s = 0)
// hits.
% if cls.opening:
FN mask in_port_${cls.suffix}(__global const double *row, real fx, real fy, real fz,
                          real dx, real dy, real dz, real t) {
    __global const double *f = row + ROW_FRAME + 6;
    const real h = dot3(fx, fy, fz, splat(f[0]), splat(f[1]), splat(f[2]));
    const real dh = dot3(dx, dy, dz, splat(f[0]), splat(f[1]), splat(f[2]));
    return GT(${point("sphere.height", "fma(t, dh, h)")}, fma(fabs(h), splat(4.0 * UNIT_ROUNDOFF), splat(row[SPHERE_RIM])));
}
% endif

FN mask hit_${cls.suffix}(__global const double *row, long code, const packet_t *p, mask departed,
                      const scene_t *scene, search_t *search, real *t_out,
                      mask *edge) {
    const real fx = p->ox - R(row[ROW_X]), fy = p->oy - R(row[ROW_Y]), fz = p->oz - R(row[ROW_Z]);
    const real b = -dot3(fx, fy, fz, p->dx, p->dy, p->dz);
    const mask inside = departed & IEQ(p->left & 2L, lsplat(0L));
    real t = ${point("sphere.chord", "R(2.0) * fabs(b)")};
    mask ok = inside;
% if cls.opening:
    ok &= ~in_port_${cls.suffix}(row, fx, fy, fz, p->dx, p->dy, p->dz, t);
% endif
    const mask free_lanes = ~departed & p->alive;
    if (ANY(free_lanes)) {
        const real radius = splat(row[SPHERE_RADIUS]);
        const real lx = fma(b, p->dx, fx), ly = fma(b, p->dy, fy), lz = fma(b, p->dz, fz);
        const real l = sqrt(dot3(lx, ly, lz, lx, ly, lz));
        const real discriminant = ${careful("geometry", "(radius - l) * (radius + l)", "fma(b, b, radius * radius - dot3(fx, fy, fz, fx, fy, fz))")};
        const real s = sqrt(fmax(discriminant, splat(0.0)));
        // |f|^2 - R^2 with the products' rounding errors carried along
        const real xx = fx * fx, yy = fy * fy, zz = fz * fz, rr = radius * radius;
        const real xe = fma(fx, fx, -xx), ye = fma(fy, fy, -yy), ze = fma(fz, fz, -zz);
        const real re = fma(radius, radius, -rr);
        const real s1 = xx + yy, s1b = s1 - xx, s1e = (xx - (s1 - s1b)) + (yy - s1b);
        const real s2 = s1 + zz, s2b = s2 - s1, s2e = (s1 - (s2 - s2b)) + (zz - s2b);
        const real c = ${careful("geometry", "(s2 - rr) + (((xe + ye) + (ze - re)) + (s1e + s2e))", "dot3(fx, fy, fz, fx, fy, fz) - rr")};
        const real q = b + copysign(s, b);
        const real other = SEL(EQ(q, splat(0.0)), splat(0.0), c / q);
        real t1 = fmin(q, other), t2 = fmax(q, other);
        mask ok1 = GE(t1, splat(0.0)), ok2 = GE(t2, splat(0.0));
        mask on_surface = LE(fabs(c), splat(row[SPHERE_ON_SURFACE])) & free_lanes;
% if "contact" in effects:
        const mask beside = LE(fabs(c), splat(64.0 * row[SPHERE_ON_SURFACE])) & free_lanes;
% else:
        const mask beside = on_surface;
% endif
        search->doubtful |= beside;
        if (search->careful && ANY(beside)) {
% if "contact" in effects:
            // c is 2 R times the height over the sphere
            const real k = splat(row[SPHERE_INVERSE]), height = R(0.5) * c * k, near = splat(0.5 * row[SPHERE_ON_SURFACE]) * k;
            mask on_minus, cross;
            on_surface = starts_on(search, p, beside, code, on_surface, height, near, fx * k, fy * k, fz * k, -b,
                                   &on_minus, &cross);
% else:
            const mask cross = crosses(p, on_surface, splat(0.0));
% endif
            const real chord = R(2.0) * b;
            t1 = SEL(on_surface, splat(0.0), t1);
            ok1 = SELM(on_surface, cross, ok1);
            t2 = SEL(on_surface, chord, t2);
            ok2 = SELM(on_surface, GT(chord, splat(0.0)), ok2);
        }
        const mask real_roots = GE(discriminant, splat(0.0)) | on_surface;
        ok1 &= real_roots;
        ok2 &= real_roots;
% if cls.opening:
        ok1 &= ~in_port_${cls.suffix}(row, fx, fy, fz, p->dx, p->dy, p->dz, t1);
        ok2 &= ~in_port_${cls.suffix}(row, fx, fy, fz, p->dx, p->dy, p->dz, t2);
% endif
        t = SEL(free_lanes, SEL(ok1, t1, t2), t);
        ok = SELM(free_lanes, ok1 | ok2, ok);
    }
    *t_out = t;
    return ok & p->alive;
}

// The hit point put back onto the sphere, and the normal, for the lanes in m.
FN void place_${cls.suffix}(const scene_t *scene, const packet_t *p, const hit_t *h, mask m, contact_t *c) {
    if (!ANY(m)) return;
% if cls.single:
    __global const double *one = scene->geometry + ROW * ONLY_ELEMENT(scene, ${cls.number});
    const real cx = splat(one[ROW_X]), cy = splat(one[ROW_Y]), cz = splat(one[ROW_Z]);
    const real k2 = splat(one[SPHERE_INVERSE_SQUARE]), k = splat(one[SPHERE_INVERSE]);
% else:
    const lint row = SELI(m, ELEMENT_OF(h->code) * ROW, lsplat(0L));
    const real cx = gather(scene->geometry + ROW_X, row), cy = gather(scene->geometry + ROW_Y, row);
    const real cz = gather(scene->geometry + ROW_Z, row);
    const real k2 = gather(scene->geometry + SPHERE_INVERSE_SQUARE, row), k = gather(scene->geometry + SPHERE_INVERSE, row);
% endif
    real fx = c->x - cx, fy = c->y - cy, fz = c->z - cz;
    // two Newton steps bring |f| to R from any error that leaves a hit meaningful
    const real g1 = fma(splat(-0.5) * k2, dot3(fx, fy, fz, fx, fy, fz), splat(1.5));
    fx *= g1; fy *= g1; fz *= g1;
    const real g2 = fma(splat(-0.5) * k2, dot3(fx, fy, fz, fx, fy, fz), splat(1.5));
    fx *= g2; fy *= g2; fz *= g2;
    c->x = SEL(m, cx + fx, c->x); c->y = SEL(m, cy + fy, c->y); c->z = SEL(m, cz + fz, c->z);
    c->nx = SEL(m, fx * k, c->nx); c->ny = SEL(m, fy * k, c->ny); c->nz = SEL(m, fz * k, c->nz);
    // a chord inside ends on the inside, whatever the rounding of d.n says
    c->from_minus |= m & IEQ(p->left >> 2, h->code) & IEQ(p->left & 2L, lsplat(0L));
}
