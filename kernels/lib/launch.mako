## launch_struct, item_struct (text of structures)
// What one launch is told, and the state of a work-item between launches; of every program.

${launch_struct}
${item_struct}

// Integers of a tally's cell: the three pieces of an exact sum (limbs.mako), and a count.
#define CELL 4

FN launch_t open_launch(__global const launch_t *launch) {
    return *launch;
}
