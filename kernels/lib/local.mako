## cls: the element class; rendered once a class
// The ray in the element's own frame (u, v, axis), and back.  The matrix of an axis frame holds only
// zeros and ones, which makes every product and sum exact.
typedef struct { real x, y, z, dx, dy, dz; } local_${cls.suffix};

FN local_${cls.suffix} to_local_${cls.suffix}(__global const double *row, const packet_t *p) {
    local_${cls.suffix} r;
    const real vx = p->ox - R(row[ROW_X]), vy = p->oy - R(row[ROW_Y]), vz = p->oz - R(row[ROW_Z]);
    __global const double *f = row + ROW_FRAME;
    r.x = dot3(vx, vy, vz, splat(f[0]), splat(f[1]), splat(f[2]));
    r.y = dot3(vx, vy, vz, splat(f[3]), splat(f[4]), splat(f[5]));
    r.z = dot3(vx, vy, vz, splat(f[6]), splat(f[7]), splat(f[8]));
    r.dx = dot3(p->dx, p->dy, p->dz, splat(f[0]), splat(f[1]), splat(f[2]));
    r.dy = dot3(p->dx, p->dy, p->dz, splat(f[3]), splat(f[4]), splat(f[5]));
    r.dz = dot3(p->dx, p->dy, p->dz, splat(f[6]), splat(f[7]), splat(f[8]));
    return r;
}

// A local vector in world coordinates; one row for all lanes.
FN void turn_${cls.suffix}(__global const double *row, real x, real y, real z, real *wx, real *wy, real *wz) {
    from_frame(row + ROW_FRAME, x, y, z, wx, wy, wz);
}

// A world point in the frames of the lanes' own elements, and a local vector out of them.
FN void gather_local_${cls.suffix}(const scene_t *scene, lint row, real px, real py, real pz,
                               real *x, real *y, real *z) {
    const real vx = px - gather(scene->geometry + ROW_X, row), vy = py - gather(scene->geometry + ROW_Y, row);
    const real vz = pz - gather(scene->geometry + ROW_Z, row);
    __global const double *f = scene->geometry + ROW_FRAME;
    *x = dot3(vx, vy, vz, gather(f, row), gather(f + 1, row), gather(f + 2, row));
    *y = dot3(vx, vy, vz, gather(f + 3, row), gather(f + 4, row), gather(f + 5, row));
    *z = dot3(vx, vy, vz, gather(f + 6, row), gather(f + 7, row), gather(f + 8, row));
}
FN void scatter_local_${cls.suffix}(const scene_t *scene, lint row, real x, real y, real z,
                                real *wx, real *wy, real *wz) {
    __global const double *f = scene->geometry + ROW_FRAME;
    *wx = fma(x, gather(f, row), fma(y, gather(f + 3, row), z * gather(f + 6, row)));
    *wy = fma(x, gather(f + 1, row), fma(y, gather(f + 4, row), z * gather(f + 7, row)));
    *wz = fma(x, gather(f + 2, row), fma(y, gather(f + 5, row), z * gather(f + 8, row)));
}

FN void shape_${cls.suffix}(const scene_t *scene, lint row, lint face, real *x, real *y, real *z,
                        real *nx, real *ny, real *nz);

% if "moves-hits" in cls.traits:
// A hit's height moved off a face that it must not be taken for.
FN real moved_${cls.suffix}(const scene_t *scene, lint row, const packet_t *p, const hit_t *h, real x, real y, real z);
% endif
% if "own-sides" in cls.traits:
// Where the ray came from which side whatever rounding says, and what counts as inside from either side.
FN void sides_${cls.suffix}(const packet_t *p, const hit_t *h, mask m, contact_t *c);
% endif

// The hit point put back onto its face, and the normal, for the lanes in m.
FN void place_${cls.suffix}(const scene_t *scene, const packet_t *p, const hit_t *h, mask m, contact_t *c) {
    if (!ANY(m)) return;
    const lint row = SELI(m, ELEMENT_OF(h->code) * ROW, lsplat(0L));
    real x, y, z, nx, ny, nz, wx, wy, wz;
    gather_local_${cls.suffix}(scene, row, c->x, c->y, c->z, &x, &y, &z);
% if "moves-hits" in cls.traits:
    z = moved_${cls.suffix}(scene, row, p, h, x, y, z);
% endif
    shape_${cls.suffix}(scene, row, FACE_OF(h->code), &x, &y, &z, &nx, &ny, &nz);
    scatter_local_${cls.suffix}(scene, row, x, y, z, &wx, &wy, &wz);
    c->x = SEL(m, wx + gather(scene->geometry + ROW_X, row), c->x);
    c->y = SEL(m, wy + gather(scene->geometry + ROW_Y, row), c->y);
    c->z = SEL(m, wz + gather(scene->geometry + ROW_Z, row), c->z);
    scatter_local_${cls.suffix}(scene, row, nx, ny, nz, &wx, &wy, &wz);
    c->nx = SEL(m, wx, c->nx); c->ny = SEL(m, wy, c->ny); c->nz = SEL(m, wz, c->nz);
% if "own-sides" in cls.traits:
    sides_${cls.suffix}(p, h, m, c);
% else:
    // a ray inside ends on the inside, whatever the rounding of d.n says
    c->from_minus |= m & IEQ(WITHOUT_FACE(p->left >> 2), WITHOUT_FACE(h->code)) & IEQ(p->left & 2L, lsplat(0L));
% endif
}

// The outward normal at a point on a face, for the lanes in m.
FN void normal_${cls.suffix}(const scene_t *scene, lint code, mask m, real px, real py, real pz,
                         real *nx, real *ny, real *nz) {
    if (!ANY(m)) return;
    const lint row = SELI(m, ELEMENT_OF(code) * ROW, lsplat(0L));
    real x, y, z, lx, ly, lz, wx, wy, wz;
    gather_local_${cls.suffix}(scene, row, px, py, pz, &x, &y, &z);
    shape_${cls.suffix}(scene, row, FACE_OF(code), &x, &y, &z, &lx, &ly, &lz);
    scatter_local_${cls.suffix}(scene, row, lx, ly, lz, &wx, &wy, &wz);
    *nx = SEL(m, wx, *nx); *ny = SEL(m, wy, *ny); *nz = SEL(m, wz, *nz);
}
