/* Torque between two limits of the speed: any input, from any state that it leaves behind, for the limits of two drives.
 * eva: -eva-precision 5 */
#include "tests/prove/any.h"

#include "control/motor/speed_bound.c"

static void with_room(num_t room)
{
    const ctl_speed_bound_params_t p = {any_num_within((num_t)0, NUM_C(100.0f)), any_num_within((num_t)0, NUM_C(10.0f)),
                                        any_num_within((num_t)0, NUM_C(1.0f))};
    ctl_speed_bound_t              s = {(num_t)0, any_u32()};
    while (any_bool()) {
        const num_t out = ctl_speed_bound_step(&p, &s, any_num(), any_num(), any_num(), room);
        const num_t x = s.x;
        /*@ check the_torque_is_within_its_room: number(out) && -room <= out <= room; */
        /*@ check the_integrator_is_within_it_too: number(x) && -room <= x <= room; */
    }
}

void prove(void)
{
    with_room(NUM_C(10.0f));
    with_room(NUM_C(0.25f));
}
