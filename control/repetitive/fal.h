/**
 * @file  control/repetitive/fal.h
 * @brief The function fal: small errors count more, large errors less.
 *
 *     fal(e) = e delta^(alpha-1)       for |e| <= delta                                                  (1)
 *            = |e|^alpha sgn(e)        for |e| >  delta
 *     lambda(e) = fal(e) / e,  lambda(0) = delta^(alpha-1)                                               (2)
 *
 * Source   Han 2009; Guo et al. 2024, equations 19 and 20. Odd and continuous; its slope is largest inside +-delta:
 *          delta^(alpha-1) = 1.4427 for alpha 0.6, delta 0.4.
 * Total    NaN gives fal = 0 and lambda(0); infinity counts as NUM_MAX.
 * Cost     inside +-delta one product. Outside, float: two small tables and four terms of a series, no logarithm; fixed:
 *          num_pow. No libm. ctl_fal_init raises 23 numbers to a power in float.
 *          Float: relative error below 2e-6 for |e| in 1e-9..1e9. Fixed: below 1e-6 of the larger of 1 and |fal|.
 */
#ifndef CONTROL_REPETITIVE_FAL_H
#define CONTROL_REPETITIVE_FAL_H

#include "control/numeric/diag.h"
#include "control/numeric/num_math.h"

typedef struct {
    num_t alpha; /**< Exponent, (0, 1]. */
    num_t delta; /**< Half width of the linear part, error unit, > 0. */
} ctl_fal_params_t;

#define CTL_FAL_PARTS 4U       /**< Of an octave. */
#define CTL_FAL_FIRST_EIGHT 10 /**< 8 * 10 is the exponent of 2^-47: delta is 1e-12 at least. */
#define CTL_FAL_EIGHTS 11U     /**< Eights of octaves: exponents of float from 80 to 167, 2^-47 to 2^40. */

typedef struct {
    ctl_fal_params_t params;
    num_t            slope; /**< delta^(alpha-1), kept because it never changes. */
#ifndef EVENSPIN_FIXED
    /* |e|^alpha = eight[a] part[i].power (1 + u)^alpha for |e| = 2^(8 a + b - 127) (1 + j / 4 + ...), b = 0..7, i = 4 b + j */
    float eight[CTL_FAL_EIGHTS];
    struct {
        float inverse, power; /**< Of the middle of the part; the former without 2^b. */
    } part[8U * CTL_FAL_PARTS];
    float series[4]; /**< Of (1 + u)^alpha: the factors of u, u^2, u^3, u^4. */
#endif
} ctl_fal_t;

enum { CTL_FAL_ALPHA = 1, CTL_FAL_DELTA };

/** Validate and precompute. On error @p self stays as it was. */
ctl_diag_t ctl_fal_init(ctl_fal_t *self, const ctl_fal_params_t *params);
/** What ctl_fal_init would say; @p params is not NULL. Needs no object. */
ctl_diag_t ctl_fal_check(const ctl_fal_params_t *params);
/** fal(e): (1) of this header. */
num_t ctl_fal(const ctl_fal_t *self, num_t e);
/** Gain lambda(e): (2) of this header, within (0, delta^(alpha-1)]. */
num_t ctl_fal_lambda(const ctl_fal_t *self, num_t e);

#ifdef EVENSPIN_FIXED
static inline num_t ctl_fal_power(const ctl_fal_t *self, num_t size) { return num_pow(size, self->params.alpha); }
#else
/** size^alpha for delta < size <= NUM_MAX. u is within +-1/9: the fifth term of the series is below 5e-7. */
static inline num_t ctl_fal_power(const ctl_fal_t *self, num_t size)
{
    num_bits_t m;
    m.value = size;
    const uint32_t bits = m.bits;
    const uint32_t a = (bits >> 26) - (uint32_t)CTL_FAL_FIRST_EIGHT;
    const uint32_t i = (bits >> 21) & ((8U * CTL_FAL_PARTS) - 1U);
    m.bits = (bits & UINT32_C(0x007FFFFF)) | UINT32_C(0x3F800000);

    const float        u = (m.value * self->part[i].inverse) - 1.0f;
    const float *const c = self->series;
    const float        curve = 1.0f + (u * (c[0] + (u * (c[1] + (u * (c[2] + (u * c[3])))))));
    return self->eight[a] * self->part[i].power * curve;
}
#endif

static inline num_t ctl_fal_unchecked(const ctl_fal_t *self, num_t e)
{
    const num_t size = num_abs(e);
    if (size > self->params.delta) {
        return num_mul((e < (num_t)0) ? NUM_C(-1.0f) : NUM_C(1.0f), ctl_fal_power(self, size));
    }
    return num_mul(self->slope, e);
}

#endif
