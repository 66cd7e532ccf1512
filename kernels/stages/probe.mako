## the intersection alone, for one ray in every lane of a work-item's packets
// reads: origins and directions (6 numbers a ray); the face each ray left, as the packet's `left`
// (NO_FACE for a launched ray).
// writes: distance, point and outward normal (7 numbers a ray); what is hit, as the `left` of a ray
// that is reflected there, -1 on a miss.
__kernel void probe_stage(SCENE_ARGUMENTS, __global const double *rays, __global const long *leaves,
                          __global double *hits, __global long *faces, ulong n_rays) {
    const launch_t settings = open_launch(launch_buffer);
    const scene_t scene = open_scene(geometry, materials, sources, codes);
    const long first = (long)(get_global_id(0) * PACKETS * LANES);
    packet_t packets[PACKETS];
    hit_t found[PACKETS];
    for (uint l = 0; l < PACKETS; l++) {
        packet_t *p = packets + l;
        uint n;
        const lint i = rank_lanes(ALL_LANES, &n) + (first + l * LANES);
        clear_packet(p);
        p->alive = ILT(i, lsplat((long)n_rays));
        const lint ray = SELI(p->alive, i, lsplat(0L)), at = ray * 6L;
        p->ox = gather(rays, at); p->oy = gather(rays + 1, at); p->oz = gather(rays + 2, at);
        p->dx = gather(rays + 3, at); p->dy = gather(rays + 4, at); p->dz = gather(rays + 5, at);
        p->left = gather_long(leaves, ray);
    }
    nearest_of(&scene, packets, PACKETS, found);
    for (uint l = 0; l < PACKETS; l++) {
        const packet_t *p = packets + l;
        const hit_t hit = found[l];
        contact_t c;
        locate(&scene, p, &hit, &c);
        const lint face = SELI(hit.found, (hit.code << 2) | (INT_MASK(c.came_plus) & 3L), lsplat(-1L));
% for l in range(lanes):
        if (${lane("p->alive", l)}) {
            const long k = first + l * LANES + ${l};
            faces[k] = ${lane("face", l)};
            hits[7 * k] = ${lane("hit.t", l)};
            hits[7 * k + 1] = ${lane("c.x", l)};
            hits[7 * k + 2] = ${lane("c.y", l)};
            hits[7 * k + 3] = ${lane("c.z", l)};
            hits[7 * k + 4] = ${lane("c.nx", l)};
            hits[7 * k + 5] = ${lane("c.ny", l)};
            hits[7 * k + 6] = ${lane("c.nz", l)};
        }
% endfor
    }
}
