/**
 * @file  tests/support/numeric.h
 * @brief One test source for both numerics: values in and out, tolerances, noise, and what is not a number.
 *
 * Tests think in double. A value goes into a block with num_of(), comes out with value_of(), and a tolerance has two
 * sides, per_numeric(float, fixed), because float errs relative to the value and fixed point absolutely.
 */
#ifndef TESTS_SUPPORT_NUMERIC_H
#define TESTS_SUPPORT_NUMERIC_H

#include <float.h>
#include <math.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <string.h>

#include "control/numeric/num.h"
#include "unity.h"

#define COUNT_OF(array) (sizeof(array) / sizeof((array)[0]))
#define FIXED_STEP (1.0 / 16777216.0) /* one step of Q7.24 */
#define FLOAT_EPS (1.0 / 8388608.0)   /* distance of two floats at 1 */
#define TURN_STEPS 4294967296.0       /* steps of an angle_t per turn */
#define TWO_PI 6.283185307179586476925

#ifdef EVENSPIN_FIXED

/** What no block may calculate with: the one bit pattern that has no negative. */
static const num_t NOT_FINITE[] = {INT32_MIN};
/** Extremes that are numbers, and some ordinary ones between them. */
static const num_t  NASTY[] = {INT32_MIN, INT32_MAX,  -INT32_MAX, 0,           1,     -1,
                               0x1000000, -0x1000000, 0x7F000000, -0x7F000000, 12345, -999999999};
static inline num_t num_of(double x)
{
    const double steps = x / FIXED_STEP;
    return (steps >= 2147483647.0) ? INT32_MAX : ((steps <= -2147483647.0) ? -INT32_MAX : (num_t)llround(steps));
}
static inline double value_of(num_t x) { return (double)x * FIXED_STEP; }
static inline double per_numeric(double in_float, double in_fixed)
{
    (void)in_float;
    return in_fixed;
}
#define FLOAT_ONLY() TEST_IGNORE_MESSAGE("float only")
#define FIXED_ONLY() ((void)0)

#else

static const num_t   NOT_FINITE[] = {NAN, -NAN, INFINITY, -INFINITY, 1e38f, -1e38f, FLT_MAX, 1.1e12f};
static const num_t   NASTY[] = {NAN,   INFINITY, -INFINITY, 1e38f,  -1e38f, 1e12f, -1e12f, 0.0f,
                                -0.0f, FLT_MIN,  -FLT_MIN,  1e-42f, 1.0f,   -1.0f, 3e6f,   -7e-5f};
static inline num_t  num_of(double x) { return (num_t)x; }
static inline double value_of(num_t x) { return (double)x; }
static inline double per_numeric(double in_float, double in_fixed)
{
    (void)in_fixed;
    return in_float;
}
#define FLOAT_ONLY() ((void)0)
#define FIXED_ONLY() TEST_IGNORE_MESSAGE("fixed point only")

#endif

/** The largest value there is, as a test sees it. */
static inline double num_max_value(void) { return value_of(NUM_MAX); }

/** Noise that tests/control/golden/make_golden.py makes, too: multiples of 2^-16 in [-1/2, 1/2), exact in both numerics. */
typedef struct {
    uint32_t seed;
} noise_t;

static inline uint32_t noise_bits(noise_t *self)
{
    self->seed = (self->seed * UINT32_C(1664525)) + UINT32_C(1013904223);
    return self->seed;
}
static inline double noise_next(noise_t *self) { return ((double)(noise_bits(self) >> 16) - 32768.0) / 65536.0; }
/** A whole number in [0, below). */
static inline uint32_t noise_pick(noise_t *self, uint32_t below)
{
    return (uint32_t)(((uint64_t)noise_bits(self) * below) >> 32);
}
/** Mostly one of NASTY, sometimes an ordinary number within +-4. */
static inline num_t noise_nasty(noise_t *self)
{
    const uint32_t pick = noise_pick(self, (uint32_t)(2U * COUNT_OF(NASTY)));
    return (pick < COUNT_OF(NASTY)) ? NASTY[pick] : num_of(8.0 * noise_next(self));
}

/** Text for the message of an assertion in a loop: which turn of it failed. */
static inline const char *at(const char *format, ...)
{
    static char text[160];
    va_list     arguments;
    va_start(arguments, format);
    (void)vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    return text;
}

#define ASSERT_NUM_WITHIN(tolerance, expected, actual) TEST_ASSERT_DOUBLE_WITHIN((tolerance), (expected), value_of(actual))
/** As TEST_ASSERT_DOUBLE_WITHIN_MESSAGE, but the text is made when it fails: an at() takes longer than most that is tested. */
#define ASSERT_DOUBLE_WITHIN_AT(tolerance, expected, actual, text)                                                               \
    do {                                                                                                                         \
        const double tolerance_of_it = (tolerance), expected_of_it = (expected), actual_of_it = (actual);                        \
        if (!((fabs(expected_of_it - actual_of_it) <= tolerance_of_it) && (tolerance_of_it <= DBL_MAX))) {                       \
            TEST_ASSERT_DOUBLE_WITHIN_MESSAGE(tolerance_of_it, expected_of_it, actual_of_it, (text));                            \
        }                                                                                                                        \
    } while (0)
#define ASSERT_NUM_WITHIN_AT(tolerance, expected, actual, text)                                                                  \
    ASSERT_DOUBLE_WITHIN_AT((tolerance), (expected), value_of(actual), (text))
/** Finite and within +-bound; NaN fails. */
#define ASSERT_BOUNDED_AT(bound, actual, text) TEST_ASSERT_TRUE_MESSAGE(fabs(value_of(actual)) <= (bound), (text))
/** A ctl_diag_t in all its parts: status, field, and the value that was given. */
#define ASSERT_DIAG(wanted_status, wanted_field, wanted_given, got)                                                              \
    do {                                                                                                                         \
        const ctl_diag_t diag_of_it = (got);                                                                                     \
        TEST_ASSERT_EQUAL((wanted_status), diag_of_it.status);                                                                   \
        TEST_ASSERT_EQUAL_UINT16((wanted_field), diag_of_it.field);                                                              \
        ASSERT_NUM_WITHIN(0.0, (wanted_given), diag_of_it.given);                                                                \
    } while (0)
#define ASSERT_SAME_BITS(expected, actual) TEST_ASSERT_EQUAL_MEMORY(&(expected), &(actual), sizeof(actual))

#endif
