/* The angle grid, whole walks: write_up and write_down write as many cells as they were given, for every count and place in 9 cells.
 * eva: -eva-precision 2 -eva-slevel 500 -eva-auto-loop-unroll 100 */
#include "tests/prove/any.h"

#include "control/memory/angle_grid.c"

#define CELLS 9U

void prove(void)
{
    static num_t memory[CELLS];
    for (uint16_t count = 0U; count <= CELLS; count++) {
        for (uint16_t first = 0U; (first + count) <= CELLS; first++) {
            (void)write_up(&memory[first], count, any_num_within(NUM_C(-2.0f), NUM_C(2.0f)),
                           any_num_within(NUM_C(-2.0f), NUM_C(2.0f)));
            (void)write_down(&memory[first + count], count, any_num_within(NUM_C(-2.0f), NUM_C(2.0f)),
                             any_num_within(NUM_C(-2.0f), NUM_C(2.0f)));
        }
    }
}
