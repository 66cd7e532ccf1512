## classes, tree_width, tree_stack
// A tree of boxes over the elements, built on the host (photizon_cl/tree.py), eight children to a
// node.  It stands in the geometry table from codes[n_classes + 1] on, behind the scene's size: per
// node the children's boxes, low x, y, z and high x, y, z of all eight, and the bits of eight links:
// an element's code, or ~node.
//
// One ray is searched for at a time, whatever the lanes: rays that have scattered a few times go
// their own ways, and a packet would visit every node that any of them needs.  The eight boxes of a
// node are the vector instead.
#define TREE_WIDTH ${tree_width}
#define TREE_STACK ${tree_stack}
#define TREE_BOX(scene, node) ((scene)->geometry + (scene)->codes[${len(classes) + 1}] + 7 * TREE_WIDTH * (node))
#define TREE_LINKS(box) ((__global const long *)((box) + 6 * TREE_WIDTH))

// A ray among boxes.  near, far: where in a node the sides stand that it meets first and last.
// enter, leave: its origin moved by a bound of every rounding between the origin and the farthest
// hit, out for the sides it enters by and in for those it leaves by: that makes every box larger
// without touching it.
typedef struct {
    int near_x, near_y, near_z;
    double enter_x, enter_y, enter_z, leave_x, leave_y, leave_z, ix, iy, iz;
} box_ray_t;

FN box_ray_t box_ray(double ox, double oy, double oz, double dx, double dy, double dz, double size) {
    const double room = (fabs(ox) + fabs(oy) + fabs(oz) + size) * 0x1p-42;
    box_ray_t r;
% for n, x in enumerate("xyz"):
    r.i${x} = 1.0 / d${x};
    {
        const int up = !signbit(d${x});
        r.near_${x} = TREE_WIDTH * (up ? ${n} : ${n + 3});
        r.enter_${x} = up ? o${x} + room : o${x} - room;
        r.leave_${x} = up ? o${x} - room : o${x} + room;
    }
% endfor
    return r;
}

// The children of a node that the ray may meet no later than `best`, as one byte a child (0 or 1),
// and where each box is entered.
FN ulong meet_boxes(__global const double *box, const box_ray_t *r, double best, double8 *entered) {
    // 0 * inf (a ray in the plane of a side) is not a number, and each comparison then takes the
    // other: the ray runs at least `room` outside whatever the box holds
    double8 enter = (double8)(0.0), leave = (double8)(best);
% for n, x in enumerate("xyz"):
    {
        const double8 a = (vload8(0, box + r->near_${x}) - r->enter_${x}) * r->i${x};
        const double8 b = (vload8(0, box + (${2 * n + 3} * TREE_WIDTH - r->near_${x})) - r->leave_${x}) * r->i${x};
        enter = a > enter ? a : enter;
        leave = b < leave ? b : leave;
    }
% endfor
    *entered = enter;
    return as_ulong(convert_char8(enter <= leave)) & 0x0101010101010101UL;
}
