## sources: the source kinds in use, each with .stem, .number and .extended
// Fresh rays into the lanes set in m: ray i of the batch in slot `slot`.
// reads: source table, draws DECIDE_DIRECTION and (extended sources) DECIDE_POSITION.
// writes: every field of the packet's lanes in m.
FN void generate(const launch_t *launch, const scene_t *scene, ulong slot, lint i, mask m, packet_t *p) {
    const luint number = AS_LUINT(i) + (launch->ray_base + slot * launch->rays_per_batch);
    const word lo = TO_WORD(number), hi = TO_WORD(number >> 32);
    const word born = wsplat(0u);
    const luint root = (luint)(1UL);
    real x = splat(0.0), y = splat(0.0), z = splat(0.0), dx = x, dy = x, dz = x, w = splat(1.0);
    real u, v, pu = splat(0.0), pv = splat(0.0);
    draw_pair(launch->seed, lo, hi, root, born, DECIDE_DIRECTION, &u, &v);
% if any(s.extended for s in sources):
    draw_pair(launch->seed, lo, hi, root, born, DECIDE_POSITION, &pu, &pv);
% endif
    const real ri = TO_REAL(i);
    for (ulong s = 0; s < launch->n_sources; s++) {
        __global const double *source = scene->sources + s * SOURCE_STRIDE;
        const mask k = GE(ri, splat(source[5])) & LT(ri, splat(source[6]));
        if (ANY(k & m)) {
            real sx, sy, sz, sdx, sdy, sdz;
% for n, s in enumerate(sources):
% if len(sources) > 1:
            ${"else " if n else ""}if (source[7] == ${s.number}.0)
% endif
            emit_${s.stem}(source, u, v, pu, pv, &sx, &sy, &sz, &sdx, &sdy, &sdz);
% endfor
            x = SEL(k, sx, x); y = SEL(k, sy, y); z = SEL(k, sz, z);
            dx = SEL(k, sdx, dx); dy = SEL(k, sdy, dy); dz = SEL(k, sdz, dz);
            w = SEL(k, splat(source[4]), w);
        }
    }
    p->ox = SEL(m, x, p->ox); p->oy = SEL(m, y, p->oy); p->oz = SEL(m, z, p->oz);
    p->dx = SEL(m, dx, p->dx); p->dy = SEL(m, dy, p->dy); p->dz = SEL(m, dz, p->dz);
    p->w = SEL(m, w, p->w);
    p->left = SEL(m, lsplat(NO_FACE), p->left);
% if "contact" in effects:
% for n in range(note_words):
    p->note${n} = SEL(m, lsplat(NO_FACE), p->note${n});
% endfor
    p->came_x = SEL(m, splat(0.0), p->came_x);
    p->came_y = SEL(m, splat(0.0), p->came_y);
    p->came_z = SEL(m, splat(0.0), p->came_z);
% endif
    p->ray_lo = SELW(m, lo, p->ray_lo);
    p->ray_hi = SELW(m, hi, p->ray_hi);
    p->generation = SELW(m, born, p->generation);
% if "splitting" in effects:
    p->path = SEL(m, root, p->path);
% endif
% if "shares" in effects and "roulette" in effects:
    p->launched = SEL(m, w, p->launched);
% endif
    p->alive |= m;
}
