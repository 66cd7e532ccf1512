## classes
// A binary tree of boxes over the elements, built on the host, in preorder: the low child of node n is
// n + 1.  Per node six numbers in the geometry table (low corner, high corner) and two in codes: for a
// leaf its first element code and their number, for an inner node (high child << 2 | axis) and 0.
// codes[n_classes + 1] and codes[n_classes + 2] say where they stand.
#define TREE_DEPTH 64
#define TREE_BOX(scene, node) ((scene)->geometry + (scene)->codes[${len(classes) + 1}] + 6 * (node))
#define TREE_FIRST(scene, node) ((scene)->codes[(scene)->codes[${len(classes) + 2}] + 2 * (node)])
#define TREE_COUNT(scene, node) ((scene)->codes[(scene)->codes[${len(classes) + 2}] + 2 * (node) + 1])

// Origins moved out for the low and in for the high sides by a bound of every rounding between the
// origin and the farthest hit: that makes every box larger without touching it.
typedef struct { real lx, ly, lz, hx, hy, hz, ix, iy, iz; } box_ray_t;

FN box_ray_t box_ray(const scene_t *scene, const packet_t *p) {
    __global const double *whole = TREE_BOX(scene, 0);
    const double size = fmax(fmax(fmax(fabs(whole[0]), fabs(whole[1])), fmax(fabs(whole[2]), fabs(whole[3]))),
                             fmax(fabs(whole[4]), fabs(whole[5])));
    const real room = (fabs(p->ox) + fabs(p->oy) + fabs(p->oz) + size) * 0x1p-44;
    box_ray_t r;
    r.lx = p->ox + room; r.ly = p->oy + room; r.lz = p->oz + room;
    r.hx = p->ox - room; r.hy = p->oy - room; r.hz = p->oz - room;
    r.ix = 1.0 / p->dx; r.iy = 1.0 / p->dy; r.iz = 1.0 / p->dz;
    return r;
}

// Whether any live lane may meet something in the box before its best hit.
FN int meets_box(const scene_t *scene, const box_ray_t *r, const packet_t *p, real best, long node) {
    __global const double *box = TREE_BOX(scene, node);
    // 0 * inf (a ray in the plane of a side) is not a number, and fmin and fmax then take the other:
    // the ray runs at least `room` outside whatever the box holds
    const real ax = (box[0] - r->lx) * r->ix, bx = (box[3] - r->hx) * r->ix;
    const real ay = (box[1] - r->ly) * r->iy, by = (box[4] - r->hy) * r->iy;
    const real az = (box[2] - r->lz) * r->iz, bz = (box[5] - r->hz) * r->iz;
    const real enter = fmax(fmax(fmin(ax, bx), fmin(ay, by)), fmin(az, bz));
    const real leave = fmin(fmin(fmax(ax, bx), fmax(ay, by)), fmax(az, bz));
    return ANY(p->alive & LE(enter, leave) & GE(leave, splat(0.0)) & LE(enter, best));
}

// Whether most of the packet runs up the axis.  It decides the order of the search, never its outcome.
FN int comes_from_low(const packet_t *p, int axis) {
    const real d = axis == 0 ? p->dx : axis == 1 ? p->dy : p->dz;
    return 2 * count_lanes(p->alive & GT(d, splat(0.0))) >= count_lanes(p->alive);
}
