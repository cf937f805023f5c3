/* Torque lines over the angle: every position, any lines that init accepts.
 * eva: -eva-precision 3 */
#include "tests/prove/any.h"

#include "control/numeric/angle.c"
#include "control/position/harmonics.c"

void prove(void)
{
    (void)ctl_cycles_q20(Frama_C_float_interval(-1.0e30f, 1.0e30f)); /* NaN: tests/control */
    ctl_harmonics_t p;
    p.lines = any_u16_within(0U, CTL_HARMONICS_MAX);
    for (uint16_t k = 0U; k < CTL_HARMONICS_MAX; k++) {
        p.line[k].cycles_q20 = any_u32();
        p.line[k].amplitude = any_num_within(NUM_C(-10.0f), NUM_C(10.0f));
        p.line[k].phase = any_u32();
    }
    const ctl_position_t position = (ctl_position_t)(((uint64_t)any_u32() << 32) | any_u32());
    const num_t          torque = ctl_harmonics(&p, position);
    /*@ check the_torque_is_a_number: number(torque); */
}
