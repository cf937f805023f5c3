/* Plausibility of currents, voltages and angle: any input, any parameters within init's ranges, any number of samples. */
#include "tests/prove/any.h"

#include "control/motor/plausibility.c"

static num_t positive(void) { return any_num_within(NUM_EPS, NUM_MAX); }

void prove(void)
{
    const ctl_plausibility_params_t p = {positive(), positive(), positive(), positive(), positive(), positive(),
                                         positive(), positive(), positive(), positive(), positive(), positive()};
    ctl_plausibility_t              self = {.params = p}; /* Eva does not see that init accepts these parameters */
    (void)ctl_plausibility_init(&self, &p);
    self.params = p;
    while (any_bool()) {
        const ctl_plausibility_in_t in = {
            {any_num(), any_num()}, {any_num(), any_num()}, any_num(), any_num(), {any_num(), any_num()}};
        (void)ctl_plausibility_step(&self, &in);
        /*@ check a_wait_ends: self.state.skip <= CTL_PLAUSIBILITY_SKIP; */
    }
}
