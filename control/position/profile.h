/**
 * @file  control/position/profile.h
 * @brief A motion to a target with limited speed, acceleration and jerk: position, speed and acceleration per sample.
 *
 * A trapezoid of speed, decided again in every sample (so the target may move): the fastest step from which it can still
 * stop at the target. Then the mean over `smooth` samples:
 * the acceleration becomes a trapezoid, too, and the jerk is acceleration / (smooth T_s). All in whole numbers of
 * 2^-32 turns: the motion ends exactly on the target.
 *
 * acceleration = 0: unlimited, the speed jumps (the ramp of Yeh and Liu 2025, equation 41), and the acceleration handed out
 * is 0: nobody can feed an impulse forward.
 *
 * Total    any target; speed and acceleration never exceed their limits. Cost: 2 64-bit products, 2 divisions.
 */
#ifndef CONTROL_POSITION_PROFILE_H
#define CONTROL_POSITION_PROFILE_H

#include "control/position/motion.h"

#define CTL_PROFILE_SMOOTH_MAX 64U

typedef struct {
    int64_t  speed;        /**< Largest step per sample, 2^-32 turns, [1, 2^31 - 1]. */
    int64_t  acceleration; /**< Largest change of the step per sample, 2^-32 turns, [0, 2^31 - 1]; 0: unlimited. */
    uint16_t smooth;       /**< Samples of the mean, [1, CTL_PROFILE_SMOOTH_MAX]; 1: no jerk limit. */
    num_t    speed_scale;  /**< Speed unit per 2^-16 turns per sample, > 0. */
    num_t    accel_scale;  /**< Acceleration unit per 2^-20 turns per sample^2, > 0. */
} ctl_profile_params_t;

typedef struct {
    ctl_position_t raw;                          /**< Position of the trapezoid. */
    int64_t        step;                         /**< Its step. */
    int64_t        past[CTL_PROFILE_SMOOTH_MAX]; /**< Newest steps, ring. */
    int64_t        settled;                      /**< Steps older than the `known` newest ones, all the same. */
    uint16_t       known;                        /**< Valid entries of `past`, up to `smooth`. */
    int64_t        sum;                          /**< Of these. */
    int64_t        remainder;                    /**< Part of the mean that did not fit a whole number. */
    uint16_t       head;
    uint16_t       smooth;   /**< Samples of the mean that all this is for; 0: none yet. */
    uint16_t       still;    /**< Samples for which the trapezoid has been at rest, up to `smooth`. */
    ctl_position_t position; /**< Handed out. */
    int64_t        last;     /**< Step handed out last. */
} ctl_profile_state_t;

typedef struct {
    ctl_profile_params_t params;
    ctl_profile_state_t  state;
} ctl_profile_t;

typedef struct {
    ctl_position_t position;
    num_t          speed;        /**< Speed unit. */
    num_t          acceleration; /**< Acceleration unit. */
    bool           done;         /**< At the target and at rest. */
} ctl_setpoint_t;

enum { CTL_PROFILE_SPEED = 1, CTL_PROFILE_ACCELERATION, CTL_PROFILE_SMOOTH, CTL_PROFILE_SCALE };

/** Validate, stand at position 0. On error @p self stays as it was. */
ctl_diag_t ctl_profile_init(ctl_profile_t *self, const ctl_profile_params_t *params);
/** What ctl_profile_init would say; @p params is not NULL. Needs no object. */
ctl_diag_t ctl_profile_check(const ctl_profile_params_t *params);
/** Stand at @p position. */
void ctl_profile_reset(ctl_profile_state_t *state, ctl_position_t position);
/** Other limits during a motion: it goes on from its position and speed, and still ends exactly on its target. */
ctl_diag_t ctl_profile_tune(ctl_profile_t *self, const ctl_profile_params_t *params);
/** Move the zero of the position by @p shift; the motion goes on unchanged. */
void           ctl_profile_shift(ctl_profile_state_t *state, ctl_position_t shift);
ctl_setpoint_t ctl_profile_step(ctl_profile_t *self, ctl_position_t target);
/** ctl_profile_step with parameters that ctl_profile_check accepts; they may be other ones in each sample, as after ctl_profile_tune. */
ctl_setpoint_t ctl_profile_step_unchecked(const ctl_profile_params_t *p, ctl_profile_state_t *s, ctl_position_t target);

#endif
