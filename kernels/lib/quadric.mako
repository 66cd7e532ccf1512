// A quadric of revolution about an axis as a surface with an inside and an outside,
//   G(p) = c (x^2 + y^2 + kappa w^2) + 2 m w + g,
// G < 0 inside.  Along a ray G = a t^2 + 2 b t + f, and with s^2 = b^2 - a f
//   it goes out at t = (-b + s)/a = f/(-b - s) and in at t = (-b - s)/a = f/(-b + s),
// whatever the signs of a and c are: G rises at the one and falls at the other.  So a convex face, a
// concave one and a plane (c = a = 0) are one case, and who knows on which side a ray is needs one root.
typedef struct { scalar c, kappa, m, g; } quadric_t;

// A ray in the quadric's own frame.
typedef struct { real x, y, w, dx, dy, dw; } meridian_t;

// f, b: G and half its slope along the ray; size: of the terms of G.
typedef struct { real f, b, size; } quadric_form_t;

FN real quadric_bend(const quadric_t *q, const meridian_t *r) {
    return q->c * fma(r->dx, r->dx, fma(r->dy, r->dy, q->kappa * r->dw * r->dw));
}

FN quadric_form_t quadric_at(const quadric_t *q, const meridian_t *r, real t) {
    quadric_form_t found;
    const real x = fma(t, r->dx, r->x), y = fma(t, r->dy, r->y), w = fma(t, r->dw, r->w);
    const real cx = q->c * x, cy = q->c * y, cw = q->c * q->kappa * w;
    const scalar twice = R(2.0) * q->m;
    found.f = fma(cx, x, fma(cy, y, fma(w, cw + twice, splat(q->g))));
    found.b = fma(cx, r->dx, fma(cy, r->dy, (cw + q->m) * r->dw));
    found.size = fabs(cx * x) + fabs(cy * y) + fabs(w) * (fabs(cw) + fabs(twice)) + fabs(splat(q->g));
    return found;
}

// Half the length of its gradient.
FN real quadric_steepness(const quadric_t *q, real x, real y, real w) {
    const real cx = q->c * x, cy = q->c * y, cw = fma(q->c * q->kappa, w, splat(q->m));
    return sqrt(fma(cx, cx, fma(cy, cy, cw * cw)));
}

// s^2 with the products' rounding errors carried along.
FN real quadric_discriminant(real a, quadric_form_t q) {
    const real bb = q.b * q.b, af = a * q.f;
    return (bb - af) + (fma(q.b, q.b, -bb) - fma(a, q.f, -af));
}

// The root near t from G there, as far as that is more than rounding of s^2.
FN real quadric_polish(const quadric_t *q, const meridian_t *r, real a, real rounding, real t) {
    const quadric_form_t there = quadric_at(q, r, t);
    const real square = quadric_discriminant(a, there), s = sqrt(fmax(square, splat(0.0)));
    const real most = there.b + copysign(s, there.b), step = there.f / most;
    return SEL(LT(fabs(step), splat(INFINITY)) & ${point("quadric.vague", "GE(square, rounding)")}, t - step, t);
}

// Where the ray goes out, or in, of the quadric; start: G where the ray starts; at: where on the ray G is
// best taken to solve it; slack: by how much rounding may have lowered s^2; rounding: below this s^2 is nothing
// else; least: what s is taken to be at least, so that the ray does cross the surface there; s: that of the root.
// Gives whether there is such a place: of a body that holds the start there is, whatever rounding says.
FN mask quadric_crossing(const quadric_t *q, const meridian_t *r, real a, quadric_form_t start, real at, mask outwards,
                         bool polishes, real slack, real rounding, real least, real *t, real *s) {
    const real zero = splat(0.0);
    const quadric_form_t there = quadric_at(q, r, at);
    real square = quadric_discriminant(a, there);
    if (polishes) {
        // whether the ray meets the body at all is best asked where it is deepest in it
        const quadric_form_t deep = quadric_at(q, r, at - there.b / a);
        const mask better = LT(fma(deep.b, deep.b, fabs(a) * deep.size), fma(there.b, there.b, fabs(a) * there.size));
        square = SEL(better, quadric_discriminant(a, deep), square);
    }
    *s = fmax(sqrt(fmax(square, zero)), least);
    const real most = there.b + copysign(*s, there.b), one = -most / a, other = SEL(EQ(most, zero), zero, -there.f / most);
    *t = at + SEL(outwards ^ GT(most, zero), one, other);
    if (polishes) *t = quadric_polish(q, r, a, rounding, *t);
    return GE(square, -slack) | LT(q->c * start.f, zero) | LE(q->c * a, zero);
}

// The same of a ray that left the surface: its other root.
FN real quadric_chord(const quadric_t *q, const meridian_t *r, real a, quadric_form_t start, bool polishes) {
    const real any = splat(-INFINITY);
    real t = R(2.0) * fabs(start.b) / fabs(a);
    // twice: the chord of a ray that grazes the surface it left is good to no more than a few digits
    if (polishes) t = fmax(quadric_polish(q, r, a, any, ${point("quadric.polished", "quadric_polish(q, r, a, any, t)")}), splat(0.0));
    return t;
}

// How far rounding may move the root t along the ray: much where the ray grazes the surface, and no more
// than its tangent leaves it.  near: the rounding of a coordinate there.
FN real quadric_slide(const quadric_t *q, real a, real steepness, real s, real near) {
    const real rise = R(0.5) * near * (steepness + fabs(q->c) * near);
    // rise s / (s^2 + |a| rise / 2)
    return rise / fma(R(0.5) * fabs(a), rise / s, s);
}
