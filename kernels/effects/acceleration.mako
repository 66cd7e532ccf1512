## tree_node (doubles of a node), tree_width (its children), tree_stack; packets; cached_bytes, cache_line
<%
    # what stays in the cache: a row's first line, and the two of a node; nodes stand level by level
    warm_elements = cached_bytes // cache_line
    warm_nodes = cached_bytes // (4 * 8 * counts["tree_node"])
%>
// A tree of boxes over the elements, built on the host (photizon_cl/geometry/tree.py), eight children to a
// node (photizon_cl/compile/tree_nodes.py).  It stands in the geometry table behind the scene's size.  The
// boxes of a node stand on a grid of its own: its low corner, its steps, then in bytes the children's
// low x, y, z and high x, y, z, eight each; at last eight links: an element's number, or ~node.
//
// A ray is searched for by itself: rays that have scattered a few times go their own ways, and a
// packet would visit every node that any of them needs.  The eight boxes of a node are the vector
// instead, and a packet has one lane.  A work-item keeps several packets and takes them in turn: among
// many elements the lower nodes and the rows are not in the cache, and while one ray's are fetched the
// others go on.
#define TREE_WIDTH ${counts["tree_width"]}
#define TREE_STACK ${counts["tree_stack"]}
#define TREE_GRID(node) ((__global const ulong *)((node) + 6))
#define TREE_LINKS(node) ((__global const int *)((node) + ${counts["tree_node"] - counts["tree_width"] // 2}))
#define FIRST_BYTE(bits) ((63 - (int)clz((bits) & (0UL - (bits)))) >> 3)
// Instead of 1/0.  0 * inf is not a number, with which every box would count as met.
#define STEEPEST 0x1p500

#define NOTHING INT_MIN
% if packets == 1:
#define FIRST_PACKET(bits) 0u
% else:
#define FIRST_PACKET(bits) FIRST_LANE(bits)
% endif

// A ray among boxes.  near: which of a node's six sides along each axis it meets first.  i: 1/d.
// enter, leave: its origin, moved by a bound of every rounding between the origin and the farthest
// hit, out for the sides it enters by and in for those it leaves by, times -i: that makes every box
// larger without touching it.
typedef struct {
    int near_x, near_y, near_z;
    double enter_x, enter_y, enter_z, leave_x, leave_y, leave_z, ix, iy, iz;
} box_ray_t;

FN box_ray_t box_ray(double ox, double oy, double oz, double dx, double dy, double dz, double size) {
    const double room = (fabs(ox) + fabs(oy) + fabs(oz) + size) * (0x1p11 * UNIT_ROUNDOFF);
    box_ray_t r;
% for n, x in enumerate("xyz"):
    {
        const double i = clamp(1.0 / d${x}, -STEEPEST, STEEPEST);
        const double margin = copysign(room, i);
        r.i${x} = i;
        r.near_${x} = signbit(i) ? ${n + 3} : ${n};
        r.enter_${x} = -(o${x} + margin) * i;
        r.leave_${x} = -(o${x} - margin) * i;
    }
% endfor
    return r;
}

// The children of a node that the ray may meet no later than `best`, as one byte a child (0 or 1),
// and where each box is entered.
FN ulong meet_boxes(__global const double *node, const box_ray_t *r, double best, double8 *entered) {
    __global const ulong *grid = TREE_GRID(node);
    double8 enter = (double8)(0.0), leave = (double8)(best);
% for n, x in enumerate("xyz"):
    {
        const double8 corner = (double8)(node[${n}]), step = (double8)(node[${n + 3}]), i = (double8)(r->i${x});
        // as a whole word: PoCL loads eight bytes one by one
        const double8 near = fma(convert_double8(as_uchar8(grid[r->near_${x}])), step, corner);
        const double8 far = fma(convert_double8(as_uchar8(grid[${2 * n + 3} - r->near_${x}])), step, corner);
        const double8 a = fma(near, i, (double8)(r->enter_${x})), b = fma(far, i, (double8)(r->leave_${x}));
        enter = a > enter ? a : enter;
        leave = b < leave ? b : leave;
    }
% endfor
    *entered = enter;
    return as_ulong(convert_char8(enter <= leave)) & 0x0101010101010101UL;
}

// One ray's way through the tree.  link: what it meets next; from `waits` down, what waits, and where
// the box of each is entered.  departed: a flat element that it leaves, and so does not hit: its row
// stays unread.
typedef struct {
    box_ray_t ray;
    int link, departed;
    uint waits;
    double entered[TREE_STACK];
    int waiting[TREE_STACK];
} walk_t;

// Gives the nearest child of a node that the ray may meet, or NOTHING.  The others wait, the nearest
// last, to be taken next.
FN int descend(__global const double *node, const box_ray_t *ray, double best, walk_t *walk) {
    __global const int *links = TREE_LINKS(node);
    union { double8 v; double s[TREE_WIDTH]; } at;
    ulong met = meet_boxes(node, ray, best, &at.v);
    if (!met) return NOTHING;
    int k = FIRST_BYTE(met);
    int nearest = links[k];
    met &= met - 1UL;
    if (!met) return nearest;
    double begins = at.s[k];
    const uint first = walk->waits;
    uint n = first;
    for (; met; met &= met - 1UL) {
        k = FIRST_BYTE(met);
        double later = at.s[k];
        int other = links[k];
        if (later < begins) {
            const double d = begins; begins = later; later = d;
            const int nearer = other; other = nearest; nearest = nearer;
        }
        uint i = n++;
        for (; i > first && walk->entered[i - 1] < later; i--) {
            walk->entered[i] = walk->entered[i - 1];
            walk->waiting[i] = walk->waiting[i - 1];
        }
        walk->entered[i] = later;
        walk->waiting[i] = other;
    }
    walk->waits = n;
    return nearest;
}

// What waited last and may be met no later than `best`, or NOTHING.
FN int next_waiting(walk_t *walk, double best) {
    while (walk->waits) {
        const uint n = --walk->waits;
        if (walk->entered[n] <= best) return walk->waiting[n];
    }
    return NOTHING;
}

// Through the tree with the rays set in `wanted`: only elements whose box a ray may meet no later than
// its best hit so far are asked, by the very functions of the plain scan.  Boxes are taken too large
// by more than any rounding, so the outcome has the same bits.
FN void search_tree(const scene_t *scene, const packet_t *packets, uint wanted, search_t *searches, hit_t *hits) {
    __global const double *tree = scene->geometry + TREE_PLACE(scene);
    walk_t walks[PACKETS];
    for (uint rest = wanted; rest; rest &= rest - 1u) {
        const packet_t *p = packets + FIRST_PACKET(rest);
        walk_t *walk = walks + FIRST_PACKET(rest);
        walk->ray = box_ray(p->ox, p->oy, p->oz, p->dx, p->dy, p->dz, tree[-1]);
        const long left = p->left >> 2, from = CLASS_OF(left);
        walk->departed = ${" || ".join(f"from == {cls.number}L" for cls in classes if cls.flat) or "false"} ? (int)ELEMENT_OF(left) : -1;
        walk->waits = 0;
        walk->link = ~0;
    }
% if packets > 1:
    // nodes stand level by level: the first stay in the cache, as do the rows of few elements
    const bool warm_rows = TREE_PLACE(scene) < ${warm_elements}L * ROW;
% endif
    while (wanted) {
        for (uint rest = wanted; rest; rest &= rest - 1u) {
            const uint l = FIRST_PACKET(rest);
            const packet_t *p = packets + l;
            walk_t *walk = walks + l;
            search_t *search = searches + l;
            hit_t *h = hits + l;
            const box_ray_t ray = ${point("acceleration.ray", "walk->ray")};
            const lint left = p->left >> 2;
            int link = walk->link;
            do {
                if (link < 0) {
                    link = descend(tree + (long)~link * ${counts["tree_node"]}, &ray, h->t, walk);
                } else {
                    if (link != walk->departed) {
                        __global const double *row = scene->geometry + (long)link * ROW;
                        const long code = CODE_AT(scene, link);
                        switch ((int)CLASS_OF(code)) {
% for cls in classes:
                        case ${cls.number}: meet_${cls.suffix}(scene, row, code, p, left, search, h); break;
% endfor
                        }
                    }
                    link = NOTHING;
                }
                if (link == NOTHING) link = next_waiting(walk, h->t);
% if packets > 1:
            } while (link != NOTHING && (link < 0 ? ~link < ${warm_nodes} : warm_rows));
            walk->link = link;
            if (link == NOTHING) {
                wanted &= ~(1u << l);
            } else if (link < 0) {
                FETCH(tree + (long)~link * ${counts["tree_node"]});
                FETCH(tree + (long)~link * ${counts["tree_node"]} + ${counts["tree_node"] // 2});
            } else {
                FETCH(scene->geometry + (long)link * ROW);
                FETCH(&CODE_ENTRY(scene, link));
            }
% else:
            } while (link != NOTHING);
            wanted = 0u;
% endif
        }
    }
}
