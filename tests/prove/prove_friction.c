/* Friction over speed: any parameters within init's ranges, any speed.
 * eva: -eva-precision 1 -eva-min-loop-unroll 6 */
#include "tests/prove/any.h"

#include "control/numeric/num_math.c"
#include "control/position/friction.c"

void prove(void)
{
    const ctl_friction_t p = {any_num_within((num_t)0, NUM_MAX), any_num_within((num_t)0, NUM_MAX),
                              any_num_within((num_t)0, NUM_MAX), any_num_within(NUM_EPS, NUM_MAX),
                              any_num_within(NUM_C(0.1f), NUM_C(10.0f))};
    const num_t          torque = ctl_friction(&p, any_num());
    /*@ check the_torque_is_a_number: number(torque); */
}
