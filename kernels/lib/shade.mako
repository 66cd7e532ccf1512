## effects, surfaces (kinds in use: .kind, .number, .single)
// What happens to each lane: it escapes, or its surface takes, sends on or splits its weight.
//
// reads: packet, hit.  writes: packet (in place), the ledger; `end` says which lanes ended in a
// place that is recorded, with the weight, the point or direction and the tag that go there;
// `child` is the reflected child of each lane that split.
typedef struct {
    mask m;
    real w, x, y, z;
    lint tag;
    word generation;
} ending_t;

// A number of the lane's material; one row serves every element of a kind that has just one.
FN real material(const scene_t *scene, lint row, long only_row, int column) {
    if (only_row >= 0) return splat(scene->materials[only_row + column]);
    return gather(scene->materials + column, row);
}

<% fresnel = [s.number for s in surfaces if s.kind == "fresnel"] %>
FN void shade(const launch_t *launch, const scene_t *scene, packet_t *p, const hit_t *h,
              ledger_t *ledger, ending_t *end, packet_t *child) {
    const mask found = h->found;
    const mask escaped = p->alive & ~found;
    const lint element = ELEMENT_OF(h->code);
% if fresnel:
    const mask takes = found & NE(SURFACE_OF(h->code), lsplat(${fresnel[0]}L));
% else:
    const mask takes = found;
% endif
% if packets == 1:
    expect(ledger, element, takes);
% endif
    contact_t c;
    locate(scene, p, h, &c);
    const image_t before = image_of(p->w);
    ledger->interactions -= found;
% if any(not s.single for s in surfaces):
    const lint row = MATERIAL_OF(gather_long(scene->codes + launch->material_of, SEL(found, element, lsplat(0L))));
% else:
    const lint row = lsplat(0L);
% endif
    real dx = p->dx, dy = p->dy, dz = p->dz;
    real after = splat(0.0);
    mask went_plus = c.came_plus;
% if "splitting" in effects:
    mask splits = lsplat(0L);
    real rx = dx, ry = dy, rz = dz, reflected = splat(0.0);
% endif
% for surface in surfaces:
    {
        const long only = ${f"scene->codes[launch->material_of_kind + {surface.number}]" if surface.single else "-1"};
% if len(surfaces) > 1:
        const mask m = found & EQ(SURFACE_OF(h->code), lsplat(${surface.number}L));
        if (ANY(m))
% else:
        const mask m = found;
% endif
% if surface.kind == "absorber":
        meet_absorber(m, &after);
% elif surface.kind == "mirror":
        meet_mirror(m, p, &c, material(scene, row, only, 0), &dx, &dy, &dz, &after, &went_plus);
% elif surface.kind == "lambertian":
        meet_lambertian(m, p, &c, material(scene, row, only, 0), launch->seed, &dx, &dy, &dz, &after, &went_plus);
% elif surface.kind == "fresnel":
        splits = meet_fresnel(m, p, &c, material(scene, row, only, 0), material(scene, row, only, 1),
                              material(scene, row, only, 2), material(scene, row, only, 3),
                              &dx, &dy, &dz, &after, &went_plus, &rx, &ry, &rz, &reflected);
% endif
    }
% endfor

    // what the surface keeps, and what leaves the scene
% if any(s.kind != "fresnel" for s in surfaces):
    {
        const image_t kept = image_difference(before, image_of(after));
% if fresnel:
        book(ledger, element, takes, kept);
        book_row(launch, ledger, ROW_ESCAPED, escaped, before);
% else:
        // an escaping lane has after = 0: one booking serves both
        book(ledger, SEL(found, element, lsplat((long)launch->n_elements)), p->alive, kept);
% endif
    }
% else:
    book_row(launch, ledger, ROW_ESCAPED, escaped, before);
% endif

% if records:
    const mask ended = found & LE(after, splat(0.0));
    end->m = lsplat(0L);
% if "far-field" in effects:
    end->m |= escaped;
% endif
% if "detector" in effects:
    end->m |= ended & HAS_DETECTOR(h->code);
% endif
    end->w = p->w;
    end->x = SEL(found, c.x, p->dx);
    end->y = SEL(found, c.y, p->dy);
    end->z = SEL(found, c.z, p->dz);
    end->tag = SEL(found, (element << 1) | (c.came_plus & ~c.inner & 1L), lsplat(-1L));
    end->generation = p->generation;
% endif

    const lint face = (h->code << 2) | (c.came_plus & 1L);
    p->generation += 1u;
% if "contact" in effects:
    // a segment no longer than the rounding of its ends has no direction to speak of
    const mask stayed = LE(h->t, (fabs(p->ox) + fabs(p->oy) + fabs(p->oz)) * (16.0 * UNIT_ROUNDOFF));
    p->came_x = SEL(stayed, p->came_x, p->dx * h->t);
    p->came_y = SEL(stayed, p->came_y, p->dy * h->t);
    p->came_z = SEL(stayed, p->came_z, p->dz * h->t);
    turn_page(p, h);
% endif
% if "splitting" in effects:
    *child = *p;
    child->alive = splits;
    child->ox = c.x; child->oy = c.y; child->oz = c.z;
    child->dx = rx; child->dy = ry; child->dz = rz;
    child->w = reflected;
    child->left = face | (c.came_plus & 2L);
    child->path = child_path(p->path, 1u);
    p->path = SEL(splits, child_path(p->path, 0u), p->path);
% endif
    p->ox = c.x; p->oy = c.y; p->oz = c.z;
    p->dx = dx; p->dy = dy; p->dz = dz;
    p->w = after;
    p->left = face | (went_plus & 2L);
    p->alive = found & GT(after, splat(0.0));
}

// A ray that would start generation `cap` is booked as depth-capped.
FN void cap_generations(const launch_t *launch, packet_t *p, ledger_t *ledger) {
    const mask capped = p->alive & GE(TO_LINT(p->generation), lsplat((long)launch->generation_cap));
    if (ANY(capped)) {
        book_row(launch, ledger, ROW_CAPPED, capped, image_of(p->w));
        p->alive &= ~capped;
    }
}
