/* Lagrange coefficients: any order, any fraction.
 * eva: -eva-precision 3 */
#include "tests/prove/any.h"

#include "control/numeric/lagrange.c"

void prove(void)
{
    num_t a[CTL_LAGRANGE_TAPS];
    ctl_lagrange(any_u16(), any_num_within(-NUM_MAX, NUM_MAX), a);
    const num_t a0 = a[0], a1 = a[1], a2 = a[2], a3 = a[3];
    /*@ check coefficients_are_bounded: number(a0) && number(a1) && number(a2) && number(a3) && -NUM_C(16.0f) <= a0 <= NUM_C(16.0f)
          && -NUM_C(16.0f) <= a1 <= NUM_C(16.0f) && -NUM_C(16.0f) <= a2 <= NUM_C(16.0f) && -NUM_C(16.0f) <= a3 <= NUM_C(16.0f); */
}
