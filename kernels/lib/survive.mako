## hooks
// What may end a ray between two interactions: the generation cap, then what effects hook in here for
// the lanes of `met`; a ray that has only passed a surface is not asked again.

// A ray that would start generation `cap` is booked as depth-capped.
FN void cap_generations(const launch_t *launch, packet_t *p, ledger_t *ledger) {
    const mask capped = p->alive & ${point("survive.at_cap", "IGE")}(TO_LINT(p->generation), lsplat((long)launch->generation_cap));
    if (ANY(capped)) {
        ${point("survive.booked", "book_row(launch, ledger, ROW_CAPPED, capped, image_of(p->w));")}
        p->alive &= ~capped;
    }
}

FN void survive(const launch_t *launch, packet_t *p, ledger_t *ledger, mask met) {
    cap_generations(launch, p, ledger);
% for statement in hooks["survive"]:
${statement}
% endfor
}
