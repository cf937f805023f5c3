/* I2t: any square of a current, NaN included, from any heat up to that of the largest load. That a step does not leave this range is a
 * relation between load and heat, of which Eva knows nothing: the unit test holds it. */
#include "tests/prove/any.h"

#include "control/motor/thermal.h"

void prove(void)
{
    const ctl_thermal_params_t p = {any_float(), any_u32() & 0x7FFFFFFFU};
    ctl_heat_t                 heat = ((ctl_heat_t)(any_u32() & 0x3FFFFFFFU) << 32) + any_u32();
    const float                before = ctl_thermal_heat(heat);
    ctl_thermal_step(&p, &heat, any_float());
    const float allowed = ctl_thermal_allowed(before, 60.0f);
    /*@ check heat_of_the_range_is_a_number: 0.0 <= before <= 64.0; */
    /*@ check what_is_allowed_is_bounded: 0.0 <= allowed <= 60.0; */
}
