## classes: every element class of the program; effects; orders
// The nearest face ahead of every live lane.
//
// A ray that starts on a face it did not leave is doubtful: `crosses` must say whether it hits that
// face.  That is rare and slow, so the first search only finds out whether a ray is doubtful, and a
// second, careful one is made where one is.
FN void begin_search(search_t *search, int careful, hit_t *h) {
    search->careful = careful;
    search->doubtful = NO_LANES;
% if orders:
    search->settling = 0;
% endif
% if "contact" in effects:
% for n in range(counts["note_words"]):
    search->noted.word${n} = lsplat(-1L);
% endfor
% endif
    h->t = splat(INFINITY);
    h->code = lsplat(LONG_MAX);
    h->plane = splat(0.0);
    h->edge = NO_LANES;
}

FN void end_search(const search_t *search, const packet_t *p, hit_t *h) {
% if "contact" in effects:
    h->noted = search->noted;
% endif
    h->found = p->alive & LT(h->t, splat(INFINITY));
}

% if "acceleration" in effects:
// reads: packets (of one lane each), geometry, codes.  gives: a hit for each.
FN void nearest_of(const scene_t *scene, const packet_t *packets, uint n, hit_t *hits) {
    search_t searches[PACKETS];
    uint wanted = 0;
    for (uint l = 0; l < n; l++) {
        if (packets[l].alive) {
            wanted |= 1u << l;
        } else {
            begin_search(searches + l, 0, hits + l);
            end_search(searches + l, packets + l, hits + l);
        }
    }
    for (int careful = 0; wanted; careful++) {
        for (uint rest = wanted; rest; rest &= rest - 1u) begin_search(searches + FIRST_PACKET(rest), careful, hits + FIRST_PACKET(rest));
        search_tree(scene, packets, wanted, searches, hits);
        for (uint rest = wanted; rest; rest &= rest - 1u) {
            const uint l = FIRST_PACKET(rest);
            if (searches[l].doubtful && !careful) continue;
            end_search(searches + l, packets + l, hits + l);
            wanted ${point("nearest.searched", "&= ~(1u << l)")};
        }
    }
% if orders:
    for (uint l = 0; l < n; l++) {
        if (packets[l].alive && begin_settling(scene, searches + l, packets + l, hits + l)) wanted |= 1u << l;
    }
    if (!wanted) return;
    search_tree(scene, packets, wanted, searches, hits);
    for (uint rest = wanted; rest; rest &= rest - 1u) end_settling(searches + FIRST_PACKET(rest), hits + FIRST_PACKET(rest));
% endif
}

FN void nearest(const scene_t *scene, const packet_t *p, hit_t *h) {
    nearest_of(scene, p, 1, h);
}
% else:
<%def name="scan()">\
% for cls in classes:
        for (long j = scene->codes[${cls.number}]; j < scene->codes[${cls.number} + 1]; j++) {
            const long code = scene->codes[j];
            meet_${cls.suffix}(scene, scene->geometry + ELEMENT_OF(code) * ROW, code, p, left, &search, h);
        }
% endfor
</%def>\
// reads: packet, geometry, codes.  gives: hit.
FN void nearest(const scene_t *scene, const packet_t *p, hit_t *h) {
    const lint left = p->left >> 2;
    search_t search;
    for (int careful = 0; careful < 2; careful++) {
        begin_search(&search, careful, h);
${scan()}\
        if (!ANY(search.doubtful)) break;
    }
    end_search(&search, p, h);
% if orders:
    if (begin_settling(scene, &search, p, h)) {
${scan()}\
        end_settling(&search, h);
    }
% endif
}

// A packet at a time.
FN void nearest_of(const scene_t *scene, const packet_t *packets, uint n, hit_t *hits) {
    for (uint l = 0; l < n; l++) nearest(scene, packets + l, hits + l);
}
% endif
