/**
 * @file  control/numeric/num.h
 * @brief The number type of every control block: float, or saturating fixed point Q7.24 when EVENSPIN_FIXED is set.
 *
 * A block is written once, with the functions below. In the float build signals are in SI units; in the fixed build
 * they are per unit of base values that the caller chooses, so that everything of interest lies within +-128.
 *
 *              float                       fixed
 *   range      +-NUM_MAX = 1e12            +-128 - 2^-24, every operation saturates
 *   step       2^-24 relative              2^-24 = 6.0e-8 absolute
 *
 * Total: with operands within +-NUM_MAX no operation gives NaN or infinity in either build, as long as no more than
 * two products are chained (1e12^3 is below FLT_MAX). Inputs from outside go through num_guard first.
 *
 * A function whose name ends in _unchecked does the work of the one without it for inputs that the caller has checked: finite, and
 * within the range that its comment states. The current interrupt checks each sample once. See control/conventions.md.
 */
#ifndef CONTROL_NUMERIC_NUM_H
#define CONTROL_NUMERIC_NUM_H

#include <stdbool.h>
#include <stdint.h>

#include "control/numeric/fpu.h"

#ifdef EVENSPIN_FIXED

typedef int32_t num_t;

#define NUM_NAME "fixed"
#define NUM_FRAC_BITS 24
#define NUM_MAX INT32_MAX
#define NUM_EPS ((num_t)1) /**< Smallest step above zero. */
/** Half a step towards x. From 1/2 on a float has no parts of a step, and the half would be rounded to a whole one. */
#define NUM_HALF_STEP(x) ((((x) < 0.5f) && ((x) > -0.5f)) ? (((x) < 0.0f) ? -0.5f : 0.5f) : 0.0f)
/** A constant, written with the f suffix: NUM_C(0.45f). Rounded to the nearest step. */
#define NUM_C(x) ((num_t)(((x) * 16777216.0f) + NUM_HALF_STEP(x)))

static inline num_t num_sat64(int64_t x) { return (x > INT32_MAX) ? INT32_MAX : ((x < -INT32_MAX) ? -INT32_MAX : (num_t)x); }
static inline num_t num_add(num_t a, num_t b) { return num_sat64((int64_t)a + b); }
static inline num_t num_sub(num_t a, num_t b) { return num_sat64((int64_t)a - b); }
static inline num_t num_neg(num_t a) { return num_sat64(-(int64_t)a); }
/** Product, rounded to the nearest step; >> of a negative number is arithmetic on every compiler that builds this. */
static inline num_t num_mul(num_t a, num_t b) { return num_sat64((((int64_t)a * b) + INT64_C(0x800000)) >> 24); }
/** acc + a b. */
static inline num_t num_mac(num_t acc, num_t a, num_t b)
{
    return num_sat64((((((int64_t)acc) * INT64_C(0x1000000)) + ((int64_t)a * b)) + INT64_C(0x800000)) >> 24);
}
/** a / b, cut towards zero; a division by zero gives the limit with the sign of a. */
static inline num_t num_div(num_t a, num_t b)
{
    if (b == 0) {
        return (a < 0) ? -NUM_MAX : NUM_MAX;
    }
    return num_sat64(((int64_t)a * INT64_C(0x1000000)) / b);
}
static inline num_t num_quotient(num_t a, num_t b) { return num_div(a, b); }
static inline bool  num_is_finite(num_t x) { return x != INT32_MIN; }
/** Nearest step to x; NaN gives 0, out of range saturates. */
static inline num_t num_from_float(float x)
{
    if (!(x < 128.0f)) {
        return (x >= 128.0f) ? NUM_MAX : 0;
    }
    if (x <= -128.0f) {
        return -NUM_MAX;
    }
    return (num_t)((x * 16777216.0f) + NUM_HALF_STEP(x));
}
static inline num_t num_from_finite(float x) { return num_from_float(x); }
static inline float num_to_float(num_t x) { return (float)x * 5.9604644775390625e-8f; }
static inline num_t num_from_int(int16_t n) { return num_sat64((int64_t)n * INT64_C(0x1000000)); }
/** Largest whole number not above x. */
static inline int32_t num_floor(num_t x) { return x >> 24; }

#else /* float */

typedef float num_t;

#define NUM_NAME "float"
#define NUM_MAX 1.0e12f
#define NUM_EPS 1.0e-12f
#define NUM_C(x) (x)

static inline num_t num_add(num_t a, num_t b) { return a + b; }
static inline num_t num_sub(num_t a, num_t b) { return a - b; }
static inline num_t num_neg(num_t a) { return -a; }
static inline num_t num_mul(num_t a, num_t b) { return a * b; }
static inline num_t num_mac(num_t acc, num_t a, num_t b) { return acc + (a * b); }
static inline num_t num_div(num_t a, num_t b)
{
    const num_t limit = (a < 0.0f) ? -NUM_MAX : NUM_MAX;
    const num_t q = (b != 0.0f) ? (a / b) : limit;
    return (q > NUM_MAX) ? NUM_MAX : ((q < -NUM_MAX) ? -NUM_MAX : q);
}
/** a / b for b other than 0 and a quotient within +-NUM_MAX: no input is checked. */
static inline num_t num_quotient(num_t a, num_t b) { return a / b; }
/** True inside +-NUM_MAX; false for NaN, infinity and what would become infinite in a product. */
static inline bool  num_is_finite(num_t x) { return (x <= NUM_MAX) && (x >= -NUM_MAX); }
static inline num_t num_from_float(float x)
{
    return (x <= NUM_MAX) ? ((x >= -NUM_MAX) ? x : -NUM_MAX) : ((x > NUM_MAX) ? NUM_MAX : 0.0f);
}
/** num_from_float of an x that is known to be finite. */
static inline num_t num_from_finite(float x) { return x; }
static inline float num_to_float(num_t x) { return x; }
static inline num_t num_from_int(int16_t n) { return (num_t)n; }
/** Largest whole number not above x, for |x| < 2^31; outside that range the result is the limit. */
static inline int32_t num_floor(num_t x)
{
    if (!(x < 2147483648.0f)) {
        return INT32_MAX;
    }
    if (x < -2147483648.0f) {
        return INT32_MIN;
    }
    const int32_t cut = (int32_t)x;
    return ((num_t)cut > x) ? (cut - 1) : cut;
}

#endif

/* num_clamp: x within [lo, hi], whatever x is: NaN gives lo (on the chip lo or hi). Needs lo <= hi. */
#ifdef CTL_HAS_FPU
static inline num_t num_abs(num_t x) { return fpu_max(x, -x); }
static inline num_t num_min(num_t a, num_t b) { return fpu_min(a, b); }
static inline num_t num_max(num_t a, num_t b) { return fpu_max(a, b); }
static inline num_t num_clamp(num_t x, num_t lo, num_t hi) { return fpu_min(fpu_max(x, lo), hi); }
#else
static inline num_t num_abs(num_t x) { return (x < (num_t)0) ? num_neg(x) : x; }
static inline num_t num_min(num_t a, num_t b) { return (a < b) ? a : b; }
static inline num_t num_max(num_t a, num_t b) { return (a > b) ? a : b; }
static inline num_t num_clamp(num_t x, num_t lo, num_t hi) { return (x > lo) ? ((x < hi) ? x : hi) : lo; }
#endif

/** Add one to an event counter that stops at its end instead of wrapping. */
static inline void num_count(uint32_t *counter) { *counter += (*counter < UINT32_MAX) ? 1U : 0U; }

/** A signal from outside: x when it can be computed with, else the fallback, counted. */
static inline num_t num_guard(num_t x, num_t fallback, uint32_t *rejected)
{
    if (num_is_finite(x)) {
        return x;
    }
    num_count(rejected);
    return fallback;
}

#endif
