/**
 * @file  control/observer/fir_cascade.h
 * @brief Two symmetric FIR filters one after the other, as one filter.
 *
 *     y = gain FIR2(FIR1(x)):   taps are gain times the convolution of theirs, order n = n1 + n2         (1)
 *
 * It answers with the same numbers as the two but for rounding, and is symmetric as they are, so that equal taps share a
 * product: half a product a tap in one place, where two filters cost that and what surrounds it twice.
 *
 * Total    for numbers up to NUM_MAX / 256; a non-finite sample must not come here.
 * Cost     10 products up to order 19 (CTL_FIR_CASCADE_SHORT), then 16 in a loop. Fixed: within (n + 1) steps of float.
 */
#ifndef CONTROL_OBSERVER_FIR_CASCADE_H
#define CONTROL_OBSERVER_FIR_CASCADE_H

#include "control/observer/fir.h"

#define CTL_FIR_CASCADE_MAX (2U * CTL_FIR_ORDER_MAX)
#define CTL_FIR_CASCADE_PAIRS (CTL_LONG_WINDOW_SIZE / 2U)
#define CTL_FIR_CASCADE_SHORT 19U

typedef struct {
    uint16_t order;                       /**< n, [0, CTL_FIR_CASCADE_MAX]. */
    num_t    fold[CTL_FIR_CASCADE_PAIRS]; /**< Tap of sample i and of sample n - i; half of it where both are the same. */
    ctl_long_window_t past;
} ctl_fir_cascade_t;

/** Convolve both filters, (1) of this header, of parameters that ctl_fir_init would accept, without a break in the samples. */
void ctl_fir_cascade_tune(ctl_fir_cascade_t *self, const ctl_fir_params_t *first, const ctl_fir_params_t *second, num_t gain);
/** All samples so far were @p x, a finite number. */
static inline void ctl_fir_cascade_reset(ctl_fir_cascade_t *self, num_t x) { ctl_long_window_fill(&self->past, x); }
/** Advance one sample: (1) of this header. */
num_t ctl_fir_cascade_step_unchecked(ctl_fir_cascade_t *self, num_t x);

/** The first ten products of (1), all of them up to order CTL_FIR_CASCADE_SHORT. Inline for the meter, and written out: a call and a
 *  loop cost 60 cycles more. */
static inline num_t ctl_fir_cascade_ten_pairs(ctl_fir_cascade_t *self, num_t x)
{
    const num_t *const newest = ctl_long_window_push(&self->past, x);
    const num_t *const oldest = &newest[self->order];
    const num_t *const h = self->fold;

    num_t y = ctl_fir_six_pairs(h, newest, oldest);
    y = num_mac(y, h[6], num_add(newest[6], oldest[-6]));
    y = num_mac(y, h[7], num_add(newest[7], oldest[-7]));
    y = num_mac(y, h[8], num_add(newest[8], oldest[-8]));
    y = num_mac(y, h[9], num_add(newest[9], oldest[-9]));
    return y;
}

#endif
