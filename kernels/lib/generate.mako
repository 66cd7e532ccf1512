## sources: the source kinds in use, each with .suffix, .number and .draws_position; ray_fields
// Fresh rays into the lanes set in m: ray i of the batch in slot `slot`.
// reads: source table, draws DECIDE_DIRECTION and (sources that draw one) DECIDE_POSITION.
// writes: every field of the packet's lanes in m.
FN void generate(const launch_t *launch, const scene_t *scene, ulong slot, lint i, mask m, packet_t *p) {
    const luint number = AS_LUINT(i) + (launch->ray_base + slot * launch->rays_per_batch);
    const word lo = TO_WORD(number), hi = TO_WORD(number >> 32);
    const word born = wsplat(0u);
    const luint root = (luint)(1UL);
    real x = splat(0.0), y = splat(0.0), z = splat(0.0), dx = x, dy = x, dz = x;
    weight w = weight_splat(1.0);
    real u, v, pu = splat(0.0), pv = splat(0.0);
    draw_pair(launch->seed, lo, hi, root, born, DECIDE_DIRECTION, &u, &v);
% if any(s.draws_position for s in sources):
    draw_pair(launch->seed, lo, hi, root, born, DECIDE_POSITION, &pu, &pv);
% endif
    const wide ri = TO_WIDE(i);
    for (ulong s = 0; s < launch->n_sources; s++) {
        __global const double *source = scene->sources + s * SOURCE_STRIDE;
        const mask k = IGE(ri, (wide)(source[SOURCE_FIRST_RAY])) & ILT(ri, (wide)(source[SOURCE_END_RAY]));
        if (ANY(k & m)) {
            real sx, sy, sz, sdx, sdy, sdz;
% for n, s in enumerate(sources):
% if len(sources) > 1:
            ${"else " if n else ""}if (source[SOURCE_KIND] == ${s.number}.0)
% endif
            emit_${s.suffix}(source, u, v, pu, pv, &sx, &sy, &sz, &sdx, &sdy, &sdz);
% endfor
            x = SEL(k, sx, x); y = SEL(k, sy, y); z = SEL(k, sz, z);
            dx = SEL(k, sdx, dx); dy = SEL(k, sdy, dy); dz = SEL(k, sdz, dz);
            w = SEL_WEIGHT(k, ${point("generate.weight", "weight_splat(source[SOURCE_WEIGHT])")}, w);
        }
    }
% for field in ray_fields:
    p->${field.name} = ${{"real": "SEL", "weight": "SEL_WEIGHT", "word": "SELW"}.get(field.type, "SELI")}(m, ${field.start}, p->${field.name});
% endfor
    p->alive |= m;
}
