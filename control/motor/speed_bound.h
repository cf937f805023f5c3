/**
 * @file  control/motor/speed_bound.h
 * @brief A torque as it is asked for, as long as the speed stays between two limits: one integrator for both.
 *
 *     high = x + k_p (w_high - w),   low = x + k_p (w_low - w)                          (1)
 *     out  = asked, cut to low .. high, then to +-room                                  (2)
 *     x'   = x + k_i T_s (w_limit - w)   while (2) cuts, w_limit being the one that does; not further out of +-room
 *     x'   = x (1 - k_i T_s / k_p), as far as (2) then still does not cut               (3)
 *
 * At a limit it is the PI controller of the speed with that limit as its reference. By (1) to (3) the output has no step when the
 * limit begins or ends to act, and the torque comes down before the speed is at the limit, from k_p (w_high - w) = asked - x on.
 * By (3) a limit that is far away knows nothing of an old load.
 *
 * Total    any input: one that is not finite counts as 0 and is counted. |out| <= room, |x| <= room. Cost: 4 products.
 */
#ifndef CONTROL_MOTOR_SPEED_BOUND_H
#define CONTROL_MOTOR_SPEED_BOUND_H

#include "control/numeric/num_math.h"

typedef struct {
    num_t kp, ki_ts; /**< Of the speed controller, >= 0. */
    num_t relax;     /**< k_i T_s / k_p, [0, 1]. */
} ctl_speed_bound_params_t;

typedef struct {
    num_t    x;
    uint32_t rejected;
} ctl_speed_bound_t;

/** @param asked     torque unit
 *  @param err_low, err_high   lower and upper limit of the speed less the speed, loop error unit; err_low <= err_high
 *  @param room      bound of the torque, >= 0 */
num_t ctl_speed_bound_step(const ctl_speed_bound_params_t *p, ctl_speed_bound_t *s, num_t asked, num_t err_low, num_t err_high,
                           num_t room);

#endif
