#include "control/numeric/lagrange.h"

void ctl_lagrange(uint16_t order, num_t f, num_t a[CTL_LAGRANGE_TAPS])
{
    const uint16_t n = (order < CTL_LAGRANGE_TAPS) ? order : (uint16_t)(CTL_LAGRANGE_TAPS - 1U);
    const num_t    f0 = (f > (num_t)0) ? num_min(f, num_from_int((int16_t)n)) : (num_t)0; /* NaN compares false */
    const num_t    f1 = num_sub(f0, NUM_C(1.0f));
    const num_t    f2 = num_sub(f0, NUM_C(2.0f));
    const num_t    f3 = num_sub(f0, NUM_C(3.0f));

    a[0] = NUM_C(1.0f);
    a[1] = (num_t)0;
    a[2] = (num_t)0;
    a[3] = (num_t)0;
    if (n == 1U) {
        a[0] = num_neg(f1);
        a[1] = f0;
    } else if (n == 2U) {
        ctl_lagrange_2_unchecked(f0, a);
    } else if (n == 3U) {
        const num_t f01 = num_mul(f0, f1);
        const num_t f23 = num_mul(f2, f3);
        a[0] = num_mul(num_mul(f1, f23), NUM_C(-0.16666667f));
        a[1] = num_mul(num_mul(f0, f23), NUM_C(0.5f));
        a[2] = num_mul(num_mul(f01, f3), NUM_C(-0.5f));
        a[3] = num_mul(num_mul(f01, f2), NUM_C(0.16666667f));
    } else {
        /* order 0: a plain whole delay */
    }
}
