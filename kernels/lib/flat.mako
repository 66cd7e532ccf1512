## cls: the element class (axis 0, 1, 2 or None for tilted; suffix); rendered once a class
<%
    a = cls.axis
    names = "xyz"
%>
// ${cls.kind}, ${"tilted" if a is None else "perpendicular to " + names[a]}.
// Row: FLAT_, see photizon_cl/scene/elements/flat.py.
//
// t where the ray meets the plane.  A ray in the plane does not hit it.  A ray that starts within
// rounding of the plane starts on it: then t = 0, and `careful` decides whether that is a hit.
FN mask flat_${cls.suffix}(__global const double *row, long code, const packet_t *p, mask departed,
                       const scene_t *scene, search_t *search, real *t_out, real *x, real *y, real *fx, real *fy) {
% if a is None:
    const real vx = p->ox - R(row[ROW_X]), vy = p->oy - R(row[ROW_Y]), vz = p->oz - R(row[ROW_Z]);
    __global const double *f = row + ROW_FRAME;
    const real u = dot3(vx, vy, vz, splat(f[0]), splat(f[1]), splat(f[2]));
    const real v = dot3(vx, vy, vz, splat(f[3]), splat(f[4]), splat(f[5]));
    const real h = dot3(vx, vy, vz, splat(f[6]), splat(f[7]), splat(f[8]));
    const real du = dot3(p->dx, p->dy, p->dz, splat(f[0]), splat(f[1]), splat(f[2]));
    const real dv = dot3(p->dx, p->dy, p->dz, splat(f[3]), splat(f[4]), splat(f[5]));
    const real dh = dot3(p->dx, p->dy, p->dz, splat(f[6]), splat(f[7]), splat(f[8]));
    const mask on_plane = LE(fabs(h), fma(fabs(u) + fabs(v), splat(4.0 * UNIT_ROUNDOFF), splat(row[FLAT_PLANE])));
% else:
<% a1, a2 = (a + 1) % 3, (a + 2) % 3 %>
    const real u = p->o${names[a1]} - R(row[ROW_X + ${a1}]), v = p->o${names[a2]} - R(row[ROW_X + ${a2}]);
    const real h = p->o${names[a]} - R(row[ROW_X + ${a}]);
    const real du = p->d${names[a1]}, dv = p->d${names[a2]}, dh = p->d${names[a]};
% if "contact" in effects:
    // most rays are far from the plane and need none of the row's second cache line
    mask on_plane = NO_LANES;
    if (ANY(LE(fabs(h), splat(64.0 * row[FLAT_ENDS])) & ~departed)) on_plane = LE(fabs(h), splat(row[FLAT_PLANE]));
% else:
    const mask on_plane = LE(fabs(h), splat(row[FLAT_PLANE]));
% endif
% endif
    real t = SEL(on_plane, splat(0.0), -h / dh);
    *fx = fabs(u);
    *fy = fabs(v);
    mask ok = NE(dh, splat(0.0)) & GE(t, splat(0.0)) & ~departed & p->alive;
% if "contact" in effects:
    const real most = splat(row[FLAT_ENDS]);
    mask beside = LE(fabs(h), R(64.0) * most) & ~departed & p->alive;
    real at_u = u, at_v = v;
    if (ANY(beside)) beside &= about_${cls.suffix}(row, most, &at_u, &at_v);
    mask starts_here = NO_LANES;
    search->doubtful |= beside;
    if (search->careful && ANY(beside)) {
% if a is None:
        const real sign = splat(1.0), nx = splat(f[6]), ny = splat(f[7]), nz = splat(f[8]);
% else:
        const real sign = splat(row[FLAT_SIGN]), n${names[a]} = sign, n${names[(a + 1) % 3]} = splat(0.0), n${names[(a + 2) % 3]} = splat(0.0);
% endif
        mask on_minus, cross;
        starts_here = starts_on(search, p, beside, code, on_plane, h * sign, most, nx, ny, nz, dh * sign, &on_minus, &cross);
        t = SEL(starts_here, splat(0.0), t);
        ok = SELM(starts_here, ${point("flat.crossed", "cross & NE(dh, splat(0.0))")}, ok);
    }
% else:
    const mask starts_here = on_plane & ok;
    search->doubtful |= starts_here;
    if (search->careful && ANY(starts_here)) ok &= ~on_plane | crosses(p, starts_here, h * dh);
% endif
% if "contact" in effects:
    // a ray that goes through the plane where it starts hits the face, if it is this near its edge
    *x = SEL(starts_here, at_u, fma(t, du, u));
    *y = SEL(starts_here, at_v, fma(t, dv, v));
% else:
    *x = fma(t, du, u);
    *y = fma(t, dv, v);
% endif
    *t_out = t;
    return ok;
}

// The hit point put back onto the face, and the normal, for the lanes in m.
FN void place_${cls.suffix}(const scene_t *scene, const packet_t *p, const hit_t *h, mask m, contact_t *c) {
% if a is None:
    if (!ANY(m)) return;
% endif
    const lint row = SELI(m, ELEMENT_OF(h->code) * ROW, lsplat(0L));
% if a is not None:
<% a0, a1, a2 = (names[(a + k) % 3] for k in range(3)) %>
    c->${a0} = SEL(m, h->plane, c->${a0});
    c->n${a0} = SEL(m, AXIS_SIGN(h->code), c->n${a0});
    const mask edge = m & h->edge;
    if (ANY(edge)) {
        const real c1 = gather(scene->geometry + ROW_X + ${(a + 1) % 3}, row);
        const real c2 = gather(scene->geometry + ROW_X + ${(a + 2) % 3}, row);
        real k1 = c->${a1} - c1, k2 = c->${a2} - c2;
        const mask moved = clamp_${cls.suffix}(scene, row, edge, &k1, &k2);
        c->${a1} = SEL(moved, c1 + k1, c->${a1});
        c->${a2} = SEL(moved, c2 + k2, c->${a2});
    }
% else:
    const real cx = gather(scene->geometry + ROW_X, row), cy = gather(scene->geometry + ROW_Y, row);
    const real cz = gather(scene->geometry + ROW_Z, row);
    const real wx = gather(scene->geometry + ROW_FRAME + 6, row);
    const real wy = gather(scene->geometry + ROW_FRAME + 7, row);
    const real wz = gather(scene->geometry + ROW_FRAME + 8, row);
    const real off = dot3(c->x - cx, c->y - cy, c->z - cz, wx, wy, wz);
    c->x = SEL(m, fma(-off, wx, c->x), c->x);
    c->y = SEL(m, fma(-off, wy, c->y), c->y);
    c->z = SEL(m, fma(-off, wz, c->z), c->z);
    c->nx = SEL(m, wx, c->nx); c->ny = SEL(m, wy, c->ny); c->nz = SEL(m, wz, c->nz);
    const mask edge = m & h->edge;
    if (ANY(edge)) {
        const real ux = gather(scene->geometry + ROW_FRAME, row);
        const real uy = gather(scene->geometry + ROW_FRAME + 1, row);
        const real uz = gather(scene->geometry + ROW_FRAME + 2, row);
        const real vx = gather(scene->geometry + ROW_FRAME + 3, row);
        const real vy = gather(scene->geometry + ROW_FRAME + 4, row);
        const real vz = gather(scene->geometry + ROW_FRAME + 5, row);
        real k1 = dot3(c->x - cx, c->y - cy, c->z - cz, ux, uy, uz);
        real k2 = dot3(c->x - cx, c->y - cy, c->z - cz, vx, vy, vz);
        const mask moved = clamp_${cls.suffix}(scene, row, edge, &k1, &k2);
        c->x = SEL(moved, cx + fma(k1, ux, k2 * vx), c->x);
        c->y = SEL(moved, cy + fma(k1, uy, k2 * vy), c->y);
        c->z = SEL(moved, cz + fma(k1, uz, k2 * vz), c->z);
    }
% endif
}
