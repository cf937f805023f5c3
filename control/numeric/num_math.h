/**
 * @file  control/numeric/num_math.h
 * @brief Powers and roots without the C library: bounded time, same result on every machine.
 *
 * Source   polynomials are minimax fits on the reduced interval (Lawson iteration on Chebyshev nodes).
 * Cost     num_log2, num_exp2: about 14 operations; num_pow: both and a product; num_sqrt: 4 Newton steps in float,
 *          28 shift-subtract steps in fixed point, one instruction with a TMU. No division, no table, no libm.
 */
#ifndef CONTROL_NUMERIC_NUM_MATH_H
#define CONTROL_NUMERIC_NUM_MATH_H

#include "control/numeric/num.h"
#include "control/numeric/tmu.h"

/**
 * Logarithm to base 2 of x > 0. Absolute error below 2e-7 for results within +-2, else 1.5e-7 of the result (float);
 * 3e-7 (fixed). For x <= 0, NaN or x below the smallest normal number: the logarithm of that smallest number.
 */
num_t num_log2(num_t x);

/**
 * 2^x. Relative error below 3e-7 (float), below four steps times the larger of 1 and the result (fixed). Saturates at
 * NUM_MAX.
 */
num_t num_exp2(num_t x);

/**
 * base^exponent for base > 0. 0 for base <= 0 or NaN, saturates at NUM_MAX.
 * Float: relative error below 2e-6 for base within 1e-9..1e9 and |exponent| <= 1 (the logarithm's error times ln 2).
 * Fixed: below 1e-6 of the larger of 1 and the result, for base from 2^-16 and |exponent| <= 1.
 */
num_t num_pow(num_t base, num_t exponent);

#ifndef EVENSPIN_FIXED
#define NUM_SMALLEST_NORMAL 1.17549435e-38f
#endif

/** Square root; 0 for x <= 0, NaN and what is below the smallest normal number; that of NUM_MAX for larger x.
 *  Relative error below 2e-7 (float), half a step (fixed). */
num_t num_sqrt_portable(num_t x);

/** The same for x from the smallest normal number to NUM_MAX squared; one instruction of the TMU where there is one. */
static inline num_t num_sqrt_raw(num_t x)
{
#ifdef CTL_HAS_TMU
    return tmu_sqrt(x);
#else
    return num_sqrt_portable(x);
#endif
}

/** The same; one instruction of the TMU where there is one. */
static inline num_t num_sqrt(num_t x)
{
#ifdef CTL_HAS_TMU
    return (x > NUM_SMALLEST_NORMAL) ? tmu_sqrt(num_min(x, NUM_MAX)) : 0.0f;
#else
    return num_sqrt_portable(x);
#endif
}

#endif
