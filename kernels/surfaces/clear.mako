// Clear: nothing happens.  The ray goes on through it with its weight and its generation, and makes no
// draw; only a detector takes note.
// reads: direction, weight, side.  gives: the same ray, on the other side.
FN void meet_clear(const encounter_t *event, const material_t *material, outcome_t *outcome) {
    const packet_t *p = event->p;
    send_on(outcome, event->m, p->dx, p->dy, p->dz, p->w, wsplat(PASSED));
    outcome->went_plus = SELM(event->m, ${point("clear.side", "~event->c->came_plus")}, outcome->went_plus);
    outcome->passes |= event->m;
}
