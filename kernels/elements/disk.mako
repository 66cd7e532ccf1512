## cls: the element class (.opening); rendered once a class
% if cls.opening:
// Annulus: r^2 <= x^2 + y^2 <= R^2 in its plane, both rims included: a hit within the rounding bound
// of either counts.  Its hole has the columns of a half size along v.
% else:
// Disk: x^2 + y^2 <= radius^2 in its plane, rim included: a hit within the rounding bound of the
// rim counts.
% endif
// reads: row, packet.  gives: distance, whether it is hit, whether that is near the rim.
FN mask flat_${cls.suffix}(__global const double *row, long code, const packet_t *p, mask departed, const scene_t *scene,
                       search_t *search, real *t_out, real *x, real *y, real *fx, real *fy);

% if "contact" in effects:
// Whether a point within 64 times `near` of the plane is in the disk, or so little outside that it
// may be on a face that meets it at the rim.  One as near as what is put back onto the disk may be is
// moved into it.
FN mask about_${cls.suffix}(__global const double *row, real near, real *x, real *y) {
    const real r = sqrt(fma(*x, *x, *y * *y));
% if cls.opening:
    const mask in = LE(r, splat(fma(2.0, row[FLAT_OUTER_U] - row[FLAT_INNER_U], row[FLAT_OUTER_U])))
        & GE(r, splat(fma(2.0, row[FLAT_OUTER_V] - row[FLAT_INNER_V], row[FLAT_OUTER_V])));
    const real to = clamp(r, splat(row[FLAT_OUTER_V]), splat(row[FLAT_OUTER_U]));
    const real k = SEL(in & NE(r, to), to / r, splat(1.0));
    *x *= k;
    *y *= k;
    return in | (LE(r, R(row[FLAT_OUTER_U]) + R(row[FLAT_ASIDE]) * near) & GE(r, R(row[FLAT_OUTER_V]) - R(row[FLAT_ASIDE]) * near));
% else:
    const mask in = LE(r, splat(fma(2.0, row[FLAT_OUTER_U] - row[FLAT_INNER_U], row[FLAT_OUTER_U])));
    const real k = SEL(in & GT(r, splat(row[FLAT_OUTER_U])), R(row[FLAT_OUTER_U]) / r, splat(1.0));
    *x *= k;
    *y *= k;
    return in | LE(r, R(row[FLAT_OUTER_U]) + R(row[FLAT_ASIDE]) * near);
% endif
}
% endif

FN mask hit_${cls.suffix}(__global const double *row, long code, const packet_t *p, mask departed,
                      const scene_t *scene, search_t *search, real *t,
                      mask *edge) {
    real x, y, fx, fy;
    const mask on = flat_${cls.suffix}(row, code, p, departed, scene, search, t, &x, &y, &fx, &fy);
    const real bound = fma(fx + fy, splat(4.0 * UNIT_ROUNDOFF), splat(row[FLAT_OUTER_U]));
    const real r2 = fma(x, x, y * y);
% if cls.opening:
    const real hole = fmax(fma(fx + fy, splat(-4.0 * UNIT_ROUNDOFF), splat(row[FLAT_OUTER_V])), splat(0.0));
    const mask ok = on & ${point("disk.rim", "LE(r2, bound * bound)")} & GE(r2, hole * hole);
    *edge = ok & (GT(r2, splat(row[FLAT_INNER_U] * row[FLAT_INNER_U])) | LT(r2, splat(row[FLAT_INNER_V] * row[FLAT_INNER_V])));
% else:
    const mask ok = on & ${point("disk.rim", "LE(r2, bound * bound)")};
    *edge = ok & GT(r2, splat(row[FLAT_INNER_U] * row[FLAT_INNER_U]));
% endif
    return ok;
}

// Moves a point beyond the rim's inner bound back onto it; gives the lanes moved.
FN mask clamp_${cls.suffix}(const scene_t *scene, lint row, mask m, real *x, real *y) {
    const real radius = gather(scene->geometry + FLAT_INNER_U, row);
    const real r = sqrt(fma(*x, *x, *y * *y));
% if cls.opening:
    const real to = clamp(r, gather(scene->geometry + FLAT_INNER_V, row), radius);
    const mask moved = m & NE(r, to) & GT(r, splat(0.0));
    const real k = SEL(moved, to / r, splat(1.0));
% else:
    const mask moved = m & GT(r, radius);
    const real k = SEL(moved, radius / r, splat(1.0));
% endif
    *x *= k;
    *y *= k;
    return moved;
}
