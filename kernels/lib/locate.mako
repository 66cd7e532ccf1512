## classes: every element class of the program
// Where the ray meets what it hit: the point, put back onto the face, its outward normal, and the
// side the ray came from.
FN void locate(const scene_t *scene, const packet_t *p, const hit_t *h, contact_t *c) {
    const lint row = SEL(h->found, ELEMENT_OF(h->code) * ROW, lsplat(0L));
    real x = fma(h->t, p->dx, p->ox), y = fma(h->t, p->dy, p->oy), z = fma(h->t, p->dz, p->oz);
    real nx = splat(0.0), ny = splat(0.0), nz = splat(0.0);
% if any(not cls.flat for cls in classes):
    mask inside = lsplat(0L);
% endif
% if any(cls.flat for cls in classes):
    const int near_edge = ANY(h->edge);
% endif
% for cls in classes:
    {
        const mask m = h->found & EQ(CLASS_OF(h->code), lsplat(${cls.number}L));
% if cls.flat and cls.axis is not None:
<%
    a, a1, a2 = ("xyz"[(cls.axis + k) % 3] for k in range(3))
%>
        ${a} = SEL(m, h->plane, ${a});
        n${a} = SEL(m, AXIS_SIGN(h->code), n${a});
        if (near_edge && ANY(m & h->edge)) {
            const real c1 = gather(scene->geometry + ${(cls.axis + 1) % 3}, row);
            const real c2 = gather(scene->geometry + ${(cls.axis + 2) % 3}, row);
            real k1 = ${a1} - c1, k2 = ${a2} - c2;
            const mask moved = clamp_${cls.suffix}(scene, row, m & h->edge, &k1, &k2);
            ${a1} = SEL(moved, c1 + k1, ${a1});
            ${a2} = SEL(moved, c2 + k2, ${a2});
        }
% elif cls.flat:
        if (ANY(m)) {
            const real cx = gather(scene->geometry, row), cy = gather(scene->geometry + 1, row);
            const real cz = gather(scene->geometry + 2, row);
            const real ux = gather(scene->geometry + ROW_FRAME, row);
            const real uy = gather(scene->geometry + ROW_FRAME + 1, row);
            const real uz = gather(scene->geometry + ROW_FRAME + 2, row);
            const real vx = gather(scene->geometry + ROW_FRAME + 3, row);
            const real vy = gather(scene->geometry + ROW_FRAME + 4, row);
            const real vz = gather(scene->geometry + ROW_FRAME + 5, row);
            const real wx = gather(scene->geometry + ROW_FRAME + 6, row);
            const real wy = gather(scene->geometry + ROW_FRAME + 7, row);
            const real wz = gather(scene->geometry + ROW_FRAME + 8, row);
            const real off = dot3(x - cx, y - cy, z - cz, wx, wy, wz);
            x = SEL(m, fma(-off, wx, x), x);
            y = SEL(m, fma(-off, wy, y), y);
            z = SEL(m, fma(-off, wz, z), z);
            nx = SEL(m, wx, nx); ny = SEL(m, wy, ny); nz = SEL(m, wz, nz);
            if (ANY(m & h->edge)) {
                real k1 = dot3(x - cx, y - cy, z - cz, ux, uy, uz);
                real k2 = dot3(x - cx, y - cy, z - cz, vx, vy, vz);
                const mask moved = clamp_${cls.suffix}(scene, row, m & h->edge, &k1, &k2);
                x = SEL(moved, cx + fma(k1, ux, k2 * vx), x);
                y = SEL(moved, cy + fma(k1, uy, k2 * vy), y);
                z = SEL(moved, cz + fma(k1, uz, k2 * vz), z);
            }
        }
% else:
        if (ANY(m)) {
% if cls.single:
            __global const double *one = scene->geometry + ROW * ELEMENT_OF(scene->codes[scene->codes[${cls.number}]]);
            const real cx = splat(one[0]), cy = splat(one[1]), cz = splat(one[2]);
            const real k2 = splat(one[4]), k = splat(one[5]);
% else:
            const real cx = gather(scene->geometry, row), cy = gather(scene->geometry + 1, row);
            const real cz = gather(scene->geometry + 2, row);
            const real k2 = gather(scene->geometry + 4, row), k = gather(scene->geometry + 5, row);
% endif
            real fx = x - cx, fy = y - cy, fz = z - cz;
            // two Newton steps bring |f| to R from any error that leaves a hit meaningful
            const real g1 = fma(splat(-0.5) * k2, dot3(fx, fy, fz, fx, fy, fz), splat(1.5));
            fx *= g1; fy *= g1; fz *= g1;
            const real g2 = fma(splat(-0.5) * k2, dot3(fx, fy, fz, fx, fy, fz), splat(1.5));
            fx *= g2; fy *= g2; fz *= g2;
            x = SEL(m, cx + fx, x); y = SEL(m, cy + fy, y); z = SEL(m, cz + fz, z);
            nx = SEL(m, fx * k, nx); ny = SEL(m, fy * k, ny); nz = SEL(m, fz * k, nz);
            // a chord inside ends on the inside, whatever the rounding of d.n says
            inside |= m & EQ(p->left >> 2, h->code) & EQ(p->left & 2L, lsplat(0L));
        }
% endif
    }
% endfor
    c->x = x; c->y = y; c->z = z;
    c->nx = nx; c->ny = ny; c->nz = nz;
    c->came_plus = LE(dot3(p->dx, p->dy, p->dz, nx, ny, nz), splat(0.0));
% if any(not cls.flat for cls in classes):
    c->came_plus &= ~inside;
% endif
}
