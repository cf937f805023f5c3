/* The gain fal as init prepares it, for the exponents and widths of the list: any error below the largest number.
 * eva: -eva-precision 3 */
#include "tests/prove/any.h"

#include "control/numeric/num_math.c"
#include "control/repetitive/fal.c"

static void of(num_t alpha, num_t delta)
{
    ctl_fal_t fal = {.params = {alpha, delta}, .slope = any_num_within((num_t)0, NUM_C(100.0f))};
    prepare(&fal);
    const num_t y = ctl_fal(&fal, any_num_within(-NUM_MAX, NUM_MAX));
    /*@ check fal_is_a_number: number(y); */
    const num_t gain = ctl_fal_lambda(&fal, any_num_within(-NUM_MAX, NUM_MAX));
    /*@ check the_gain_is_a_number: number(gain); */
}

void prove(void)
{
    of(NUM_C(0.6f), NUM_C(0.4f));
    of(NUM_C(1.0f), NUM_C(0.01f));
    of(NUM_C(0.1f), NUM_C(2.0f));
}
