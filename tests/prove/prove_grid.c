/* The angle grid, read-out: every angle, cells of any value within +-2, sizes of the list.
 * eva: -eva-precision 6 -eva-slevel 3000 -eva-auto-loop-unroll 300 */
#include "tests/prove/any.h"

#include "control/memory/angle_grid.c"
#include "control/numeric/lagrange.c"

static void grid_of(uint16_t cells, num_t *memory)
{
    const ctl_grid_t grid = {memory, cells, (float)cells};
    for (uint16_t i = 0U; i < cells; i++) {
        memory[i] = any_num_within(NUM_C(-2.0f), NUM_C(2.0f));
    }
    const num_t straight = ctl_grid_read_linear(&grid, any_u32());
    /*@ check linear_is_bounded: number(straight) && -NUM_C(8.0f) <= straight <= NUM_C(8.0f); */
    for (uint16_t k = 0U; k < cells; k++) {
        const angle_t angle = (angle_t)(((uint64_t)k << 32) / cells) + (angle_t)(any_u32() / cells);
        const num_t   cubic = ctl_grid_read_cubic(&grid, angle);
        /*@ check cubic_is_bounded: number(cubic) && -NUM_C(64.0f) <= cubic <= NUM_C(64.0f); */
    }
}

void prove(void)
{
    static num_t memory[48];
    grid_of(4U, memory);
    grid_of(16U, memory);
    grid_of(48U, memory);
}
