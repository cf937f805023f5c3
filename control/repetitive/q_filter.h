/**
 * @file  control/repetitive/q_filter.h
 * @brief Zero-phase three-tap filter Q(z) = side z + centre + side z^-1.
 *
 * Magnitude at w T_s: centre + 2 side cos(w T_s). The memory of a repetitive controller stays bounded without an
 * input when |Q| <= 1 at every frequency, hence |centre| + 2 |side| <= 1.
 * Source   Guo et al. 2024, equation 28 (side 0.45, centre 0.10; see docs/reference/guo2024.md on what that does).
 * Cost     2 products.
 */
#ifndef CONTROL_REPETITIVE_Q_FILTER_H
#define CONTROL_REPETITIVE_Q_FILTER_H

#include "control/numeric/num.h"

typedef struct {
    num_t side, centre;
} ctl_q_t;

/** |centre| + 2 |side| <= 1 (with 1e-5 for rounding); false for NaN. */
static inline bool ctl_q_is_bounded(const ctl_q_t *q)
{
    return num_add(num_abs(q->centre), num_add(num_abs(q->side), num_abs(q->side))) <= NUM_C(1.00001f);
}

/** One output from three neighbours in time or angle. */
static inline num_t ctl_q_apply(const ctl_q_t *q, num_t before, num_t here, num_t after)
{
    return num_mac(num_mul(q->centre, here), q->side, num_add(before, after));
}

#endif
