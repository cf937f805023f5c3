/* Roots, powers and logarithms: any operand within +-NUM_MAX gives a number.
 * eva: -eva-precision 3 -eva-min-loop-unroll 6 */
#include "tests/prove/any.h"

#include "control/numeric/num_math.c"

void prove(void)
{
    const num_t root = num_sqrt_portable(any_num_within(-NUM_MAX, NUM_MAX));
    /*@ check a_root_is_a_number: number(root); */
    const num_t power = num_exp2(any_num_within(-NUM_MAX, NUM_MAX));
    /*@ check a_power_is_a_number: number(power); */
    const num_t logarithm = num_log2(any_num_within(-NUM_MAX, NUM_MAX));
    /*@ check a_logarithm_is_a_number: number(logarithm); */
}
