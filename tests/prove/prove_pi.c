/* The PI controller from any state: any gains that init accepts, any error (NaN too), any sequence of calls. Eva compares a value with
 * numbers, not with another variable: so the limits are those of five drives, and everything else is free. */
#include "tests/prove/any.h"

#include "control/motor/pi.c"

static void with_limits(num_t low, num_t high)
{
    ctl_pi_t pi = {.params = {any_num_within((num_t)0, NUM_MAX), any_num_within((num_t)0, NUM_MAX), low, high,
                              any_bool() ? CTL_PI_HOLD : CTL_PI_HOLD_OUTWARD}};
    ctl_pi_tune(&pi, &pi.params);
    ctl_pi_reset(&pi, any_num());
    pi.state.rejected = any_u32();
    while (any_bool()) {
        const num_t u = ctl_pi_output(&pi, any_num());
        /*@ check output_within_limits: number(u) && low <= u <= high; */
        if (any_bool()) {
            ctl_pi_commit(&pi, any_num());
        } else if (any_bool()) {
            ctl_pi_hold(&pi);
        } else {
            ctl_pi_reset(&pi, any_num());
        }
        const num_t x = pi.state.x;
        /*@ check integrator_within_bound: number(x) && -pi.bound <= x <= pi.bound; */
    }
}

void prove(void)
{
    with_limits(NUM_C(-24.0f), NUM_C(24.0f));
    with_limits(NUM_C(-0.5f), NUM_C(3.0f));
    with_limits(NUM_C(-7.0f), NUM_C(-1.0f));
    with_limits(NUM_C(0.0f), NUM_C(1.0e-3f));
    with_limits(-NUM_MAX, NUM_MAX);
}
