/* The angle grid, walk: from any angle to any other, values within +-2, sizes of the list: every point is inside. */
#include "tests/prove/any.h"

#include "control/memory/angle_grid.c"

static void walk_on(uint16_t cells, num_t *memory)
{
    const ctl_grid_t grid = {memory, cells, (float)cells};
    ctl_grid_walk_t  walk = ctl_grid_walk(&grid, any_u32(), any_num_within(NUM_C(-2.0f), NUM_C(2.0f)), any_u32(),
                                          any_num_within(NUM_C(-2.0f), NUM_C(2.0f)));
    uint16_t         index = 0U;
    num_t            value = (num_t)0;
    while (ctl_grid_walk_next(&walk, &index, &value)) {
        /*@ check a_visited_point_is_inside: index < cells; */
        memory[index] = value;
    }
}

void prove(void)
{
    static num_t memory[48];
    walk_on(4U, memory);
    walk_on(16U, memory);
    walk_on(48U, memory);
}
