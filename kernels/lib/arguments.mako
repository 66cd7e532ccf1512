## ray_fields
// The stages' common arguments, and what each work-item makes of them.
#define SCENE_ARGUMENTS __global const launch_t *launch_buffer, __global const double *geometry, __global const double *materials, __global const double *sources, __global const long *codes, __global long *tally
#define QUEUE_ARGUMENTS __global item_t *items, __global long *status, __global double *queue_reals, __global uint *queue_words, __global long *queue_longs
#define RECORD_ARGUMENTS __global double *record_reals, __global uint *record_words

FN scene_t open_scene(__global const double *geometry, __global const double *materials,
                      __global const double *sources, __global const long *codes) {
    const scene_t s = {geometry, materials, sources, codes};
    return s;
}
FN void clear_packet(packet_t *p) {
% for field in ray_fields:
    p->${field.name} = ${field.cleared};
% endfor
    p->alive = NO_LANES;
}
