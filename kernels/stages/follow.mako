## interactions of given rays, each written out; lanes == 1
// reads: origins and directions (6 numbers a ray); the face each left (NO_FACE for a launched ray).
// Follows each ray for `steps` interactions through the functions of the trace: the transmitted
// child where a surface splits, or with `mirrored` the reflected one.  The launch has no generation cap
// and no roulette.
// writes, for every step of every ray: distance, point, normal, direction and weight after (11
// numbers), then the other child's direction and weight (4); and the `left` after it, -1 once the
// ray has ended.
__kernel void follow_stage(SCENE_ARGUMENTS, __global const double *rays, __global const long *leaves,
                           __global double *states, __global long *faces, ulong n_rays, ulong steps, ulong mirrored) {
    const ulong i = get_global_id(0);
    if (i >= n_rays) return;
    const launch_t settings = open_launch(launch_buffer);
    const scene_t scene = open_scene(geometry, materials, sources, codes);
    ledger_t ledger;
    open_ledger(&ledger, tally);
    packet_t p;
    clear_packet(&p);
    p.ox = rays[6 * i]; p.oy = rays[6 * i + 1]; p.oz = rays[6 * i + 2];
    p.dx = rays[6 * i + 3]; p.dy = rays[6 * i + 4]; p.dz = rays[6 * i + 5];
    p.left = leaves[i];
    p.w = 1.0;
    p.alive = ALL_LANES;
    p.ray_lo = (uint)i;
    for (ulong step = 0; step < steps; step++) {
        const ulong k = i * steps + step;
        hit_t hit;
        nearest(&scene, &p, &hit);
        contact_t c;
        packet_t child[CHILDREN];
        interact(&settings, &scene, 0, 0, &ledger, &p, &hit, &c, child);
        real rx = p.dx, ry = p.dy, rz = p.dz;
        weight rw = 0.0;
% if splits:
        if (child->alive) {
            if (mirrored) {
                rx = p.dx; ry = p.dy; rz = p.dz; rw = p.w;
                p = *child;
            } else {
                rx = child->dx; ry = child->dy; rz = child->dz; rw = child->w;
            }
        }
% endif
        faces[k] = p.alive ? p.left : -1L;
        __global double *out = states + 15 * k;
        out[0] = hit.t; out[1] = c.x; out[2] = c.y; out[3] = c.z;
        out[4] = c.nx; out[5] = c.ny; out[6] = c.nz;
        out[7] = p.dx; out[8] = p.dy; out[9] = p.dz; out[10] = p.w;
        out[11] = rx; out[12] = ry; out[13] = rz; out[14] = rw;
        if (!p.alive) {
            for (ulong rest = step + 1; rest < steps; rest++) faces[i * steps + rest] = -1L;
            break;
        }
    }
}
