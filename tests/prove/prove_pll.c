/* The tracking filter: every angle, gains of init's ranges, for the limits of three drives. */
#include "tests/prove/any.h"

#include "control/motor/pll.c"

static void with_limit(num_t speed_max, num_t rad_per_speed_ts)
{
    ctl_pll_t pll = {{any_num_within(NUM_EPS, NUM_C(1.0f)), any_num_within(NUM_EPS, NUM_MAX), rad_per_speed_ts, speed_max},
                     {0U, (num_t)0, (num_t)0}};
    ctl_pll_reset(&pll, any_u32());
    while (any_bool()) {
        const num_t w = ctl_pll_step(&pll, any_u32());
        const num_t e = pll.state.error;
        /*@ check speed_is_within_its_limit: number(w) && -speed_max <= w <= speed_max; */
        /*@ check error_is_within_half_a_turn: number(e) && -NUM_C(3.1416f) <= e <= NUM_C(3.1416f); */
    }
}

void prove(void)
{
    with_limit(NUM_C(1.0f), NUM_C(0.1f));
    with_limit(NUM_C(100.0f), NUM_C(0.03f));
    with_limit(NUM_C(2.0f), NUM_EPS);
}
