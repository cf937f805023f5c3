/* Compensation of the dead time: any current. */
#include "tests/prove/any.h"

#include "control/motor/dead_time.c"
#include "control/motor/frames.c"

void prove(void)
{
    const ctl_dq_t    i = {any_num(), any_num()};
    const ctl_rotor_t rotor = {any_num_within(NUM_C(-1.0f), NUM_C(1.0f)), any_num_within(NUM_C(-1.0f), NUM_C(1.0f))};
    ctl_dq_t          v;
    (void)ctl_dead_time(&i, &rotor, NUM_C(2.0f), any_num_within((num_t)0, NUM_MAX), &v);
    /*@ check the_voltage_is_bounded: number(v.d) && number(v.q) && -NUM_C(12.0f) <= v.d <= NUM_C(12.0f) && -NUM_C(12.0f) <= v.q <= NUM_C(12.0f); */
}
