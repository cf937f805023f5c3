/* M/T speed: any edges and times at all, from any state, for the limits of three drives. */
#include "tests/prove/any.h"

#include "control/motor/mt_speed.c"

static void with_limit(num_t speed_max)
{
    ctl_mt_t mt;
    mt.params.sample_cyc = any_u32();
    if (mt.params.sample_cyc == 0U) {
        mt.params.sample_cyc = 1U;
    }
    mt.params.speed_1_count = any_num_within(NUM_EPS, NUM_MAX);
    mt.params.speed_max = speed_max;
    mt.params.stop_samples = any_u16_within(1U, UINT16_MAX);
    ctl_mt_reset(&mt);
    while (any_bool()) {
        const num_t w = ctl_mt_step(&mt, any_i32(), any_u32(), any_u32());
        /*@ check speed_is_within_its_limit: number(w) && -speed_max <= w <= speed_max; */
    }
}

void prove(void)
{
    with_limit(NUM_C(1.0f));
    with_limit(NUM_C(100.0f));
    with_limit(NUM_MAX);
}
