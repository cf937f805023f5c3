/**
 * @file  control/observer/fir.h
 * @brief Symmetric FIR low-pass: linear phase, so its delay is one number for every frequency.
 *
 *     y[k] = sum_i h_i x[k-i],  i = 0..n,  h_i = h_(n-i);   delay = n / 2 samples                        (1)
 *
 * The delay is data, in half samples (ctl_fir_delay_half), for whoever has to know how old a filtered signal is.
 * Source   windowed sinc with a Hamming window, unity gain at zero frequency; Tang et al. 2020, section IV-A.
 * Total    a non-finite sample counts as the one before it, and is counted; |y| <= sum |h| max |x|.
 * Cost     n / 2 + 1 products. Fixed: within (n + 1) steps of float.
 */
#ifndef CONTROL_OBSERVER_FIR_H
#define CONTROL_OBSERVER_FIR_H

#include "control/numeric/diag.h"

#define CTL_FIR_ORDER_MAX 15U

typedef struct {
    uint16_t order;                       /**< n, [0, CTL_FIR_ORDER_MAX]. */
    num_t    tap[CTL_FIR_ORDER_MAX + 1U]; /**< h_0..h_n, symmetric, sum of sizes at most 4. */
} ctl_fir_params_t;

typedef struct {
    num_t    x[CTL_FIR_ORDER_MAX + 1U]; /**< Ring of the newest samples. */
    uint16_t head;
    uint32_t rejected;
} ctl_fir_state_t;

typedef struct {
    ctl_fir_params_t params;
    ctl_fir_state_t  state;
} ctl_fir_t;

enum { CTL_FIR_ORDER = 1, CTL_FIR_TAP, CTL_FIR_CUTOFF };

/** Taps of a Hamming low-pass. @param cutoff corner over sampling rate, (0, 0.5). Main loop: computes sines. */
ctl_diag_t ctl_fir_design(ctl_fir_params_t *params, uint16_t order, num_t cutoff);
/** Validate (symmetry within 4 steps of rounding), start from zero. On error @p self stays as it was. */
ctl_diag_t ctl_fir_init(ctl_fir_t *self, const ctl_fir_params_t *params);
void       ctl_fir_reset(ctl_fir_t *self, num_t x);
num_t      ctl_fir_step(ctl_fir_t *self, num_t x);
/** Delay in half samples: the order. */
static inline uint16_t ctl_fir_delay_half(const ctl_fir_params_t *params) { return params->order; }

#endif
