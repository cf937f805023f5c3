/* Periodic function of an angle: every angle, sizes up to those of a turn. The turn comes in 16 parts, so that Eva knows the quadrant. */
#include "tests/prove/any.h"

#include "control/motor/fourier.c"
#include "control/numeric/angle.c"

static num_t size(void) { return any_num_within(NUM_C(-6.3f), NUM_C(6.3f)); }

void prove(void)
{
    const ctl_fourier_t p = {size(), size(), size(), size()};
    for (uint16_t k = 0U; k < 16U; k++) {
        num_t       slope;
        const num_t value = ctl_fourier(&p, ((angle_t)k * 0x10000000U) + (any_u32() & 0x0FFFFFFFU), &slope);
        /*@ check the_value_is_bounded: number(value) && -NUM_C(32.0f) <= value <= NUM_C(32.0f); */
        /*@ check the_slope_is_bounded: number(slope) && -NUM_C(64.0f) <= slope <= NUM_C(64.0f); */
    }
}
