## cls: the element class; faces: how each face of the solid bounds it; rendered once a class
// A convex solid as the intersection of two half-spaces or balls, solved as intervals of t: the ray
// is inside from the last entry to the first exit.  A ray that left the solid on its inside leaves it
// again at the first exit, whatever rounding says; one that left it on its outside never meets it.
//
// lo, hi: the interval inside each bound.  on: the origin is within rounding of that bound's surface.
// back: where a ray that starts on that bound's surface going in comes to it again.
// height: of the origin over that surface, on its outside; near: the rounding of that, at most.
typedef struct {
    real lo, hi, back;
    mask on, in;
% if "contact" in effects:
    real height, near;
% endif
} bound_${cls.suffix};

FN bound_${cls.suffix} bound0_${cls.suffix}(__global const double *row, local_${cls.suffix} r);
FN bound_${cls.suffix} bound1_${cls.suffix}(__global const double *row, local_${cls.suffix} r);

FN mask hit_${cls.suffix}(__global const double *row, long code, const packet_t *p, lint left,
                      const scene_t *scene, search_t *search, real *t_out, lint *face_out) {
    const local_${cls.suffix} r = to_local_${cls.suffix}(row, p);
    bound_${cls.suffix} q0 = bound0_${cls.suffix}(row, r);
    bound_${cls.suffix} q1 = bound1_${cls.suffix}(row, r);
    const mask ours = IEQ(WITHOUT_FACE(left), lsplat(code));
    const mask left0 = ours & IEQ(FACE_OF(left), lsplat(0L));
    const mask left1 = ours & ~left0;
    const mask inside = ours & IEQ(p->left & 2L, lsplat(0L));
    // the origin on faces that were not left: if they are not hit there, the ray is as if it had left
    // them
    mask starts0 = NO_LANES, starts1 = NO_LANES;
% if "contact" in effects:
    const mask beside0 = LE(fabs(q0.height), ${point("solid.beside_first", "R(64.0) * q0.near")}) & LE(q1.height, R(128.0) * q1.near) & ~left0 & p->alive;
    const mask beside1 = LE(fabs(q1.height), ${point("solid.beside_second", "R(64.0) * q1.near")}) & LE(q0.height, R(128.0) * q0.near) & ~left1 & p->alive;
    mask on0 = NO_LANES, on1 = NO_LANES;
    search->doubtful |= beside0 | beside1;
    if (search->careful && ANY(beside0 | beside1)) {
        mask minus0, minus1, cross;
% for n in (0, 1):
        mask goes_minus${n};
        {
            real nx, ny, nz, x = r.x, y = r.y, z = r.z, wx, wy, wz;
            shape_${cls.suffix}(scene, lsplat(ELEMENT_OF(code) * ROW), lsplat(${n}L), &x, &y, &z, &nx, &ny, &nz);
            turn_${cls.suffix}(row, nx, ny, nz, &wx, &wy, &wz);
            const real d_n = dot3(p->dx, p->dy, p->dz, wx, wy, wz);
            goes_minus${n} = LT(d_n, splat(0.0));
            // inside it is on the inside of all its faces
            const real height = SEL(inside, R(-64.0) * q${n}.near, q${n}.height);
            on${n} = ~ours & starts_on(search, p, beside${n}, WITH_FACE(code, ${n}L), q${n}.on & ~inside, height,
                                       q${n}.near, wx, wy, wz, d_n, &minus${n}, &cross);
        }
% endfor
        // it hits the solid where it goes from its outside to its inside or back
        const mask in0 = LE(q0.height, splat(0.0)), in1 = LE(q1.height, splat(0.0));
        const mask was_in = SELM(on0, minus0, in0) & SELM(on1, minus1, in1);
        const mask is_in = SELM(on0, goes_minus0, in0) & SELM(on1, goes_minus1, in1);
        const mask hits = (on0 | on1) & (was_in ^ is_in) & INE(p->left, lsplat(NO_FACE));
        starts0 = hits & on0 & (minus0 ^ goes_minus0);
        starts1 = hits & on1 & (minus1 ^ goes_minus1);
        // beside the rim it is on one face's surface and outside of the other's
        const mask out0 = ~on0 & ~in0, out1 = ~on1 & ~in1;
        on0 &= ~out1;
        on1 &= ~out0;
    }
% else:
    const mask within0 = q0.on | (LE(q0.lo, splat(0.0)) & GE(q0.hi, splat(0.0)));
    const mask within1 = q1.on | (LE(q1.lo, splat(0.0)) & GE(q1.hi, splat(0.0)));
    const mask on0 = q0.on & within1 & ~ours & p->alive, on1 = q1.on & within0 & ~ours & p->alive;
    search->doubtful |= on0 | on1;
    if (search->careful && ANY(on0 | on1)) {
% for n in (0, 1):
        {
            real nx, ny, nz, x = r.x, y = r.y, z = r.z, wx, wy, wz;
            shape_${cls.suffix}(scene, lsplat(ELEMENT_OF(code) * ROW), lsplat(${n}L), &x, &y, &z, &nx, &ny, &nz);
            turn_${cls.suffix}(row, nx, ny, nz, &wx, &wy, &wz);
            // at an edge a ray that goes in hits the face, one that goes out leaves it behind
            starts${n} = crosses(p, on${n}, dot3(p->dx, p->dy, p->dz, wx, wy, wz));
        }
% endfor
    }
% endif
    const mask begins0 = left0 | on0, begins1 = left1 | on1;
    const mask goes_in = SELM(ours, inside, (q0.in | ~on0) & (q1.in | ~on1));
    const real out0 = SEL(begins0, q0.back, SEL(inside, fmax(q0.hi, splat(0.0)), q0.hi));
    const real out1 = SEL(begins1, q1.back, SEL(inside, fmax(q1.hi, splat(0.0)), q1.hi));
    const real in0 = SEL(begins0, splat(0.0), q0.lo), in1 = SEL(begins1, splat(0.0), q1.lo);
    const real enter = fmax(in0, in1), leave = fmin(out0, out1);
    const lint enter_face = SELI(GE(in0, in1), lsplat(0L), lsplat(1L));
    const lint leave_face = SELI(LE(out0, out1), lsplat(0L), lsplat(1L));
    // Where the faces meet at a small angle the rounding of `enter` and `leave` hides which is
    // larger long before the ray is at the rim: there its distance from the axis decides.
    const real near = fma(fabs(r.x) + fabs(r.y) + fabs(r.z), splat(4.0 * UNIT_ROUNDOFF), splat(row[SOLID_NEAR]));
    const real rx = fma(enter, r.dx, r.x), ry = fma(enter, r.dy, r.y), rim = near + R(row[SOLID_RIM]);
    const mask meets = LE(enter, leave + near / fabs(r.dz)) & LE(fma(rx, rx, ry * ry), rim * rim);
    const mask begins = begins0 | begins1;
    const mask from_outside = ~begins & GE(enter, splat(0.0));
    real t = SEL(from_outside, enter, leave);
    lint face = SELI(from_outside, enter_face, leave_face);
    mask ok = SELM(begins, goes_in, SELM(from_outside, meets, LE(enter, leave))) & GE(t, splat(0.0));
    const mask starts = starts0 | starts1;
    t = SEL(starts, splat(0.0), t);
    face = SELI(starts, SELI(starts0, lsplat(0L), lsplat(1L)), face);
    ok |= starts;
    *t_out = t;
    *face_out = face;
    return ok & p->alive;
}
