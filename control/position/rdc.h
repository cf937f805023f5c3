/**
 * @file  control/position/rdc.h
 * @brief Robust driving control: feed-forward of the whole machine on the command, and a bounded term against what
 *        the model gets wrong.
 *
 *     I_a = ( J a_r + B v_r + T_sc(v_r) + sum L_i sin(w_i theta_r + phi_i) + delta ) / K_i               (1)
 *     s = ( P31 x1 + P32 x2 + P33 x3 ) / J,   x = [ integral of (theta - theta_r), theta - theta_r, v - v_r ]   (2)
 *     delta = -rho sgn(s) for |s| > sigma,  -rho s / sigma inside                                        (3)
 *
 * P solves A^T P + P A = -q I for the error equation (`evenspin design rdc`). Too large a rho / sigma chatters: that
 * command computes the limit, which falls with the delay of the torque.
 *
 * Source   Yeh and Liu 2025, equations 7, 26 to 32. The torque unit is the caller's (ampere in the drive: divided by K_i).
 * Total    non-finite input counts as 0 and is counted; |delta| <= rho.
 * Cost     friction, a sine per line, 10 products. The command's speed 0 gives no friction but keeps the lines.
 */
#ifndef CONTROL_POSITION_RDC_H
#define CONTROL_POSITION_RDC_H

#include "control/position/friction.h"
#include "control/position/harmonics.h"
#include "control/position/profile.h"

typedef struct {
    num_t           inertia; /**< J: torque per acceleration unit, >= 0. */
    ctl_friction_t  friction;
    ctl_harmonics_t harmonics;
    num_t           p_row[3];     /**< P31, P32, P33 over J, per rad s, rad, speed unit. */
    num_t           rho;          /**< Bound of the robust term, torque unit, >= 0. */
    num_t           sigma;        /**< Half width of its linear part, > 0. */
    num_t           sample_s;     /**< T_s, s, > 0. */
    num_t           integral_max; /**< Limit of x1, rad s, > 0. */
} ctl_rdc_params_t;

typedef struct {
    num_t    x1;
    num_t    robust; /**< Last delta. */
    num_t    fed; /**< Last friction without its viscous part, and lines: what an observer of the disturbance torque would see. */
    uint32_t rejected;
} ctl_rdc_state_t;

typedef struct {
    ctl_rdc_params_t params;
    ctl_rdc_state_t  state;
} ctl_rdc_t;

enum {
    CTL_RDC_INERTIA = 1,
    CTL_RDC_FRICTION,
    CTL_RDC_STATIC,
    CTL_RDC_HARMONICS,
    CTL_RDC_P,
    CTL_RDC_RHO,
    CTL_RDC_SIGMA,
    CTL_RDC_SAMPLE
};

/** Validate, start from rest. On error @p self stays as it was. */
ctl_diag_t ctl_rdc_init(ctl_rdc_t *self, const ctl_rdc_params_t *params);
/** Start from rest; the count stays. */
void ctl_rdc_reset(ctl_rdc_state_t *state);
/** (3) for a given s. */
num_t ctl_rdc_robust(num_t s, num_t rho, num_t sigma);
/** One sample. @param error theta - theta_r, rad. @param speed_error v - v_r. @return I_a. */
num_t ctl_rdc_step(ctl_rdc_t *self, const ctl_setpoint_t *command, num_t error, num_t speed_error);

/** ctl_rdc_step for finite numbers, and parameters that ctl_rdc_init would accept; they may be other ones in each sample. */
static inline num_t ctl_rdc_step_unchecked(const ctl_rdc_params_t *p, ctl_rdc_state_t *s, const ctl_setpoint_t *command,
                                           num_t error, num_t speed_error)
{
    s->x1 = num_clamp(num_mac(s->x1, p->sample_s, error), num_neg(p->integral_max), p->integral_max);
    const num_t measure = num_mac(num_mac(num_mul(p->p_row[0], s->x1), p->p_row[1], error), p->p_row[2], speed_error);
    s->robust = num_neg(num_mul(p->rho, num_clamp(num_quotient(measure, p->sigma), NUM_C(-1.0f), NUM_C(1.0f)))); /* (3) */

    const num_t known =
        num_add(ctl_friction_unchecked(&p->friction, command->speed), ctl_harmonics(&p->harmonics, command->position));
    s->fed = num_sub(known, num_mul(p->friction.viscous, command->speed));
    return num_add(num_mac(known, p->inertia, command->acceleration), s->robust);
}

#endif
