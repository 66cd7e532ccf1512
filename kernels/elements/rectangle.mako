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
    const real aside = row[9] * near;
    mask in = lsplat(-1L), about = in;
% for x, plus, minus in (("x", 3, 11), ("y", 4, 12)):
    {
        const double high = row[${plus}], low = -row[${minus}];
        in &= LE(*${x}, splat(fma(2.0, high - row[${plus + 2}], high))) & GE(*${x}, splat(fma(2.0, low + row[${minus + 2}], low)));
        about &= LE(*${x}, high + aside) & GE(*${x}, low - aside);
    }
% endfor
    *x = SEL(in, clamp(*x, splat(-row[11]), splat(row[3])), *x);
    *y = SEL(in, clamp(*y, splat(-row[12]), splat(row[4])), *y);
    return in | about;
}
% endif

FN mask hit_${cls.suffix}(__global const double *row, long code, const packet_t *p, mask departed,
                      const scene_t *scene, search_t *search, real *t,
                      mask *edge) {
    real x, y, fx, fy;
    const mask on = flat_${cls.suffix}(row, code, p, departed, scene, search, t, &x, &y, &fx, &fy);
    const real bx = fx * (4.0 * UNIT_ROUNDOFF), by = fy * (4.0 * UNIT_ROUNDOFF);
% if cls.axis is None:
    const mask ok = on & LE(x, bx + row[3]) & GE(x, -(bx + row[11])) & LE(y, by + row[4]) & GE(y, -(by + row[12]));
    *edge = ok & (GT(x, splat(row[5])) | LT(x, splat(-row[13])) | GT(y, splat(row[6])) | LT(y, splat(-row[14])));
% else:
    const real ax = fabs(x), ay = fabs(y);
    const mask ok = on & LE(ax, bx + row[3]) & LE(ay, by + row[4]);
    *edge = ok & (GT(ax, splat(row[5])) | GT(ay, splat(row[6])));
% endif
    return ok;
}

// Moves a point beyond the edge's inner bound back onto it; gives the lanes moved.
FN mask clamp_${cls.suffix}(const scene_t *scene, lint row, mask m, real *x, real *y) {
    const real hx = gather(scene->geometry + 5, row), hy = gather(scene->geometry + 6, row);
    const real lx = -gather(scene->geometry + 13, row), ly = -gather(scene->geometry + 14, row);
    const mask moved = m & (GT(*x, hx) | LT(*x, lx) | GT(*y, hy) | LT(*y, ly));
    *x = SEL(moved, clamp(*x, lx, hx), *x);
    *y = SEL(moved, clamp(*y, ly, hy), *y);
    return moved;
}
