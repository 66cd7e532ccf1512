## effects
// What may end a ray between two interactions: the generation cap, then roulette.
FN void survive(const launch_t *launch, packet_t *p, ledger_t *ledger) {
    cap_generations(launch, p, ledger);
% if "roulette" in effects:
    roulette(launch, p, ledger);
% endif
}
