/**
 * @file  control/position/ilc.h
 * @brief Learning over the angle, turn by turn: what went wrong at an angle corrects the next pass.
 *
 *     c(theta) <- c(theta) + k e(theta)        output c(theta), learned in the turns before               (1)
 *
 * The error of sample n is credited to the angle of sample n - lead, where its cause acted. Every grid point passed
 * is updated, in either direction.
 *
 *   SILC: e is the speed error, c the speed compensation. Slow learning of a residual torque: e is the feedback torque,
 *   c the torque compensation.
 *
 * Source   Yeh and Liu 2025, equation 4.
 * Total    a non-finite error is not learned and is counted; |c| <= limit.
 * Cost     a grid walk and a linear read.
 */
#ifndef CONTROL_POSITION_ILC_H
#define CONTROL_POSITION_ILC_H

#include "control/memory/angle_grid.h"

#define CTL_ILC_LEAD_MAX 31U

typedef struct {
    num_t    gain;  /**< k, output unit per error unit, [0, 100]. */
    uint16_t lead;  /**< Samples, [0, CTL_ILC_LEAD_MAX]. */
    num_t    limit; /**< Largest |c|, > 0. */
} ctl_ilc_params_t;

typedef struct {
    ctl_grid_t grid;
    angle_t    past[CTL_ILC_LEAD_MAX + 1U]; /**< Newest angles, ring. */
    uint16_t   head, known;
    angle_t    at;  /**< Angle at which the last write ended. */
    num_t      err; /**< Error at the end of the last write. */
    bool       primed;
    uint32_t   rejected;
} ctl_ilc_state_t;

typedef struct {
    ctl_ilc_params_t params;
    ctl_ilc_state_t  state;
} ctl_ilc_t;

enum { CTL_ILC_GAIN = 1, CTL_ILC_LEAD, CTL_ILC_LIMIT, CTL_ILC_CELLS };

/** Validate, take over @p memory, all zero. On error @p self stays as it was. */
ctl_diag_t ctl_ilc_init(ctl_ilc_t *self, const ctl_ilc_params_t *params, num_t *memory, uint16_t cells);
/** Forget the last samples; the contents stay when @p keep. Forgetting costs O(cells). */
void ctl_ilc_reset(ctl_ilc_t *self, bool keep);
/** One sample. @return c at @p theta. */
num_t ctl_ilc_step(ctl_ilc_t *self, angle_t theta, num_t err);

#endif
