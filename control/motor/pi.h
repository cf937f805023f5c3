/**
 * @file  control/motor/pi.h
 * @brief Parallel PI controller with conditional anti-windup, split in a proposal and a commitment.
 *
 *     u[k] = clamp( k_p e[k] + x[k] )                                                                    (1)
 *     x[k+1] = x[k] + k_i T_s e[k], unless the output was limited                                        (2)
 *
 * ctl_pi_output proposes u; the caller applies what the actuator allows and passes to ctl_pi_commit what it really did.
 * "Limited" means: the value committed is not the one computed before the clamp.
 *
 *   CTL_PI_HOLD          x holds whenever the output was limited
 *   CTL_PI_HOLD_OUTWARD  x holds only when the error pushes further into the limit
 *
 * Total    a non-finite error is not integrated, is counted, and the output is that of a zero error; x stays within
 *          the output limits' larger magnitude, so it is bounded whatever is committed.
 *          In fixed point ctl_pi_commit keeps what is below a step of x for the next sample: an error whose k_i T_s e is less than that is
 *          integrated, too, and the mean error is 0 (without: 4e-4 rad/s at 200 rad/s with ARO, which is sensitive to 1e-6 of the speed).
 * Cost     output 1 product, commit 1 product. Float and fixed agree within 1e-6 of full scale per step.
 */
#ifndef CONTROL_MOTOR_PI_H
#define CONTROL_MOTOR_PI_H

#include "control/numeric/diag.h"

typedef enum { CTL_PI_HOLD = 0, CTL_PI_HOLD_OUTWARD } ctl_pi_anti_windup_t;

typedef struct {
    num_t                kp;      /**< Output unit per error unit, >= 0. */
    num_t                ki_ts;   /**< k_i T_s, output unit per error unit and sample, >= 0. */
    num_t                out_min; /**< Output unit, < out_max. */
    num_t                out_max; /**< Output unit. */
    ctl_pi_anti_windup_t anti_windup;
} ctl_pi_params_t;

typedef struct {
    num_t    x;        /**< Integrator, output unit. */
    num_t    err;      /**< Error of the last proposal. */
    num_t    wanted;   /**< Last proposal before the clamp. */
    uint32_t rejected; /**< Inputs that were not finite. */
#ifdef EVENSPIN_FIXED
    int32_t below; /**< What x lacks, 2^-24 of its step, [0, 2^24). */
#endif
} ctl_pi_state_t;

typedef struct {
    ctl_pi_params_t params;
    num_t           bound; /**< Of x: the larger of the two output limits. */
    ctl_pi_state_t  state;
} ctl_pi_t;

enum { CTL_PI_KP = 1, CTL_PI_KI_TS, CTL_PI_OUT_MIN, CTL_PI_OUT_MAX, CTL_PI_ANTI_WINDUP };

/** Validate, start from rest. On error @p self stays as it was. */
ctl_diag_t ctl_pi_init(ctl_pi_t *self, const ctl_pi_params_t *params);
/** Other parameters, that ctl_pi_init would accept; the state goes on. */
static inline void ctl_pi_tune(ctl_pi_t *self, const ctl_pi_params_t *params)
{
    self->params = *params;
    self->bound = num_max(num_abs(params->out_min), num_abs(params->out_max));
}
/** ctl_pi_tune when only the gains differ. */
static inline void ctl_pi_tune_gains(ctl_pi_t *self, const ctl_pi_params_t *params)
{
    self->params.kp = params->kp;
    self->params.ki_ts = params->ki_ts;
}
/** Start again with integrator @p x (clamped to the limits; 0 when not finite). Counters stay. */
void ctl_pi_reset(ctl_pi_t *self, num_t x);
/** (1): proposal for this sample, within the limits. */
num_t ctl_pi_output(ctl_pi_t *self, num_t err);
/** (2): @p realised is what the actuator did, output unit. Once per ctl_pi_output. */
void ctl_pi_commit(ctl_pi_t *self, num_t realised);
/** Instead of a commit: the integrator holds, whatever the mode. For a vector limited as a whole. */
static inline void ctl_pi_hold(ctl_pi_t *self) { self->state.err = (num_t)0; }

/** (1) without the limits, for an output that is limited as a vector; nothing is noted. Together with ctl_pi_learn_unchecked it
 *  costs 60 cycles less than ctl_pi_output and ctl_pi_commit, on each of two axes in every current period. */
static inline num_t ctl_pi_propose_unchecked(const ctl_pi_t *self, num_t err)
{
    return num_mac(self->state.x, self->params.kp, err);
}
/** (2) for the error of such a proposal, when it was not limited. */
static inline void ctl_pi_learn_unchecked(ctl_pi_t *self, num_t err)
{
    self->state.x = num_clamp(num_mac(self->state.x, self->params.ki_ts, err), num_neg(self->bound), self->bound);
}

#endif
