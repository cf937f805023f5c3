/**
 * @file  control/position/ramp.h
 * @brief A number that goes to its target with a limited rate, and with a limited change of that rate.
 *
 * In every sample the largest step from which it can still stop at the target, so the target may move. In whole numbers: it ends
 * exactly on the target and never beyond one that stands still, unless the rate it comes with is too high to stop there.
 * Used for a speed (rate: acceleration, its change: jerk) and, in control/position/profile.h, for a position (speed, acceleration).
 *
 * Total    any target and any state. Cost: 8 additions of 64 bits; with a limited change 4 products and a division more.
 */
#ifndef CONTROL_POSITION_RAMP_H
#define CONTROL_POSITION_RAMP_H

#include "control/numeric/diag.h"

#define CTL_RAMP_STEP_MAX INT64_C(0x7FFFFFFF)

typedef struct {
    int64_t rate;   /**< Largest step per sample, [1, CTL_RAMP_STEP_MAX]. */
    int64_t change; /**< Largest change of the step per sample, [0, CTL_RAMP_STEP_MAX]; 0: unlimited. */
} ctl_ramp_params_t;

typedef struct {
    int64_t at;
    int64_t step; /**< Last step. */
} ctl_ramp_state_t;

/** Next step of something with limits @p rate and @p change (ctl_ramp_params_t) that is @p travel away from its target and made
 *  @p step last. */
int64_t ctl_ramp_next(int64_t rate, int64_t change, int64_t travel, int64_t step);

/** Stand at @p at. */
static inline void ctl_ramp_reset(ctl_ramp_state_t *state, int64_t at)
{
    state->at = at;
    state->step = 0;
}
/** One sample; @p params in their ranges, other ones in each sample if need be. @return where it is now. */
int64_t ctl_ramp_step_unchecked(const ctl_ramp_params_t *params, ctl_ramp_state_t *state, int64_t target);

#endif
