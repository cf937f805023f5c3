/**
 * @file  control/observer/observer.h
 * @brief Disturbance observers on the measured torque T_d: DOB (one state), RO (time domain), ARO (angle domain).
 *
 *     DOB   T[k] = T[k-1] + g (T_d - T[k-1])                                                             (1)
 *     RO    X[t] = q X[t-N] + g (T_d[t] - X[t-N]),  output X at t = k + ahead, from one period before    (2)
 *     ARO   the same over the angle: T_d belongs to theta[k - age]; output at theta[k] + w ahead         (3)
 *
 * t = k - age is the true time of the measurement (ctl_meter_age_half); ahead = actuation of the torque reference, so
 * that the compensation meets the disturbance when it acts. The output is an estimate of T_d: subtract it.
 *
 * What goes beyond the printed algorithm, each off by default: hat-weighted averages and cubic read-out
 * (angle_memory.h), a fast start (first `fast_samples` with `fast_gain`), removal of the one-turn mean, and rest: learning stops for
 * `rest_turns` when T_d is off its one-turn mean by more than `rest_torque` (a load step), and for `rest_samples` when the
 * speed changes faster than `rest_step`, and while the encoder's rounding would be learned (`sync_band`).
 *
 * Rounding of the encoder. With c counts per sample the rounding error is a sawtooth of c cycles per sample, which
 * sampling folds to |c - nearest whole number| cycles per sample. Where that is slow enough to pass the filters and is
 * a whole order of the turn (to 1/16), every turn sees the same error and it looks like torque: with 2^17 counts and
 * 10 kHz at 2000 r/min, order 28. At such target speeds the memory is used but not written (ctl_observer_target).
 * The order is known to counts times the relative error of the angle per sample: 2^32 / samples per turn is a whole
 * number there (0.03 orders at 500 r/min), and in fixed point rad_per_speed should be a number that 2^-24 can tell.
 *
 * Source   Tang et al. 2020, equations 4, 7, 11, 16 and section IV. Stable for 0 < g < 2 (L_N a23 = g).
 * Total    non-finite torque or speed teaches nothing and is counted; a step of a quarter turn or more is counted, and
 *          learning waits until all ages lie after it; output within +-limit.
 * Cost     independent of N: an angle memory write and read, 8 products.
 */
#ifndef CONTROL_OBSERVER_OBSERVER_H
#define CONTROL_OBSERVER_OBSERVER_H

#include "control/memory/ring.h"
#include "control/observer/angle_memory.h"

#define CTL_ARO_AGE_MAX 31U

typedef enum { CTL_OBSERVER_DOB = 0, CTL_OBSERVER_RO, CTL_OBSERVER_ARO } ctl_observer_kind_t;

typedef struct {
    ctl_observer_kind_t       kind;
    ctl_angle_memory_params_t memory;       /**< gain, forgetting and limit hold for every kind. */
    uint16_t                  age_half;     /**< Age of T_d, half samples, [0, 2 CTL_ARO_AGE_MAX]. */
    num_t                     ahead;        /**< Samples until the output acts, [0, 12]. */
    num_t                     rad_per_speed; /**< Angle in rad that one unit of speed makes in one sample, > 0. */
    num_t                     fast_gain;    /**< Gain of the first `fast_samples`, (0, 1]. */
    uint32_t                  fast_samples;
    bool                      remove_mean;
    num_t                     rest_torque;  /**< 0: never. */
    num_t                     rest_turns;   /**< [0, 100]. */
    num_t                     rest_step;    /**< Change of speed per sample, low-passed, that stops learning; 0: never. */
    uint32_t                  rest_samples;
    uint32_t                  encoder_counts; /**< Per turn; 0: no rounding. */
    num_t                     sync_band;    /**< Fold frequency over sampling rate below which rounding counts, [0, 0.5]; 0: never. */
} ctl_observer_params_t;

typedef struct {
    ctl_angle_memory_t memory;    /**< ARO */
    ctl_ring_t         time;      /**< RO: X, newest first. */
    num_t              estimate;  /**< DOB */
    angle_t            past[CTL_ARO_AGE_MAX + 1U]; /**< Newest angles, ring. */
    uint16_t           head, known;
    uint32_t           samples;   /**< Since the start, stops at its end. */
    num_t              seen;      /**< Mean size of what is seen, for the quality figure. */
    num_t              turn_sum;  /**< Of T_d over angle since the turn began... */
    num_t              turn_way;  /**< ...and the way, turns. */
    num_t              mean;      /**< Of the last full turn. */
    bool               mean_known;
    num_t              rest_way;  /**< Turns for which learning still rests. */
    uint32_t           rest_left; /**< Samples for which learning still rests. */
    num_t              speed_slow; /**< Speed, low-passed over some 100 samples... */
    num_t              step_slow;  /**< ...and its change per sample, low-passed the same way. */
    uint16_t           turn_samples; /**< Samples per turn at the target speed, nearest; 65535 when it stands or creeps. */
    bool               synchronous; /**< Learning rests because of the encoder's rounding. */
    bool               held;      /**< By command: ctl_observer_hold. */
    uint32_t           rejected;
} ctl_observer_state_t;

typedef struct {
    ctl_observer_params_t params;
    ctl_observer_state_t  state;
} ctl_observer_t;

enum {
    CTL_OBSERVER_KIND = 1,
    CTL_OBSERVER_GAIN,
    CTL_OBSERVER_FORGETTING,
    CTL_OBSERVER_LIMIT,
    CTL_OBSERVER_AGE,
    CTL_OBSERVER_AHEAD,
    CTL_OBSERVER_RAD,
    CTL_OBSERVER_FAST_GAIN,
    CTL_OBSERVER_REST,
    CTL_OBSERVER_SYNC,
    CTL_OBSERVER_MEMORY
};

/**
 * Validate, take over the memory, forget everything. On error @p self stays as it was.
 * @param capacity ARO: cells per turn; RO: longest period in samples plus 32; DOB: not used.
 */
ctl_diag_t ctl_observer_init(ctl_observer_t *self, const ctl_observer_params_t *params, num_t *memory, uint16_t capacity);
/** Start again; what was learned stays when @p keep. Forgetting costs O(capacity): not for an interrupt. */
void ctl_observer_reset(ctl_observer_t *self, bool keep);
/** Stop or allow learning; the output goes on. */
void ctl_observer_hold(ctl_observer_t *self, bool hold);
/**
 * Tell the speed at which the motor is meant to turn, speed unit: gives RO its period, and says whether the encoder's
 * rounding would be learned. Cost: one 32-bit and one 64-bit product, three 32-bit divisions; call it at the rate of the speed loop.
 */
void ctl_observer_target(ctl_observer_t *self, num_t speed);
/** How far learning has come: mean size of what is still new over mean size of what is seen, 1 nothing, near 0 all. */
num_t ctl_observer_news(const ctl_observer_t *self);

/**
 * One sample.
 * @param theta  mechanical angle now.
 * @param speed  mechanical speed, speed unit.
 * @param torque T_d from ctl_meter_step.
 * @return estimate of the disturbance torque when an output of now acts.
 */
num_t ctl_observer_step(ctl_observer_t *self, angle_t theta, num_t speed, num_t torque);
num_t ctl_observer_step_raw(ctl_observer_t *self, angle_t theta, num_t speed, num_t torque);

#endif
