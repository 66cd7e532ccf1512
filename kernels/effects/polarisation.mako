## counts (polarised_sources: whether any source's light is; POLARISED_ …: places in its row), real
// Polarisation: beside its weight, which is I, a ray carries Q/I, U/I and V/I of its light.
// (M. Born and E. Wolf, Principles of Optics, 7th ed., 1.5.2, 1.5.4 and 10.9.3, with exp(-i omega t).)
//
// They are those in the basis e1, e2 that about_normal (vectors.mako) builds across the ray's direction:
// Q = <|E1|^2 - |E2|^2>, U + iV = 2 <E1 E2*>; V is above 0 where the field turns clockwise for who receives the light.
// The basis is a function of the direction, so no reference is carried that could drift.
//
// A face takes E apart along s, the unit vector along d x n, and p = d x s, and puts it together along the same s
// and p' = d' x s: what s is rounded by turns nothing.  Where sin(theta) is less than the unit roundoff there is no
// d x n to speak of; faces act there as if in any plane, to sin^2(theta), and s is e1.  Turns of a basis
// by phi are made of cos 2 phi and sin 2 phi, by products of the components of s.
//
// What a surface does is a pair of amplitudes a_s and a_p.  Of the light's power the parts S and P, S + P = 1, are
// along s and p; S |a_s|^2 + P |a_p|^2 of it go on, and U + iV behind is a_s a_p* times that before.
// How much weight goes on the surface says itself; of amplitudes that are given to polarise() a common factor is of no
// matter.  S and P are right to the rounding of 1: so is what a polariser takes out, beside what came.
//
// reads: packet, contact, amplitudes of surfaces, the sources' light.  gives: the light of an outcome's rays.
% for name, place in counts.items():
% if name.startswith("POLARISED_"):
#define ${name} ${place}
% endif
% endfor

// Light that meets a face: s; the parts of its power along s and p; U and V with respect to them.
typedef struct { real sx, sy, sz, along_s, along_p, u, v; } incident_t;

// |a_s|^2, |a_p|^2 and a_s a_p* of a pair of amplitudes.
typedef struct { real ss, pp, re, im; } amplitudes_t;

FN amplitudes_t real_amplitudes(real s, real p) {
    const amplitudes_t a = {s * s, p * p, s * p, splat(0.0)};
    return a;
}

FN amplitudes_t complex_amplitudes(real s_re, real s_im, real p_re, real p_im) {
    const amplitudes_t a = {fma(s_re, s_re, s_im * s_im), fma(p_re, p_re, p_im * p_im), fma(s_re, p_re, s_im * p_im),
                            fma(s_im, p_re, -(s_re * p_im))};
    return a;
}

FN amplitudes_t chosen_amplitudes(mask m, amplitudes_t a, amplitudes_t b) {
    const amplitudes_t c = {SEL(m, a.ss, b.ss), SEL(m, a.pp, b.pp), SEL(m, a.re, b.re), SEL(m, a.im, b.im)};
    return c;
}

// A metal that conducts perfectly, and whatever is alike for s and p: r_s = -r_p, in these frames, of any size.
FN amplitudes_t conductor() {
    const amplitudes_t a = {splat(1.0), splat(1.0), ${point("polarisation.conductor", "splat(-1.0)")}, splat(0.0)};
    return a;
}

// What passes unchanged but for its power: t_s = t_p.
FN amplitudes_t alike() { return real_amplitudes(splat(1.0), splat(1.0)); }

// e1 and e2 across a unit vector are those of about_normal; the components of a vector along them.
FN void across(real nx, real ny, real nz, real x, real y, real z, real *a, real *b) {
    const real sign = SEL(GE(nz, splat(0.0)), splat(1.0), splat(-1.0));
    const real k = R(-1.0) / (sign + nz);
    const real m = nx * ny * k;
    *a = dot3(x, y, z, fma(sign * nx, nx * k, splat(1.0)), sign * m, -sign * nx);
    *b = dot3(x, y, z, m, fma(ny, ny * k, sign), -ny);
}

// cos 2 phi and sin 2 phi of the direction (a, b), phi = 0 where it is shorter than the unit roundoff.
FN mask twice_the_angle(real a, real b, real *cosine, real *sine) {
    const real square = fma(a, a, b * b);
    const mask some = GT(square, splat(UNIT_ROUNDOFF * UNIT_ROUNDOFF));
    const real inverse = R(1.0) / SEL(some, square, splat(1.0));
    *cosine = SEL(some, (a - b) * (a + b) * inverse, splat(1.0));
    *sine = SEL(some, R(2.0) * a * b * inverse, splat(0.0));
    return some;
}

// What the ray's light is at the face that it meets.
FN incident_t incident_light(const encounter_t *event) {
    const packet_t *p = event->p;
    const contact_t *c = event->c;
    incident_t light;
    // d x n is -(n.e2) e1 + (n.e1) e2
    real a, b, cosine, sine;
    across(p->dx, p->dy, p->dz, c->nx, c->ny, c->nz, &b, &a);
    a = -a;
    const mask some = twice_the_angle(a, b, &cosine, &sine);
    const real length = sqrt(fma(a, a, b * b));
    a = SEL(some, a / SEL(some, length, splat(1.0)), splat(1.0));
    b = SEL(some, b / SEL(some, length, splat(1.0)), splat(0.0));
    about_normal(p->dx, p->dy, p->dz, a, b, splat(0.0), &light.sx, &light.sy, &light.sz);
    const real q = ${point("polarisation.turned", "fma(p->stokes_q, cosine, p->stokes_u * sine)")};
    light.u = fma(p->stokes_u, cosine, -(p->stokes_q * sine));
    light.v = p->stokes_v;
    light.along_s = fmax(fma(splat(0.5), q, splat(0.5)), splat(0.0));
    light.along_p = fmax(fma(splat(-0.5), q, splat(0.5)), splat(0.0));
    return light;
}

// The part of the power that goes on by two real amplitudes; 0.5 (s^2 + p^2) of unpolarised light, to the bit.
FN real part_sent(const incident_t *light, real s, real p) {
    return fma(light->along_s * s, s, light->along_p * (p * p));
}

// That of any amplitudes, of which ss and pp are parts of the power here.
FN real part_of(const incident_t *light, const amplitudes_t *a) {
    return fma(light->along_s, a->ss, light->along_p * a->pp);
}

// The Stokes parameters of what goes on by amplitudes in the direction x, y, z.
FN void sent_light(const incident_t *light, const amplitudes_t *a, real x, real y, real z, real *q, real *u, real *v) {
    const real s = light->along_s * a->ss, p = light->along_p * a->pp;
    const real whole = s + p;
    const mask some = GT(whole, splat(0.0));
    const real inverse = SEL(some, R(1.0) / SEL(some, whole, splat(1.0)), splat(0.0));
    real sq = (s - p) * inverse;
    real su = fma(light->u, a->re, -(light->v * a->im)) * inverse;
    real sv = fma(light->u, a->im, light->v * a->re) * inverse;
    // rounding polarises nothing more than wholly
    const real square = fma(sq, sq, fma(su, su, sv * sv));
    const real less = SEL(GT(square, splat(1.0)), R(1.0) / sqrt(square), splat(1.0));
    sq *= less; su *= less;
    real b1, b2, cosine, sine;
    across(x, y, z, light->sx, light->sy, light->sz, &b1, &b2);
    twice_the_angle(b1, b2, &cosine, &sine);
    *q = fma(sq, cosine, -(su * sine));
    *u = fma(sq, sine, su * cosine);
    *v = sv * less;
}

// The ray that goes on has light of that kind; m: lanes in which a surface has just sent it on.
FN void polarise(outcome_t *o, mask m, const incident_t *light, const amplitudes_t *a) {
    real q, u, v;
    sent_light(light, a, o->dx, o->dy, o->dz, &q, &u, &v);
    o->stokes_q = SEL(m, q, o->stokes_q); o->stokes_u = SEL(m, u, o->stokes_u); o->stokes_v = SEL(m, v, o->stokes_v);
}
% if pairs:

// So has the second one.
FN void polarise_second(outcome_t *o, mask m, const incident_t *light, const amplitudes_t *a) {
    real q, u, v;
    sent_light(light, a, o->second_dx, o->second_dy, o->second_dz, &q, &u, &v);
    o->second_stokes_q = SEL(m, q, o->second_stokes_q); o->second_stokes_u = SEL(m, u, o->second_stokes_u);
    o->second_stokes_v = SEL(m, v, o->second_stokes_v);
}
% endif
% if counts["polarised_sources"]:

// Q/I and U/I of a launched ray: linear, at an angle from the projection of its source's u across the ray, towards v.
FN real launched_light(const launch_t *launch, const scene_t *scene, wide ray, real x, real y, real z, int which) {
    real found = splat(0.0);
    for (ulong n = 0; n < launch->n_sources; n++) {
        __global const double *source = scene->sources + n * SOURCE_STRIDE;
        __global const double *own = scene->geometry + launch->polarisation + n * ${counts["polarised_numbers"]};
        const mask k = MASK_OF(IGE(ray, (wide)(source[SOURCE_FIRST_RAY])) & ILT(ray, (wide)(source[SOURCE_END_RAY])));
        if (!ANY(k)) continue;
        real a, b, cosine, sine;
        across(x, y, z, splat(own[POLARISED_UX]), splat(own[POLARISED_UY]), splat(own[POLARISED_UZ]), &a, &b);
        twice_the_angle(a, b, &cosine, &sine);
        // from u towards v is a right-handed turn about a ray along w, and a left-handed one about one against it
        const real w = dot3(x, y, z, splat(own[POLARISED_WX]), splat(own[POLARISED_WY]), splat(own[POLARISED_WZ]));
        const mask along = ${point("polarisation.along", "GE(w, splat(0.0))")};
        const real q = splat(own[POLARISED_Q]), u = SEL(along, splat(own[POLARISED_U]), splat(-own[POLARISED_U]));
        found = SEL(k, which ? fma(q, sine, u * cosine) : fma(q, cosine, -(u * sine)), found);
    }
    return found;
}
% endif
