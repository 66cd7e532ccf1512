## cls: the element class; rendered once a class
// Rectangle: |x| <= half width, |y| <= half height in its plane, edges included: a hit within the
// rounding bound of an edge counts.
// reads: row, packet.  gives: distance, whether it is hit, whether that is near an edge.
FN mask flat_${cls.suffix}(__global const double *row, long code, const packet_t *p, mask departed, const scene_t *scene,
                       search_t *search, real *t_out, real *x, real *y, real *fx, real *fy);

% if "contact" in effects:
// Whether a point within 64 times `near` of the plane is in the rectangle, or so little outside that
// it may be on a face that meets it at the edge.  One as near as what is put back onto the rectangle
// may be is moved into it.
FN mask about_${cls.suffix}(__global const double *row, real near, real *x, real *y) {
    const real hx = splat(row[3]), hy = splat(row[4]);
    const real kx = splat(fma(2.0, row[3] - row[5], row[3])), ky = splat(fma(2.0, row[4] - row[6], row[4]));
    const real ax = fabs(*x), ay = fabs(*y), aside = row[10] * near;
    const mask in = LE(ax, kx) & LE(ay, ky);
    *x = SEL(in, clamp(*x, -hx, hx), *x);
    *y = SEL(in, clamp(*y, -hy, hy), *y);
    return in | (LE(ax, hx + aside) & LE(ay, hy + aside));
}
% endif

FN mask hit_${cls.suffix}(__global const double *row, long code, const packet_t *p, mask departed,
                      const scene_t *scene, search_t *search, real *t,
                      mask *edge) {
    real x, y, fx, fy;
    const mask on = flat_${cls.suffix}(row, code, p, departed, scene, search, t, &x, &y, &fx, &fy);
    const real ax = fabs(x), ay = fabs(y);
    const mask ok = on & LE(ax, fma(fx, splat(4.0 * UNIT_ROUNDOFF), splat(row[3])))
                       & LE(ay, fma(fy, splat(4.0 * UNIT_ROUNDOFF), splat(row[4])));
    *edge = ok & (GT(ax, splat(row[5])) | GT(ay, splat(row[6])));
    return ok;
}

// Moves a point beyond the edge's inner bound back onto it; gives the lanes moved.
FN mask clamp_${cls.suffix}(const scene_t *scene, lint row, mask m, real *x, real *y) {
    const real hx = gather(scene->geometry + 5, row), hy = gather(scene->geometry + 6, row);
    const mask moved = m & (GT(fabs(*x), hx) | GT(fabs(*y), hy));
    *x = SEL(moved, clamp(*x, -hx, hx), *x);
    *y = SEL(moved, clamp(*y, -hy, hy), *y);
    return moved;
}
