## surfaces (kinds in use: .kind, .number, .single, .absorbs, .splits), effects, recorded, splits, extras, passes,
## coats (whether there are coatings), ray_fields (.onward, .second: their values behind a surface)
// What happens to each lane: it escapes, or its surface takes, sends on or splits its weight.
//
// reads: packet, hit, contact.  writes: packet (in place), the ledger; `end` says which lanes arrive at a
// place that is recorded, with what is recorded of them; `child` is the second ray of each lane that
// split${", and behind it stand those that go on beside both" if extras else ""}.
typedef struct {
    mask m;
${ending_struct}} ending_t;

<%
    lossless = [s for s in surfaces if not s.absorbs]
    lossy = [s for s in surfaces if s.absorbs]
    lossy_splits = any(s.splits for s in lossy)
%>
FN mask shade(const launch_t *launch, const scene_t *scene, packet_t *p, const hit_t *h, const contact_t *c,
              ledger_t *ledger, ending_t *end, packet_t *child) {
    const mask found = h->found;
    const mask escaped = p->alive & ~found;
    const lint element = ELEMENT_OF(h->code);
% if coats:
    const lint coating = gather_long(scene->codes + launch->coatings, SELI(found, ${"material_of_face(h->code)" if "face-surfaces" in effects else "element"}, lsplat(0L)));
    const lint coating_head = SELI(IGE(coating, lsplat(0L)), coating >> 1, lsplat((long)launch->coating_head));
% endif
    // the lanes whose element takes what does not go on
% if not lossy:
    const mask takes = NO_LANES;
% else:
    const mask takes = found${" & " + point("shade.takes", "INE(coating & 1L, lsplat(0L))") if coats else "".join(f" & INE(SURFACE_OF(h->code), lsplat({s.number}L))" for s in lossless)};
% endif
% if packets == 1:
    expect(ledger, element, takes);
% endif
    const image_t before = image_of(p->w);
% if any(not s.single for s in surfaces):
    const lint row = ${"gather_long(scene->codes + launch->material_of_face, SELI(found, material_of_face(h->code), lsplat(0L)))" if "face-surfaces" in effects else "MATERIAL_OF(gather_long(scene->codes + launch->material_of, SELI(found, element, lsplat(0L))))"}${f" + p->piece * {(counts['band_degree'] + 1) * strides.material}L" if "piece" in ray_long else f" + p->line * {strides.material}L" if "line" in ray_long else ""};
% else:
    const lint row = lsplat(0L);
% endif
    outcome_t outcome = no_outcome(p, c);
% for surface in surfaces:
    {
        const material_t material = {scene->materials, row, ${f"scene->codes[launch->material_of_kind + {surface.number}]" if surface.single else "-1"}${", p->along" if "piece" in ray_long else ""}${", scene, coating, coating_head" if coats else ""}};
% if len(surfaces) > 1:
        const encounter_t event = {found & IEQ(SURFACE_OF(h->code), lsplat(${surface.number}L)), p, c, launch->seed};
        if (ANY(event.m))
% else:
        const encounter_t event = {found, p, c, launch->seed};
% endif
        meet_${surface.kind}(&event, &material, &outcome);
    }
% endfor
% if passes:
    const mask met = ${point("shade.met", "found & ~outcome.passes")};
    ledger->passed -= INT_MASK(found & outcome.passes);
% else:
    const mask met = found;
% endif
    ledger->interactions -= INT_MASK(met);

    // what the surface keeps, and what leaves the scene
% if lossy:
    {
% if lossy_splits:
        const image_t sent = image_sum(image_of(outcome.w), image_of(SEL_WEIGHT(outcome.splits, outcome.second_w, weight_splat(0.0))));
        const image_t kept = image_difference(before, ${point("shade.sent", "sent")});
% else:
        const image_t kept = image_difference(before, image_of(outcome.w));
% endif
% if lossless or coats:
        book(ledger, element, takes, kept);
        book_row(launch, ledger, ROW_ESCAPED, escaped, before);
% else:
        // of an escaping lane nothing goes on: one booking serves both
        book(ledger, SELI(found, element, lsplat((long)launch->n_elements)), p->alive, kept);
% endif
    }
% else:
    book_row(launch, ledger, ROW_ESCAPED, escaped, before);
% endif

% if recorded:
    end->m = NO_LANES;
% if "escapes" in recorded:
    end->m |= escaped;
% endif
% if "arrivals" in recorded:
    end->m |= found & HAS_DETECTOR(h->code);
% endif
% for field in ending_fields:
    end->${field.name} = ${field.value};
% endfor
% endif
% for statement in hooks["surface"]:
${statement}
% endfor

    const lint face = (h->code << 2) | (INT_MASK(c->came_plus) & 1L);
% if passes:
    p->generation += SELW(met, wsplat(1u), wsplat(0u));
% else:
    p->generation += 1u;
% endif
% if "contact" in effects:
    // a segment no longer than the rounding of its ends has no direction to speak of
    const mask stayed = LE(h->t, (fabs(p->ox) + fabs(p->oy) + fabs(p->oz)) * R(16.0 * UNIT_ROUNDOFF));
    p->came_x = SEL(stayed, p->came_x, p->dx * h->t);
    p->came_y = SEL(stayed, p->came_y, p->dy * h->t);
    p->came_z = SEL(stayed, p->came_z, p->dz * h->t);
    turn_page(p, h);
% endif
% if splits:
    *child = *p;
    child->alive = outcome.splits;
    child->ox = c->x; child->oy = c->y; child->oz = c->z;
    child->dx = outcome.second_dx; child->dy = outcome.second_dy; child->dz = outcome.second_dz;
    child->w = outcome.second_w;
    child->left = face | (INT_MASK(c->came_plus) & 2L);
    child->path = child_path(p->path, 1u);
% for field in ray_fields:
% if field.second:
    child->${field.name} = ${field.second};
% endif
% endfor
% for k in range(extras):
    {
        // the ray beside, as if it were the one that goes on
        const extra_t *extra = outcome.extra + ${k};
        packet_t *beside = child + ${k + 1};
        *beside = *p;
        beside->alive = extra->m & WEIGHT_GT(extra->w, weight_splat(0.0));
        beside->ox = c->x; beside->oy = c->y; beside->oz = c->z;
        beside->dx = extra->dx; beside->dy = extra->dy; beside->dz = extra->dz;
        beside->w = extra->w;
        beside->left = face | (INT_MASK(extra->plus) & 2L);
        outcome_t own = outcome;
        own.went_plus = extra->plus;
% if events:
        own.event = wsplat(SCATTERED);
% endif
% if "ratio" in ray_real:
        own.ratio = extra->ratio;
        own.drawn_second = NO_LANES;
% endif
        {
            const outcome_t outcome = own;
% for field in ray_fields:
% if field.onward:
            beside->${field.name} = ${field.beside or field.onward};
% endif
% endfor
        }
        beside->path = extra->path;
    }
% endfor
    p->path = SELI(outcome.splits, child_path(p->path, 0u), p->path);
% if extras:
    p->path = SELI(outcome.extra[0].m, child_path(p->path, 0u), p->path);
% endif
% if extras > 1:
    child->path = SELI(outcome.extra[1].m, child_path(child->path, 0u), child->path);
% endif
% endif
% for field in ray_fields:
% if field.onward:
    p->${field.name} = ${{"real": "SEL", "weight": "SEL_WEIGHT", "word": "SELW"}.get(field.type, "SELI")}(met, ${field.onward}, p->${field.name});
% endif
% endfor
    p->ox = c->x; p->oy = c->y; p->oz = c->z;
    p->dx = outcome.dx; p->dy = outcome.dy; p->dz = outcome.dz;
    p->w = outcome.w;
    p->left = face | (INT_MASK(outcome.went_plus) & 2L);
    p->alive = found & WEIGHT_GT(outcome.w, weight_splat(0.0));
    return met;
}
