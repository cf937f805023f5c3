/**
 * @file  control/observer/fir.h
 * @brief Symmetric FIR low-pass: linear phase, so its delay is one number for every frequency.
 *
 *     y[k] = sum_i h_i x[k-i],  i = 0..n,  h_i = h_(n-i);   delay = n / 2 samples                        (1)
 *
 * The delay is data, in half samples (ctl_fir_delay_half), for whoever has to know how old a filtered signal is.
 * Source   windowed sinc with a Hamming window, unity gain at zero frequency; Tang et al. 2020, section IV-A.
 * Total    a non-finite sample counts as the one before it, and is counted; |y| <= sum |h| max |x|.
 * Cost     6 products up to order 11, then 8: equal taps share one. Fixed: within (n + 1) steps of float.
 */
#ifndef CONTROL_OBSERVER_FIR_H
#define CONTROL_OBSERVER_FIR_H

#include "control/memory/window.h"
#include "control/numeric/diag.h"

#define CTL_FIR_ORDER_MAX (CTL_WINDOW_SIZE - 1U)
#define CTL_FIR_PAIRS (CTL_WINDOW_SIZE / 2U)

typedef struct {
    uint16_t order;                       /**< n, [0, CTL_FIR_ORDER_MAX]. */
    num_t    tap[CTL_FIR_ORDER_MAX + 1U]; /**< h_0..h_n, symmetric, sum of sizes at most 4. */
} ctl_fir_params_t;

typedef struct {
    ctl_window_t past;
    uint32_t     rejected;
} ctl_fir_state_t;

/** Of the parameters only what a step needs: filters live in every meter. */
typedef struct {
    uint16_t        order;
    num_t           fold[CTL_FIR_PAIRS]; /**< Tap of sample i and of sample n - i; half of it where both are the same. */
    ctl_fir_state_t state;
} ctl_fir_t;

enum { CTL_FIR_ORDER = 1, CTL_FIR_TAP, CTL_FIR_CUTOFF };

/** Taps of a Hamming low-pass. @param cutoff corner over sampling rate, (0, 0.5). Main loop: computes sines. */
ctl_diag_t ctl_fir_design(ctl_fir_params_t *params, uint16_t order, num_t cutoff);
/** Validate (symmetry within 4 steps of rounding), start from zero. On error @p self stays as it was. */
ctl_diag_t ctl_fir_init(ctl_fir_t *self, const ctl_fir_params_t *params);
/** What ctl_fir_init would say; @p params is not NULL. Needs no object. */
ctl_diag_t ctl_fir_check(const ctl_fir_params_t *params);
/** Other taps, of parameters that ctl_fir_init would accept, without a break in the samples. */
void  ctl_fir_tune(ctl_fir_t *self, const ctl_fir_params_t *params);
void  ctl_fir_reset(ctl_fir_t *self, num_t x);
num_t ctl_fir_step(ctl_fir_t *self, num_t x);

/** The first six products of a folded sum. Written out: a loop would cost more than what it repeats. */
static inline num_t ctl_fir_six_pairs(const num_t *h, const num_t *newest, const num_t *oldest)
{
    num_t y = num_mul(h[0], num_add(newest[0], oldest[0]));
    y = num_mac(y, h[1], num_add(newest[1], oldest[-1]));
    y = num_mac(y, h[2], num_add(newest[2], oldest[-2]));
    y = num_mac(y, h[3], num_add(newest[3], oldest[-3]));
    y = num_mac(y, h[4], num_add(newest[4], oldest[-4]));
    y = num_mac(y, h[5], num_add(newest[5], oldest[-5]));
    return y;
}

/** (1) for an @p x that is known to be finite. */
static inline num_t ctl_fir_step_unchecked(ctl_fir_t *self, num_t x)
{
    const num_t *const newest = ctl_window_push(&self->state.past, x);
    const num_t *const oldest = &newest[self->order];
    const num_t *const h = self->fold;

    num_t y = ctl_fir_six_pairs(h, newest, oldest);
    if (self->order > 11U) {
        y = num_mac(y, h[6], num_add(newest[6], oldest[-6]));
        y = num_mac(y, h[7], num_add(newest[7], oldest[-7]));
    }
    return y;
}
/** Delay in half samples: the order. */
static inline uint16_t ctl_fir_delay_half(const ctl_fir_params_t *params) { return params->order; }

#endif
