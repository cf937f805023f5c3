/* What saturation leaves of an inductance: any currents. */
#include "tests/prove/any.h"

#include "control/motor/saturation.c"

void prove(void)
{
    const ctl_saturation_params_t p = {any_num_within((num_t)0, NUM_MAX), any_num_within((num_t)0, NUM_C(1.0f))};
    const ctl_dq_t                i = {any_num(), any_num()};
    ctl_dq_t                      share;
    (void)ctl_saturation(&p, &i, &share);
    /*@ check the_share_is_bounded: number(share.d) && number(share.q) && NUM_C(0.1f) <= share.d <= NUM_C(1.0f) && NUM_C(0.1f) <= share.q <= NUM_C(1.0f); */
}
