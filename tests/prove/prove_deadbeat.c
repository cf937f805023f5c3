/* The deadbeat current controller: any input, parameters within init's ranges, any number of samples; limits of three drives. */
#include "tests/prove/any.h"

#include "control/motor/deadbeat.c"

static void with_limits(num_t v_max, num_t c_max)
{
    ctl_deadbeat_t self;
    self.params.r = any_num_within((num_t)0, NUM_MAX);
    self.params.ld_ts = any_num_within(NUM_EPS, NUM_MAX);
    self.params.lq_ts = any_num_within(NUM_EPS, NUM_MAX);
    self.params.ts_ld = any_num_within(NUM_EPS, NUM_MAX);
    self.params.ts_lq = any_num_within(NUM_EPS, NUM_MAX);
    self.params.w_ld = any_num_within((num_t)0, NUM_MAX);
    self.params.w_lq = any_num_within((num_t)0, NUM_MAX);
    self.params.w_psi = any_num_within((num_t)0, NUM_MAX);
    self.params.correction = any_num_within((num_t)0, NUM_C(0.5f));
    self.params.c_max = c_max;
    self.params.v_max = v_max;
    self.state.rejected = any_u32();
    ctl_deadbeat_reset(&self.state);
    while (any_bool()) {
        const ctl_dq_t meas = {any_num(), any_num()};
        const ctl_dq_t ref = {any_num(), any_num()};
        const ctl_dq_t last = {any_num(), any_num()};
        const ctl_dq_t v = ctl_deadbeat_step(&self, &meas, &ref, any_num(), &last);
        /*@ check voltages_are_within_the_limit: number(v.d) && number(v.q) && -v_max <= v.d <= v_max && -v_max <= v.q <= v_max; */
        const ctl_dq_t c = self.state.c;
        /*@ check the_correction_is_bounded: number(c.d) && number(c.q) && -c_max <= c.d <= c_max && -c_max <= c.q <= c_max; */
    }
}

void prove(void)
{
    with_limits(NUM_C(24.0f), NUM_C(2.0f));
    with_limits(NUM_C(1.0f), NUM_C(0.01f));
    with_limits(NUM_MAX, NUM_MAX);
}
