/**
 * @file  control/observer/torque_meter.h
 * @brief The disturbance torque that moves the shaft, "measured" from the encoder and the torque reference.
 *
 *     w[k]     = (theta[k] - theta[k-1]) / T_s                              age 1/2                      (1)
 *     w_f      = FIR1(w)                                                    + n1 / 2                     (2)
 *     T_sum[k] = (w_f[k] - a22 w_f[k-1]) / a23                              + 1/2                        (3)
 *     T_d      = FIR2( T_sum - FIR1(T_ref delayed) )                        + n2 / 2                     (4)
 *
 * Torque is counted in the unit of the torque reference, usually ampere of q current: then a23 = T_s k_T / J.
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
 * Cost     three FIR filters and 4 products.
 */
#ifndef CONTROL_OBSERVER_TORQUE_METER_H
#define CONTROL_OBSERVER_TORQUE_METER_H

#include "control/numeric/angle.h"
#include "control/observer/fir.h"

typedef struct {
    num_t            speed_per_rad;  /**< Speed unit per rad and sample: 1 / (T_s base), > 0. */
    num_t            torque_per_16;  /**< 1 / (16 a23): torque unit per speed unit and sample, over 16; > 0. */
    num_t            a22;            /**< 1 - B T_s / J, [0, 1]. */
    ctl_fir_params_t fir1, fir2;
    num_t            actuation;      /**< Samples from a reference to the middle of its action, [0.5, 12]. */
    num_t            step_max_rad;   /**< Largest angle between two samples, (0, pi]. */
} ctl_meter_params_t;

typedef struct {
    ctl_fir_t    speed_fir, torque_fir, ref_fir;
    ctl_window_t ref;             /**< Newest references. */
    angle_t      theta;
    num_t        step_rad, speed; /**< Last step and last filtered speed. */
    bool         primed;
    uint32_t     rejected;
} ctl_meter_state_t;

typedef struct {
    ctl_meter_params_t params;
    uint16_t           held_whole; /**< params.actuation in samples... */
    num_t              held_part;  /**< ...and what is left, [0, 1). */
    ctl_meter_state_t  state;
} ctl_meter_t;

typedef struct {
    num_t speed;  /**< Filtered speed, speed unit; its age is 1/2 + n1/2 samples. */
    num_t torque; /**< T_d, torque unit; its age is ctl_meter_age_half() half samples. */
} ctl_meter_out_t;

enum { CTL_METER_SPEED = 1, CTL_METER_TORQUE, CTL_METER_A22, CTL_METER_FIR1, CTL_METER_FIR2, CTL_METER_ACTUATION, CTL_METER_STEP };

/** Validate, start at rest. On error @p self stays as it was. */
ctl_diag_t ctl_meter_init(ctl_meter_t *self, const ctl_meter_params_t *params);
/** Other parameters, that ctl_meter_init would accept, without a break in the samples; the orders must be those of before. */
void       ctl_meter_tune(ctl_meter_t *self, const ctl_meter_params_t *params);
void       ctl_meter_reset(ctl_meter_t *self);
/** Age of the torque, half samples: 2 + n1 + n2. */
uint16_t ctl_meter_age_half(const ctl_meter_params_t *params);
/**
 * One sample.
 * @param theta    mechanical angle now.
 * @param ref_last torque reference issued in the last sample.
 */
ctl_meter_out_t ctl_meter_step(ctl_meter_t *self, angle_t theta, num_t ref_last);

static inline ctl_meter_out_t ctl_meter_step_raw(ctl_meter_t *self, angle_t theta, num_t ref_last)
{
    const ctl_meter_params_t *const p = &self->params;
    ctl_meter_state_t *const        s = &self->state;

    if (!s->primed) {
        s->primed = true;
        s->theta = theta;
    }
    const num_t step = angle_to_rad_signed(theta - s->theta);
    if (num_abs(step) <= p->step_max_rad) {
        s->step_rad = step;
    } else {
        num_count(&s->rejected);
    }
    s->theta = theta;

    /* (1) to (3) */
    const num_t speed = ctl_fir_step_raw(&s->speed_fir, num_mul(s->step_rad, p->speed_per_rad));
    const num_t gained = num_sub(speed, num_mul(p->a22, s->speed));
    const num_t sum = num_mul(num_mul(gained, p->torque_per_16), NUM_C(16.0f));
    s->speed = speed;

    /* [0] of the window is the reference of sample k - 1, hence actuation + 1 is delay `actuation` there */
    const num_t *const young = &ctl_window_push(&s->ref, ref_last)[self->held_whole];
    const num_t        held = num_mac(young[0], self->held_part, num_sub(young[1], young[0]));

    const ctl_meter_out_t out = {speed, ctl_fir_step_raw(&s->torque_fir, num_sub(sum, ctl_fir_step_raw(&s->ref_fir, held)))}; /* (4) */
    return out;
}

#endif
