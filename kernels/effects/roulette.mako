// Russian roulette: a ray below the floor goes on with twice its weight or ends, each with
// probability 1/2 (a draw from [0, 1) below 1/2 goes on); four times and 1/4 where a surface sends on four.
// Both changes of weight are booked.
// reads: weight, floor (fraction of the launched weight), draw DECIDE_ROULETTE.
// writes: weight, alive; rows killed and boosted.  Played once an interaction, by the lanes of `met`.
<%
    # Where a surface sends on four rays instead of two, one in four goes on with four times its weight: else
    # rays below the floor would double at each such surface, up to the cap.
    quarter = extras > 1
    chance = "splat(0.25)" if quarter else "splat(0.5)"
    raised = "(p->w + p->w) + (p->w + p->w)" if quarter else "p->w + p->w"
%>\
FN void roulette(const launch_t *launch, packet_t *p, ledger_t *ledger, mask met) {
% if "launched" in ray_real:
    const weight floor_weight = p->launched * WT(launch->roulette_floor);
% else:
    const weight floor_weight = weight_splat(launch->roulette_floor);
% endif
% if "ratio" in ray_real:
    // what it would weigh where no ray is sent towards anything; one as heavy as it was launched is not played
    // for, so that none comes out heavier by more than that factor
    const weight launched = ${"p->launched" if "launched" in ray_real else "weight_splat(1.0)"};
    const mask low = p->alive & met & WEIGHT_LT(p->w, fmin(${point("roulette.aimed", "floor_weight * p->ratio")}, launched));
% else:
    const mask low = p->alive & met & WEIGHT_LT(p->w, floor_weight);
% endif
    if (ANY(low)) {
        real u, v;
        draw_pair(launch->seed, p->ray_lo, p->ray_hi, path_of(p), p->generation, DECIDE_ROULETTE,
                  &u, &v);
        const mask lives = low & LT(u, ${point("roulette.chance", chance)});
        const mask ends = low & ~lives;
        const image_t before = image_of(p->w);
        const image_t twice = image_of(${raised});
        book_row(launch, ledger, ROW_KILLED, ends, before);
        book_row(launch, ledger, ROW_BOOSTED, lives, ${point("roulette.added", "image_difference(twice, before)")});
        p->w = SEL_WEIGHT(lives, ${point("roulette.weight", raised)}, p->w);
        p->alive &= ~ends;
    }
}
