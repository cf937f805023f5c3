/**
 * @file  control/observer/torque_meter.h
 * @brief The disturbance torque that moves the shaft, "measured" from the encoder and the torque reference.
 *
 *     w[k]     = (theta[k] - theta[k-1]) / T_s                              age 1/2                      (1)
 *     w_f      = FIR1(w), for whoever asks for the speed                    + n1 / 2                     (2)
 *     T_sum[k] = (w[k] - a22 w[k-1]) / a23                                  + 1/2                        (3)
 *     T_d      = FIR2( FIR1( T_sum - T_ref delayed ) )                      + n1 / 2 + n2 / 2            (4)
 *
 * The paper filters first, T_sum from w_f and T_ref by itself, and has three filters. All of it is linear, so the order
 * makes no difference, and FIR1 and FIR2 are one filter whose taps are the convolution of theirs: one in place of three.
 *
 * Torque is counted in the unit of the torque reference, commonly ampere of q current: then a23 = T_s k_T / J.
 *
 * Delay bookkeeping. Symmetric filters delay by half their order, so the result is the torque that acted
 * 1/2 + n1/2 + 1/2 + n2/2 samples ago: 10.5 for orders 9 and 10. The printed label k-21 adds whole orders; it is
 * wrong by 10.5 samples, which 100 r/min forgives and 451 r/min does not (tests/scenario shows it).
 * A reference issued at k acts in the middle at k + actuation; so it is held back by actuation + 1 before it goes
 * through the same filters. What T_ref did not become (current-sensor errors, dead time) is part of T_d.
 *
 * Source   Tang et al. 2020, equations 18 to 20, with the ages corrected.
 * Total    a non-finite reference counts as the one before it; a step of angle beyond `step_max` (a jump) counts as the
 *          step before. Both are counted.
 * Cost     one FIR filter of n1 + n2 and 5 products; the speed, where it is asked for, another filter.
 */
#ifndef CONTROL_OBSERVER_TORQUE_METER_H
#define CONTROL_OBSERVER_TORQUE_METER_H

#include "control/numeric/angle.h"
#include "control/observer/fir_cascade.h"

typedef struct {
    num_t            speed_per_rad; /**< Speed unit per rad and sample: 1 / (T_s base), > 0. */
    num_t            torque_per_16; /**< 1 / (16 a23): torque unit per speed unit and sample, over 16; > 0. */
    num_t            a22;           /**< 1 - B T_s / J, [0, 1]. */
    ctl_fir_params_t fir1, fir2;
    num_t            actuation;    /**< Samples from a reference to the middle of its action, [0.5, 12]. */
    num_t            step_max_rad; /**< Largest angle between two samples, (0, pi]. */
} ctl_meter_params_t;

typedef struct {
    ctl_fir_t         speed_fir;  /**< FIR1. */
    ctl_fir_cascade_t torque_fir; /**< FIR1 and FIR2, times 16. */
    ctl_window_t      ref;        /**< Newest references over 16. */
    angle_t           theta;
    num_t             speed; /**< Of the last step of the angle. */
    uint32_t          below; /**< Fixed point: what the angles of all steps lack so far, 2^-32 of a step of num_t. */
    bool              primed;
    uint32_t          rejected;
} ctl_meter_state_t;

/** What follows from the parameters: for how long a reference is held back, and whether the fast path can be taken. */
typedef struct {
    num_t    part;     /**< Fraction of the delay, samples, [0, 1). */
    uint16_t whole;    /**< Whole samples of the delay. */
    bool     is_short; /**< FIR1 and FIR2 have an order up to CTL_FIR_CASCADE_SHORT, steps are below a quarter turn. */
} ctl_meter_held_t;

typedef struct {
    ctl_meter_params_t params;
    ctl_meter_held_t   held;
    ctl_meter_held_t   prepared; /**< By ctl_meter_prepare. */
    ctl_meter_state_t  state;
} ctl_meter_t;

#define CTL_METER_RAD UINT32_C(105414357) /**< 2 pi 2^24, as in angle.h. */

typedef struct {
    num_t speed;  /**< Filtered speed, speed unit; its age is 1/2 + n1/2 samples. */
    num_t torque; /**< T_d, torque unit; its age is ctl_meter_age_half() half samples. */
} ctl_meter_out_t;

enum {
    CTL_METER_SPEED = 1,
    CTL_METER_TORQUE,
    CTL_METER_A22,
    CTL_METER_FIR1,
    CTL_METER_FIR2,
    CTL_METER_ACTUATION,
    CTL_METER_STEP
};

/** Validate, start at rest. On error @p self stays as it was. */
ctl_diag_t ctl_meter_init(ctl_meter_t *self, const ctl_meter_params_t *params);
/** What ctl_meter_init would say; @p params is not NULL. Needs no object. */
ctl_diag_t ctl_meter_check(const ctl_meter_params_t *params);
/** Other parameters, that ctl_meter_init would accept, without a break in the samples; the orders must be those of before. */
void ctl_meter_tune(ctl_meter_t *self, const ctl_meter_params_t *params);
/**
 * ctl_meter_tune while both filters stay, in two parts: prepare writes what ctl_meter_step does not read; take_prepared
 * takes it over, with the same parameters, while no step runs.
 */
void               ctl_meter_prepare(ctl_meter_t *self, const ctl_meter_params_t *params);
static inline void ctl_meter_take_prepared(ctl_meter_t *self, const ctl_meter_params_t *params)
{
    ctl_meter_params_t *const p = &self->params;
    p->speed_per_rad = params->speed_per_rad;
    p->torque_per_16 = params->torque_per_16;
    p->a22 = params->a22;
    p->actuation = params->actuation;
    p->step_max_rad = params->step_max_rad;
    self->held = self->prepared;
}
void ctl_meter_reset(ctl_meter_t *self);
/** Age of the torque, half samples: 2 + n1 + n2. */
uint16_t ctl_meter_age_half(const ctl_meter_params_t *params);
/**
 * One sample.
 * @param theta    mechanical angle now.
 * @param ref_last torque reference issued in the last sample.
 */
ctl_meter_out_t ctl_meter_step(ctl_meter_t *self, angle_t theta, num_t ref_last);

/** T_d alone, for a finite reference. */
num_t ctl_meter_torque_unchecked(ctl_meter_t *self, angle_t theta, num_t ref_last);
/** (2), once after each ctl_meter_torque_unchecked; its age is 1/2 + n1/2 samples. */
num_t ctl_meter_speed_unchecked(ctl_meter_t *self);
/** After a pause in which nobody asked for the speed: its filter starts from the speed of now. */
void ctl_meter_resume_speed(ctl_meter_t *self);

/** What (4) filters, over 16; @p speed from (1). */
static inline num_t ctl_meter_gather(ctl_meter_t *self, angle_t theta, num_t speed, num_t ref_last)
{
    const ctl_meter_params_t *const p = &self->params;
    ctl_meter_state_t *const        s = &self->state;

    const num_t sum = num_mul(num_sub(speed, num_mul(p->a22, s->speed)), p->torque_per_16);
#ifdef EVENSPIN_FIXED
    s->below += (theta - s->theta) * CTL_METER_RAD; /* the lower half of the product in ctl_meter_travel */
#endif
    s->theta = theta;
    s->speed = speed;

    /* [0] of the window is the reference of sample k - 1, hence actuation + 1 is delay `actuation` there */
    const num_t *const newer = &ctl_window_push(&s->ref, num_mul(ref_last, NUM_C(0.0625f)))[self->held.whole];
    return num_sub(sum, num_mac(newer[0], self->held.part, num_sub(newer[1], newer[0])));
}

/** Angle since the last sample, rad. In fixed point what is below a step goes into the next sample: a step of the encoder is 804 and a
 *  quarter, and always cut alike it would be a speed that is wrong by some 10^-6, for which the rounding of the encoder is another one. */
static inline num_t ctl_meter_travel(const ctl_meter_t *self, angle_t theta)
{
#ifdef EVENSPIN_FIXED
    return (num_t)((((int64_t)(int32_t)(theta - self->state.theta) * (int64_t)CTL_METER_RAD) + self->state.below) >> 32);
#else
    return angle_to_rad_signed(theta - self->state.theta);
#endif
}

/** No first angle, no jump, steps below a quarter turn, and a filter that ctl_meter_torque_fast has the taps for. */
static inline bool ctl_meter_is_fast(const ctl_meter_t *self, num_t travel)
{
    return self->held.is_short & self->state.primed & (num_abs(travel) <= self->params.step_max_rad);
}

/** ctl_meter_torque_unchecked where ctl_meter_is_fast holds: 70 cycles less. disturbance.h decides when. */
static inline num_t ctl_meter_torque_fast(ctl_meter_t *self, angle_t theta, num_t travel, num_t ref_last)
{
    return ctl_fir_cascade_ten_pairs(
        &self->state.torque_fir, ctl_meter_gather(self, theta, num_mul(travel, self->params.speed_per_rad), ref_last)); /* (4) */
}

#endif
