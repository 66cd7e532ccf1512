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
    const real aside = R(row[FLAT_ASIDE]) * near;
    mask in = ALL_LANES, about = in;
% for x, edge in (("x", "U"), ("y", "V")):
    {
        const double high = row[FLAT_OUTER_${edge}], low = -row[FLAT_OUTER_MINUS_${edge}];
        in &= LE(*${x}, splat(fma(2.0, high - row[FLAT_INNER_${edge}], high))) & GE(*${x}, splat(fma(2.0, low + row[FLAT_INNER_MINUS_${edge}], low)));
        about &= LE(*${x}, R(high) + aside) & GE(*${x}, R(low) - aside);
    }
% endfor
    *x = SEL(in, clamp(*x, splat(-row[FLAT_OUTER_MINUS_U]), splat(row[FLAT_OUTER_U])), *x);
    *y = SEL(in, clamp(*y, splat(-row[FLAT_OUTER_MINUS_V]), splat(row[FLAT_OUTER_V])), *y);
    return in | about;
}
% endif

FN mask hit_${cls.suffix}(__global const double *row, long code, const packet_t *p, mask departed,
                      const scene_t *scene, search_t *search, real *t,
                      mask *edge) {
    real x, y, fx, fy;
    const mask on = flat_${cls.suffix}(row, code, p, departed, scene, search, t, &x, &y, &fx, &fy);
    const real bx = fx * R(4.0 * UNIT_ROUNDOFF), by = fy * R(4.0 * UNIT_ROUNDOFF);
% if cls.axis is None:
    const mask ok = on & LE(x, bx + R(row[FLAT_OUTER_U])) & GE(x, -(bx + R(row[FLAT_OUTER_MINUS_U]))) & LE(y, by + R(row[FLAT_OUTER_V])) & GE(y, -(by + R(row[FLAT_OUTER_MINUS_V])));
    *edge = ok & (GT(x, splat(row[FLAT_INNER_U])) | LT(x, splat(-row[FLAT_INNER_MINUS_U])) | GT(y, splat(row[FLAT_INNER_V])) | LT(y, splat(-row[FLAT_INNER_MINUS_V])));
% else:
    const real ax = fabs(x), ay = fabs(y);
    const mask ok = on & ${point("rectangle.edge", "LE(ax, bx + R(row[FLAT_OUTER_U]))")} & LE(ay, by + R(row[FLAT_OUTER_V]));
    *edge = ok & (GT(ax, splat(row[FLAT_INNER_U])) | GT(ay, splat(row[FLAT_INNER_V])));
% endif
    return ok;
}

// Moves a point beyond the edge's inner bound back onto it; gives the lanes moved.
FN mask clamp_${cls.suffix}(const scene_t *scene, lint row, mask m, real *x, real *y) {
    const real hx = gather(scene->geometry + FLAT_INNER_U, row), hy = gather(scene->geometry + FLAT_INNER_V, row);
    const real lx = -gather(scene->geometry + FLAT_INNER_MINUS_U, row), ly = -gather(scene->geometry + FLAT_INNER_MINUS_V, row);
    const mask moved = m & (GT(*x, hx) | LT(*x, lx) | GT(*y, hy) | LT(*y, ly));
    *x = SEL(moved, clamp(*x, lx, hx), *x);
    *y = SEL(moved, clamp(*y, ly, hy), *y);
    return moved;
}
