/**
 * @file  control/motor/pll.h
 * @brief Tracking filter (phase-locked loop) on an angle: speed without differentiating counts.
 *
 *     e[k] = wrap( theta[k] - th[k] )                                                                    (1)
 *     w[k] = w[k-1] + k_i T_s e[k]                                                                       (2)
 *     th[k+1] = th[k] + (w[k] + k_p e[k]) T_s                                                            (3)
 *
 * Poles s^2 + k_p s + k_i: k_p = 2 zeta w_0, k_i = w_0^2. The speed is w; it lags an acceleration a by a k_p / k_i.
 *
 * Total    the angle is a binary angle, so every input is a valid one; w stays within +-speed_max.
 * Cost     6 products. Float and fixed agree within 1e-5 of full scale.
 */
#ifndef CONTROL_MOTOR_PLL_H
#define CONTROL_MOTOR_PLL_H

#include "control/numeric/angle.h"
#include "control/numeric/diag.h"

typedef struct {
    num_t kp_ts;            /**< k_p T_s, dimensionless, (0, 1]. */
    num_t ki_ts;            /**< k_i T_s, speed unit per rad, > 0. */
    num_t rad_per_speed_ts; /**< Angle in rad that one unit of speed makes in one sample: T_s times the base speed. */
    num_t speed_max;        /**< Limit of the speed, > 0, such that the angle per sample stays below half a turn. */
} ctl_pll_params_t;

typedef struct {
    angle_t th;    /**< Estimated angle, the one expected at the next sample. */
    num_t   w;     /**< Estimated speed, speed unit. */
    num_t   error; /**< Last angle error, rad, [-pi, pi). */
} ctl_pll_state_t;

typedef struct {
    ctl_pll_params_t params;
    ctl_pll_state_t  state;
} ctl_pll_t;

enum { CTL_PLL_KP = 1, CTL_PLL_KI, CTL_PLL_RAD_PER_SPEED, CTL_PLL_SPEED_MAX };

/** Validate, start at rest at angle 0. On error @p self stays as it was. */
ctl_diag_t ctl_pll_init(ctl_pll_t *self, const ctl_pll_params_t *params);
/** Start again at rest at @p theta. */
void ctl_pll_reset(ctl_pll_t *self, angle_t theta);
/** One sample: (1) to (3). @return speed, speed unit, within +-speed_max. */
static inline num_t ctl_pll_step(ctl_pll_t *self, angle_t theta)
{
    const ctl_pll_params_t *const p = &self->params;
    ctl_pll_state_t *const        s = &self->state;

    s->error = angle_to_rad_signed(theta - s->th);                                                           /* (1) */
    s->w = num_clamp(num_mac(s->w, p->ki_ts, s->error), num_neg(p->speed_max), p->speed_max);                /* (2) */
    s->th += angle_step_from_rad_unchecked(num_mac(num_mul(s->w, p->rad_per_speed_ts), p->kp_ts, s->error)); /* (3) */
    return s->w;
}

#endif
