/**
 * @file  control/numeric/lagrange.h
 * @brief Lagrange interpolation: z^-F as a sum of whole delays.
 *
 *     z^-F ~ sum_k A_k z^-k,   A_k = prod_{i != k} (F - i) / (k - i),   k, i = 0..n                      (1)
 *
 * Source   Guo et al. 2024 (Actuators 13, 73), equations 15 and 16. The coefficients sum to 1 for every F.
 * Total    F outside [0, n] is cut to it, NaN counts as 0; an order above 3 counts as 3.
 * Cost     order 1: none, 2: 5 products, 3: 10 products; no division.
 *          Error of a coefficient below 2.5e-7 (float), three steps (fixed).
 */
#ifndef CONTROL_NUMERIC_LAGRANGE_H
#define CONTROL_NUMERIC_LAGRANGE_H

#include "control/numeric/num.h"

#define CTL_LAGRANGE_TAPS 4U

/** Lagrange coefficients, (1) of this header, for order n in [0, 3]; those above the order are zero.
 *  @param f fraction F in samples, [0, n]. */
void ctl_lagrange(uint16_t order, num_t f, num_t a[CTL_LAGRANGE_TAPS]);

/** Lagrange coefficients of order 2, without checks, for f within [0, 2]; a[3] is not written. */
static inline void ctl_lagrange_2_unchecked(num_t f, num_t a[CTL_LAGRANGE_TAPS])
{
    const num_t f1 = num_sub(f, NUM_C(1.0f));
    const num_t f2 = num_sub(f, NUM_C(2.0f));
    const num_t half0 = num_mul(f, NUM_C(0.5f));
    a[0] = num_mul(num_mul(f1, f2), NUM_C(0.5f));
    a[1] = num_neg(num_mul(f, f2));
    a[2] = num_mul(half0, f1);
}

#endif
