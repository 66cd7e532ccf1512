// One of two children goes on, with the weight of both: the second with probability w2/(w1 + w2), which
// leaves every expectation what it is (Spanier and Gelbard, Monte Carlo Principles and Neutron Transport
// Problems, 1969, 2.7: analog branching).
//
// reads: outcome (both children), the weight that arrived, draw DECIDE_CHOICE.
// writes: outcome (the ray that goes on, in place); the ledger, what the sum of both is rounded by.
// No more goes on than arrived, and all of it where the element takes nothing: nothing is lost or made
// at a border of glass, however often it is met.
#define DECIDE_CHOICE 4u
FN void choose(const launch_t *launch, const packet_t *p, const contact_t *c, ledger_t *ledger, lint element,
               mask takes, outcome_t *outcome) {
    const mask both = outcome->splits;
    if (ANY(both)) {
        real u, v;
        draw_pair(launch->seed, p->ray_lo, p->ray_hi, path_of(p), p->generation, DECIDE_CHOICE, &u, &v);
        const weight sum = outcome->w + outcome->second_w;
        const mask second = both & ${point("choice.chance", "WEIGHT_LT(TO_WEIGHT(u) * sum, outcome->second_w)")};
        const weight w = SEL_WEIGHT(takes, fmin(sum, p->w), p->w);
        // the ledger has what neither child took: what both weigh together, to the last bit, is w now
        const image_t sent = image_sum(image_of(outcome->w), image_of(outcome->second_w));
        book(ledger, element, both & takes, ${point("choice.booked", "image_difference(sent, image_of(w))")});
        outcome->dx = SEL(second, outcome->second_dx, outcome->dx);
        outcome->dy = SEL(second, outcome->second_dy, outcome->dy);
        outcome->dz = SEL(second, outcome->second_dz, outcome->dz);
% if events:
        outcome->event = SELW(second, outcome->second_event, outcome->event);
% endif
% if amplitudes:
        outcome->stokes_q = SEL(second, ${point("choice.light", "outcome->second_stokes_q")}, outcome->stokes_q);
        outcome->stokes_u = SEL(second, outcome->second_stokes_u, outcome->stokes_u);
        outcome->stokes_v = SEL(second, outcome->second_stokes_v, outcome->stokes_v);
% endif
        outcome->went_plus = SELM(second, c->came_plus, outcome->went_plus);
        outcome->splits = NO_LANES;
        outcome->w = SEL_WEIGHT(both, ${point("choice.weight", "w")}, outcome->w);
% if densities:
        outcome->drawn &= ~both | ~(second ^ outcome->drawn_second);
        outcome->drawn_second &= ~both;
        outcome->drawn_w = SEL_WEIGHT(both, outcome->w, outcome->drawn_w);
% endif
    }
}
