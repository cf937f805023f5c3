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

#ifndef EVENSPIN_FIXED
/** num_sqrt_portable for x from the smallest normal number to the largest there is. */
num_t num_sqrt_newton(num_t x);
#endif

/** Square root without checks, for x from the smallest normal number to NUM_MAX squared; one instruction of the TMU where there
 *  is one. */
static inline num_t num_sqrt_unchecked(num_t x)
{
#ifdef CTL_HAS_TMU
    return tmu_sqrt(x);
#elif defined(EVENSPIN_FIXED)
    return num_sqrt_portable(x);
#else
    return num_sqrt_newton(x);
#endif
}

/** Square root of any x, as num_sqrt_portable; one instruction of the TMU where there is one. */
static inline num_t num_sqrt(num_t x)
{
#ifdef CTL_HAS_TMU
    return (x > NUM_SMALLEST_NORMAL) ? tmu_sqrt(num_min(x, NUM_MAX)) : 0.0f;
#else
    return num_sqrt_portable(x);
#endif
}

/* log2(1 + u) = u P(u), u within [sqrt(1/2) - 1, sqrt(2) - 1], absolute error 4.9e-8. */
static inline num_t num_log2_reduced(num_t u)
{
    num_t p = NUM_C(-0.145744442f);
    p = num_mac(NUM_C(0.236890367f), p, u);
    p = num_mac(NUM_C(-0.250069047f), p, u);
    p = num_mac(NUM_C(0.286707457f), p, u);
    p = num_mac(NUM_C(-0.360087216f), p, u);
    p = num_mac(NUM_C(0.480939445f), p, u);
    p = num_mac(NUM_C(-0.721357149f), p, u);
    p = num_mac(NUM_C(1.442694772f), p, u);
    return num_mul(p, u);
}

/* 2^f = 1 + f P(f), f within +-1/2, relative error 9.2e-8. */
static inline num_t num_exp2_reduced(num_t f)
{
    num_t p = NUM_C(0.001326472707f);
    p = num_mac(NUM_C(0.009671512649f), p, f);
    p = num_mac(NUM_C(0.055507337437f), p, f);
    p = num_mac(NUM_C(0.240222420852f), p, f);
    p = num_mac(NUM_C(0.693146977599f), p, f);
    return num_mac(NUM_C(1.0f), p, f);
}

#ifdef EVENSPIN_FIXED

static inline num_t num_log2_unchecked(num_t x) { return num_log2(x); }
static inline num_t num_exp2_unchecked(num_t x) { return num_exp2(x); }

#else

/** IEEE 754 single precision on every machine that runs this; the C28x has no other float either. */
typedef union {
    float    value;
    uint32_t bits;
} num_bits_t;

/** num_log2 from the smallest normal number to NUM_MAX. */
static inline num_t num_log2_unchecked(num_t x)
{
    num_bits_t m;
    m.value = x;
    int32_t k = (int32_t)(m.bits >> 23) - 127;
    m.bits = (m.bits & UINT32_C(0x007FFFFF)) | UINT32_C(0x3F800000);
    const bool  upper = m.value > 1.41421356f;
    const num_t half = upper ? (m.value * 0.5f) : m.value;
    k += upper ? 1 : 0;
    return (num_t)k + num_log2_reduced(half - 1.0f);
}

/** num_exp2 from -126 to 40; cut to that. */
static inline num_t num_exp2_unchecked(num_t x)
{
    const num_t   cut = num_clamp(x, -126.0f, 40.0f);
    const int32_t k = (int32_t)(cut + ((cut < 0.0f) ? -0.5f : 0.5f));
    num_bits_t    scale;
    scale.bits = (uint32_t)(k + 127) << 23;
    return num_exp2_reduced(cut - (num_t)k) * scale.value;
}

#endif

/** num_pow for a base from the smallest normal number to NUM_MAX; not cut to NUM_MAX. */
static inline num_t num_pow_unchecked(num_t base, num_t exponent)
{
    return num_exp2_unchecked(num_mul(exponent, num_log2_unchecked(base)));
}

#endif
