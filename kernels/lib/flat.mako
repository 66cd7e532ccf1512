## cls: the element class (axis 0, 1, 2 or None for tilted; suffix); rendered once a class
<%
    a = cls.axis
    names = "xyz"
%>
// ${cls.kind}, ${"tilted" if a is None else "perpendicular to " + names[a]}.
// Row: 0-2 centre, 3-4 half sizes with their rounding bound, 5-6 half sizes less that bound,
// 7 rounding bound of the plane, 8 sign of the normal along its axis, 15-23 frame.
//
// t where the ray meets the plane.  A ray in the plane does not hit it.  A ray that starts within
// rounding of the plane starts on it: then t = 0, and `careful` decides whether that is a hit.
FN mask flat_${cls.suffix}(__global const double *row, const packet_t *p, mask departed,
                       const scene_t *scene, int careful, mask *doubtful, real *t_out, real *x, real *y, real *fx, real *fy) {
% if a is None:
    const real vx = p->ox - row[0], vy = p->oy - row[1], vz = p->oz - row[2];
    __global const double *f = row + ROW_FRAME;
    const real u = dot3(vx, vy, vz, splat(f[0]), splat(f[1]), splat(f[2]));
    const real v = dot3(vx, vy, vz, splat(f[3]), splat(f[4]), splat(f[5]));
    const real h = dot3(vx, vy, vz, splat(f[6]), splat(f[7]), splat(f[8]));
    const real du = dot3(p->dx, p->dy, p->dz, splat(f[0]), splat(f[1]), splat(f[2]));
    const real dv = dot3(p->dx, p->dy, p->dz, splat(f[3]), splat(f[4]), splat(f[5]));
    const real dh = dot3(p->dx, p->dy, p->dz, splat(f[6]), splat(f[7]), splat(f[8]));
    const real sign = splat(1.0);
    const real near = fma(fabs(u) + fabs(v), splat(row[9]), splat(row[7]));
% else:
<% a1, a2 = (a + 1) % 3, (a + 2) % 3 %>
    const real u = p->o${names[a1]} - row[${a1}], v = p->o${names[a2]} - row[${a2}];
    const real h = p->o${names[a]} - row[${a}];
    const real du = p->d${names[a1]}, dv = p->d${names[a2]}, dh = p->d${names[a]};
    const real sign = splat(row[8]);
    const real near = splat(row[7]);
% endif
    const mask on_plane = LE(fabs(h), near);
    const real t = SEL(on_plane, splat(0.0), -h / dh);
    *x = fma(t, du, u);
    *y = fma(t, dv, v);
    *fx = fabs(u);
    *fy = fabs(v);
    *t_out = t;
    mask ok = NE(dh, splat(0.0)) & GE(t, splat(0.0)) & ~departed & p->alive;
    const mask starts_here = on_plane & ok;
    *doubtful |= starts_here;
    if (careful && ANY(starts_here)) {
% if a is None:
        const real nx = splat(f[6]), ny = splat(f[7]), nz = splat(f[8]);
% else:
        const real n${names[a]} = sign, n${names[a1]} = splat(0.0), n${names[a2]} = splat(0.0);
% endif
        ok &= ~on_plane | crosses(scene, p, nx, ny, nz, dh * sign, h * dh);
    }
    return ok;
}
