## coats (whether there are coatings: one may say what R and T are in their stead, and what neither has is absorbed)
// Fresnel: unpolarised reflection and refraction, both children.
//
// With n1 on the side of incidence, m = n1/n2 and k = (n2 - n1)(n2 + n1)/n2^2 = 1 - m^2 (the host
// takes the difference of the indices before it rounds), ci = |d.n|:
//   ct^2 = m^2 ci^2 + k                                   (total reflection where it is not > 0)
//   r_s  = -k / (m ci + ct)^2
//   r_p  = k (1 - (1 + m^2) (1 - ci^2)) / (ci + m ct)^2
// from (a - b) = (a^2 - b^2)/(a + b) on the usual quotients (Born & Wolf 1.5.2): no difference of
// nearly equal numbers is left at normal incidence, at grazing incidence or for equal indices.
// R = (r_s^2 + r_p^2) / 2; the transmitted weight is what the reflected one leaves.
// reads: direction, normal, side, m and k from either side.
// gives: the transmitted ray, or the reflected one where nothing is transmitted; and the reflected one
// beside it where both exist.
% if amplitudes:
// Polarised light (effects/polarisation.mako) that meets no coating is reflected by r_s and r_p, S r_s^2 + P r_p^2 of its power, and
// transmitted by t_s and t_p, which are as ci + m ct to m ci + ct.  Totally reflected it has
// r_s r_p* = (x + iy)^2 / (x^2 + y^2) with x = m (1 - ci^2), y = ci sqrt(-ct^2)  (Born & Wolf 1.5.4).
% endif
FN void meet_fresnel(const encounter_t *event, const material_t *material, outcome_t *outcome) {
    const packet_t *p = event->p;
    const contact_t *c = event->c;
    const real m = SEL(c->came_plus, material_number(material, ${point("fresnel.ratio_plus", "FRESNEL_RATIO_PLUS")}),
                       material_number(material, ${point("fresnel.ratio_minus", "FRESNEL_RATIO_MINUS")}));
    const real k = SEL(c->came_plus, material_number(material, FRESNEL_ONE_LESS_SQUARE_PLUS),
                       material_number(material, FRESNEL_ONE_LESS_SQUARE_MINUS));
    const real dn = dot3(p->dx, p->dy, p->dz, c->nx, c->ny, c->nz);
    const real ci = fmin(fabs(dn), splat(1.0));
    const real mci = m * ci;
    // the refracted ray's part along the face, before it is scaled by m
    const real sx = fma(-dn, c->nx, p->dx), sy = fma(-dn, c->ny, p->dy), sz = fma(-dn, c->nz, p->dz);
    const real mm = m * m;
    // into a much thinner medium m^2 ci^2 and k are large and cancel, and so do 1 and ci^2; the sine
    // from the part along the face does not
    const mask thinner = GT(mm, splat(2.0));
    const real sin2 = SEL(thinner, dot3(sx, sy, sz, sx, sy, sz), fma(-ci, ci, splat(1.0)));
    const real ct2 = SEL(thinner, fma(-mm, sin2, splat(1.0)), fma(mci, mci, k));
    const real ct = sqrt(fmax(ct2, splat(0.0)));
    const real a = mci + ct, b = fma(m, ct, ci);
    const real rs = ${careful("geometry", "k / (a * a)", "(mci - ct) / a")};
    const real rp = ${careful("geometry", "k * fma(-fma(m, m, splat(1.0)), sin2, splat(1.0)) / (b * b)", "(ci - m * ct) / b")};
% if amplitudes:
    const incident_t light = incident_light(event);
    const real whole = fmin(${point("fresnel.polarised", "part_sent(&light, rs, rp)")}, splat(1.0));
% else:
    const real whole = fmin(${point("fresnel.reflectance", "R(0.5) * fma(rs, rs, rp * rp)")}, splat(1.0));
% endif
    const mask total = LE(ct2, splat(0.0));
<% const = "" if coats else "const " %>\
    ${const}weight wr = SEL_WEIGHT(total, p->w, p->w * TO_WEIGHT(whole));
    ${const}weight wt = ${point("fresnel.transmitted", "p->w - wr")};
% if coats:
% if amplitudes:
    amplitudes_t film_r, film_t;
% endif
    coat(event, material, total, ci, dot3(sx, sy, sz, sx, sy, sz), ct, ct2, m, &wr, &wt${", &light, &film_r, &film_t" if amplitudes else ""});
% endif
    real x, y, z;
    reflect(p, c, &x, &y, &z);
    // refracted: m (d - (d.n) n) + sign(d.n) ct n
    const real g = copysign(ct, dn);
    real tx = fma(m, sx, g * c->nx), ty = fma(m, sy, g * c->ny), tz = fma(m, sz, g * c->nz);
    renormalise(&tx, &ty, &tz);
    const mask reflects = total | WEIGHT_LE(wt, weight_splat(0.0));
    send_on(outcome, event->m, SEL(reflects, x, tx), SEL(reflects, y, ty), SEL(reflects, z, tz),
            SEL_WEIGHT(reflects, ${"wr" if coats else "p->w"}, wt),
            SELW(total, wsplat(TOTALLY_REFLECTED), SELW(reflects, wsplat(REFLECTED), wsplat(TRANSMITTED))));
    outcome->went_plus = SELM(event->m & ~reflects, ~c->came_plus, outcome->went_plus);
    send_second(outcome, ${point("fresnel.splits", "event->m & ~reflects & WEIGHT_GT(wr, weight_splat(0.0))")}, x, y, z, wr,
                wsplat(REFLECTED));
% if amplitudes:
    {
        const real lx = m * sin2, ly = ci * sqrt(fmax(-ct2, splat(0.0)));
        const real inverse = R(1.0) / SEL(total, fma(lx, lx, ly * ly), splat(1.0));
        amplitudes_t r = real_amplitudes(${careful("geometry", "-rs", "rs")}, rp);
        r.ss = SEL(total, splat(1.0), r.ss);
        r.pp = SEL(total, splat(1.0), r.pp);
        r.re = SEL(total, ${point("fresnel.in_phase", "(lx - ly) * (lx + ly) * inverse")}, r.re);
        r.im = SEL(total, R(2.0) * lx * ly * inverse, r.im);
        amplitudes_t t = real_amplitudes(${point("fresnel.transmits", "b, a")});
% if coats:
        const mask coated = IGE(material->coating, lsplat(0L));
        r = chosen_amplitudes(coated, film_r, r);
        t = chosen_amplitudes(coated, film_t, t);
% endif
        const amplitudes_t first = chosen_amplitudes(reflects, r, t);
        polarise(outcome, event->m, &light, &first);
        polarise_second(outcome, event->m, &light, &r);
    }
% endif
}
