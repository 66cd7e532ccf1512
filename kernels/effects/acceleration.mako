## tree_node, tree_width, tree_stack
// A tree of boxes over the elements, built on the host (photizon_cl/tree.py), eight children to a
// node (photizon_cl/tree_nodes.py).  It stands in the geometry table behind the scene's size.  The
// boxes of a node stand on a grid of its own: its low corner, its steps, then in bytes the children's
// low x, y, z and high x, y, z, eight each; at last eight links: an element's number, or ~node.
//
// One ray is searched for at a time, whatever the lanes: rays that have scattered a few times go
// their own ways, and a packet would visit every node that any of them needs.  The eight boxes of a
// node are the vector instead.
#define TREE_WIDTH ${tree_width}
#define TREE_STACK ${tree_stack}
#define TREE_GRID(node) ((__global const ulong *)((node) + 6))
#define TREE_LINKS(node) ((__global const int *)((node) + ${tree_node - tree_width // 2}))
#define FIRST_BYTE(bits) ((63 - (int)clz((bits) & (0UL - (bits)))) >> 3)
// Instead of 1/0.  0 * inf is not a number, with which every box would count as met.
#define STEEPEST 0x1p500

// A ray among boxes.  near: which of a node's six sides along each axis it meets first.  i: 1/d.
// enter, leave: its origin, moved by a bound of every rounding between the origin and the farthest
// hit, out for the sides it enters by and in for those it leaves by, times -i: that makes every box
// larger without touching it.
typedef struct {
    int near_x, near_y, near_z;
    double enter_x, enter_y, enter_z, leave_x, leave_y, leave_z, ix, iy, iz;
} box_ray_t;

FN box_ray_t box_ray(double ox, double oy, double oz, double dx, double dy, double dz, double size) {
    const double room = (fabs(ox) + fabs(oy) + fabs(oz) + size) * 0x1p-42;
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
