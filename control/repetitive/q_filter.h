/**
 * @file  control/repetitive/q_filter.h
 * @brief Zero-phase filter Q(z) = side2 z^2 + side z + centre + side z^-1 + side2 z^-2: three taps, or five.
 *
 * Magnitude with x = cos(w T_s): centre + 2 side x + 2 side2 (2 x^2 - 1), a parabola. The memory of a repetitive controller stays
 * bounded without an input when |Q| <= 1 at every frequency: at x = 1, at x = -1 and at its vertex x = -side / (4 side2) where
 * that lies between; of three taps that is |centre| + 2 |side| <= 1.
 * Source   Guo et al. 2024, equations 27 and 28 (side 0.45, centre 0.10; see docs/reference/guo2024.md on what that does).
 * Cost     2 products, 3 with five taps.
 */
#ifndef CONTROL_REPETITIVE_Q_FILTER_H
#define CONTROL_REPETITIVE_Q_FILTER_H

#include "control/numeric/num.h"

typedef struct {
    num_t side, centre;
    num_t side2; /**< 0: three taps. */
} ctl_q_t;

/** |Q| <= 1 (with 1e-5 for rounding) at every frequency; false for NaN. Main loop: a division. */
bool ctl_q_is_bounded(const ctl_q_t *q);

/** One output from three neighbours in time or angle, without side2. */
static inline num_t ctl_q_apply(const ctl_q_t *q, num_t before, num_t here, num_t after)
{
    return num_mac(num_mul(q->centre, here), q->side, num_add(before, after));
}

#endif
