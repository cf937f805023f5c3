/**
 * @file  control/repetitive/repetitive.h
 * @brief Repetitive controller: CRC, FORC or fal-FORC, by its parameters.
 *
 *     y[k] = Q(z) D(z) ( y[k] + k_rc z^m f(e[k]) ),   D(z) ~ z^-N                                        (1)
 *     u[k] = y[k]  or  lambda(e[k]) y[k]                                                                 (2)
 *
 *                order          fal                       D(z)
 *     CRC        0              none                      z^-Ni, N cut or rounded to whole samples
 *     FORC       1, 2, 3        none                      z^-Ni sum A_k(F) z^-k,  N = Ni + F;
 *                                                         order 3: z^-(Ni - 1) sum A_k(1 + F) z^-k
 *     fal-FORC   1, 2, 3        input (A): f = fal in (1)
 *                               output (B): f(e) = e, lambda in (2)
 *
 * z^m advances by writing m samples back: sample k completes the memory of sample k - m. The newest sample that
 * (1) reads is k - Ni + 1, hence Ni >= m + 2; shorter periods are computed with Ni = m + 2. Order 3 reads a sample more ahead, Ni >= m + 3:
 * its four points lie two and two around the place between them, so that no frequency is amplified, and Q = 1 can be stable; with
 * all but one on the same side the gain is up to 1.05. A Q of five taps reads one more ahead again.
 *
 * When the period changes the memory is kept as it is (CTL_RC_KEEP), cleared (CTL_RC_CLEAR, when it changes by more
 * than 1/16 sample), or it is indexed by the electrical angle (CTL_RC_ANGLE), so that what was learned at one speed
 * is right at every other. In this mode the period only gives the angle between samples for Q(z); read-out is linear
 * for order 0 and 1, cubic above.
 *
 * Source   Guo et al. 2024 (Actuators 13, 73), equations 9, 10, 15, 16, 18, 24; Tomizuka, Tsao, Chew 1989.
 * Stable   if |Q (1 - k_rc z^m M)| < 1 on the unit circle, M: the speed loop without it (`evenspin design rc`).
 * Total    a non-finite error is not learned and is counted; memory and output stay within +-limit, u within
 *          lambda_max limit. A period that is too long or too short is cut, and counted.
 * Cost     O(1): order + 3 reads and 2 order + 6 products, plus the coefficients when F changes, plus fal. Angle: up to
 *          cells / (m + 2) + 1 writes and 3 interpolated reads. Five taps of Q: two thirds of the reading again. No libm, no loop over the
 *          memory.
 * Agree    over 100 periods float stays within 1e-6 of the largest output of an exact calculation, fixed within 5e-6.
 * Context  one owner, one interrupt; not reentrant.
 */
#ifndef CONTROL_REPETITIVE_REPETITIVE_H
#define CONTROL_REPETITIVE_REPETITIVE_H

#include "control/memory/angle_grid.h"
#include "control/memory/ring.h"
#include "control/repetitive/fal.h"
#include "control/numeric/lagrange.h"
#include "control/repetitive/q_filter.h"

#define CTL_RC_LEAD_MAX 15U

typedef enum { CTL_RC_FAL_NONE = 0, CTL_RC_FAL_INPUT, CTL_RC_FAL_OUTPUT } ctl_rc_fal_at_t;
typedef enum { CTL_RC_KEEP = 0, CTL_RC_CLEAR, CTL_RC_ANGLE } ctl_rc_memory_t;

typedef struct {
    num_t            gain;     /**< k_rc, dimensionless, [0, 100]. */
    uint16_t         lead;     /**< m, samples, [0, CTL_RC_LEAD_MAX]; at least 2 for CTL_RC_ANGLE. */
    ctl_q_t          q;        /**< Taps of Q(z), |Q| <= 1 at every frequency. */
    uint16_t         order;    /**< Lagrange order, [0, 3]. */
    bool             truncate; /**< Order 0: cut N to whole samples instead of rounding it. */
    ctl_rc_fal_at_t  fal_at;
    ctl_fal_params_t fal; /**< Ignored without fal. */
    ctl_rc_memory_t  memory;
    num_t            limit;        /**< Largest |y|, error unit, > 0. */
    num_t            freeze_above; /**< Learning stops for `freeze_samples` when |e| exceeds this; 0: never. */
    uint16_t         freeze_samples;
    bool             hold; /**< Angle: nothing is written, what was learned goes on acting. */
} ctl_rc_params_t;

/** A period of more samples than a num_t could hold. */
typedef struct {
    uint16_t whole;    /**< Ni. */
    num_t    fraction; /**< F, [0, 1). */
} ctl_period_t;

typedef struct {
    ctl_ring_t   time;                          /**< y + k_rc z^m f(e) over time. */
    ctl_grid_t   turn;                          /**< y + k_rc z^m f(e) over the electrical angle. */
    num_t        y_past[CTL_RC_LEAD_MAX + 1U];  /**< Angle: outputs that still lack their error, newest first. */
    angle_t      at_past[CTL_RC_LEAD_MAX + 1U]; /**< Angles of y_past, a ring with head `past`. */
    uint16_t     past;
    uint16_t     known;                /**< Valid entries of y_past and at_past. */
    angle_t      written_at;           /**< Angle: where the last write ended. */
    num_t        written;              /**< Value of the last write. */
    bool         writing;              /**< A last write exists. */
    ctl_period_t period;               /**< The one in use. */
    num_t        a[CTL_LAGRANGE_TAPS]; /**< Coefficients for its fraction. */
    uint16_t     frozen;               /**< Samples for which learning still pauses. */
    uint32_t     rejected;             /**< Errors that were not finite. */
    uint32_t     cut_periods;          /**< Samples with a period outside of what the memory holds. */
} ctl_rc_state_t;

typedef struct {
    ctl_rc_params_t params;
    uint16_t        ahead; /**< Samples that the interpolation reads beside its place: 1 for order 3 over time, else 0. */
    uint16_t        shortest, longest; /**< Periods that the memory can hold, samples. */
#ifndef EVENSPIN_FIXED
    float too_long; /**< longest + 1. */
#endif
    bool             whole_only; /**< Periods have no fraction. */
    bool             fast;       /**< Order 2, memory kept, a lead, fal not at the output, nothing freezes, three taps. */
    const ctl_fal_t *fal;        /**< The table in use, one of `table`. */
    ctl_fal_t        table[2];   /**< The one in use, and one for ctl_rc_prepare. */
    bool             prepared;   /**< The table that is not in use is ready. */
    ctl_rc_state_t   state;
} ctl_rc_t;

enum {
    CTL_RC_GAIN = 1,
    CTL_RC_LEAD,
    CTL_RC_Q,
    CTL_RC_ORDER,
    CTL_RC_FAL_AT,
    CTL_RC_FAL_ALPHA,
    CTL_RC_FAL_DELTA,
    CTL_RC_MEMORY,
    CTL_RC_LIMIT,
    CTL_RC_FREEZE,
    CTL_RC_CAPACITY
};

/**
 * Validate, take over the memory, forget everything. On error @p self stays as it was.
 * @param memory    samples (keep, clear) or cells per electrical turn (angle), owned by the caller.
 * @param capacity  how many; at least lead + order + 5, and 2 more with five taps of Q.
 */
ctl_diag_t ctl_rc_init(ctl_rc_t *self, const ctl_rc_params_t *params, num_t *memory, uint16_t capacity);
/** What ctl_rc_init would say with a memory of @p capacity; @p p is not NULL. Needs no object. */
ctl_diag_t ctl_rc_check(const ctl_rc_params_t *p, uint16_t capacity);

/**
 * Other parameters, that ctl_rc_init would accept; order, lead, side2 of Q, memory and capacity are those of before. What was learned stays.
 * In two parts: prepare designs fal where ctl_rc_step does not read, and takes its time; take_prepared switches to it, with the same
 * parameters, while no step runs. Prepare once, then switch, before the next.
 */
void ctl_rc_prepare(ctl_rc_t *self, const ctl_rc_params_t *params);
void ctl_rc_take_prepared(ctl_rc_t *self, const ctl_rc_params_t *params);
/** ctl_rc_prepare and ctl_rc_take_prepared in one call. */
void ctl_rc_tune(ctl_rc_t *self, const ctl_rc_params_t *params);

/** Start from rest. What was learned over the angle stays when @p keep; over time it is forgotten: time goes on. Forgetting costs
 *  O(capacity): not for an interrupt. Counters stay. */
void ctl_rc_reset(ctl_rc_t *self, bool keep);

/** Longest period that the memory holds, samples; in angle mode 65534. */
static inline uint16_t ctl_rc_period_max(const ctl_rc_t *self) { return self->longest; }

/** numerator / denominator as a period in parts; what is not positive or too long gives the longest one. */
static inline void ctl_period_split(num_t numerator, num_t denominator, uint16_t *whole, num_t *fraction)
{
    *whole = 65534U;
    *fraction = (num_t)0;
#ifdef EVENSPIN_FIXED
    if ((denominator > (num_t)0) && (numerator > (num_t)0)) {
        const int64_t samples = ((int64_t)numerator * INT64_C(0x1000000)) / denominator;
        if (samples < (INT64_C(65534) * INT64_C(0x1000000))) {
            *whole = (uint16_t)(samples >> 24);
            *fraction = (num_t)(samples & INT64_C(0xFFFFFF));
        }
    }
#else
    const num_t samples = numerator / denominator;
    if ((denominator > 0.0f) & (numerator > 0.0f) & (samples < 65534.0f)) { /* one branch; a quotient of nothing is not used */
        *whole = (uint16_t)samples;
        *fraction = samples - (num_t)*whole;
    }
#endif
}

/** ctl_period_split with the parts as one value. */
static inline ctl_period_t ctl_period_ratio(num_t numerator, num_t denominator)
{
    ctl_period_t n;
    ctl_period_split(numerator, denominator, &n.whole, &n.fraction);
    return n;
}

/** ctl_period_split for numerator > 0. @return false when the memory is too short for it, or denominator is 0: then it is no
 *  period. */
static inline bool ctl_rc_period_unchecked(const ctl_rc_t *self, num_t numerator, num_t denominator, uint16_t *whole,
                                           num_t *fraction)
{
#ifdef EVENSPIN_FIXED
    ctl_period_split(numerator, denominator, whole, fraction);
    return *whole <= self->longest;
#else
    const num_t samples = numerator / denominator;
    if (!(samples < self->too_long)) {
        return false;
    }
    *whole = (uint16_t)samples;
    *fraction = samples - (num_t)*whole;
    return true;
#endif
}

/** ctl_rc_step for an error that is known to be finite and a period as ctl_rc_period_unchecked made it. */
num_t ctl_rc_step_unchecked(ctl_rc_t *self, num_t err, uint16_t whole, num_t fraction, angle_t theta_e);

/**
 * Advance one sample.
 * @param err     Error of the loop, error unit.
 * @param period  N, samples.
 * @param theta_e Electrical angle now (used in angle mode only).
 * @return correction to add to the error, error unit.
 */
num_t ctl_rc_step(ctl_rc_t *self, num_t err, ctl_period_t period, angle_t theta_e);

#endif
