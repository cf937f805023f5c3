/**
 * @file  control/motor/plausibility.h
 * @brief Whether voltages, currents and angle can belong to the windings of this motor: a dead or wrong current sensor, an open
 *        phase, a switch that stays open, an encoder that does not turn with the rotor.
 *
 *     flux(k) = L i(k) + psi (cos, sin)(angle(k))                         stationary frame, L by axis                (1)
 *     r(k)    = flux(k) - flux(k-1) - T_s (v - R (i(k) + i(k-1)) / 2)     v acted from k-1 to k                      (2)
 *     e(k)    = 3/4 e(k-1) + r(k)                                         the last four periods                      (3)
 *     a(k)    = 3/4 a(k-1) + rest + dR |i| + dL |i(k) - i(k-1)| + dpsi |w| + dv |v| + dc v_dc + dt |v(k+1) - v(k)|   (4)
 *
 * The stator voltage stands over a period and the angle is measured at both ends of it, so (2) is exact but for the resistive
 * drop, and needs no speed: it is zero in every transient of the motor that the parameters describe. (4) is what it may be instead:
 * the error of each parameter times what it acts on, dead time and noise; both are measured by |x| = |alpha| + |beta|. More than
 * that in two samples in a row cannot be this motor; a disturbed single sample can, and is no reason to stop.
 *
 * Sees     what makes the wrong share of a current or voltage larger than the tolerances: a jump of a reading at once, a wrong
 *          gain while current flows and the motor turns. Not seen: an error while no current flows, and less than the tolerances.
 * Units    current unit times a reference inductance, which the caller takes so large that psi and T_s v stay in range.
 * Source   The voltage equation in flux form, e.g. Moreno et al. 2009; tolerances summed, not squared.
 * Total    the checked step counts what is not a number as a sample that cannot be; error and allowance stay bounded.
 * Cost     25 products, no division.
 */
#ifndef CONTROL_MOTOR_PLAUSIBILITY_H
#define CONTROL_MOTOR_PLAUSIBILITY_H

#include "control/motor/frames.h"
#include "control/numeric/diag.h"

#define CTL_PLAUSIBILITY_KEEP NUM_C(0.75f) /**< Of (3) and (4). */
#define CTL_PLAUSIBILITY_SKIP 3U           /**< Samples until the voltages of a start are known. */
#define CTL_PLAUSIBILITY_AGAINST 2U        /**< Samples in a row. */
#ifdef EVENSPIN_FIXED
#define CTL_PLAUSIBILITY_MOST NUM_C(100.0f)
#else
#define CTL_PLAUSIBILITY_MOST 1.0e11f /**< Beyond it no allowance reaches: there what is not a number would be within its like. */
#endif

typedef struct {
    num_t ld, lq;          /**< Over the reference inductance, > 0. */
    num_t psi;             /**< >= 0. */
    num_t r_half;          /**< R T_s / 2, >= 0. */
    num_t v;               /**< T_s per voltage unit, > 0. */
    num_t rest;            /**< Allowed in every sample: noise of the currents, a count of the encoder; > 0. */
    num_t per_current;     /**< dR T_s. */
    num_t per_change;      /**< dL, error of the inductance. */
    num_t per_speed;       /**< dpsi: error of psi and of the angle, electrical speed included. */
    num_t per_volt;        /**< dv: error of the measured dc link. */
    num_t per_dc;          /**< dc: dead time and what the switches drop. */
    num_t per_volt_change; /**< dt: part of a period by which the voltage may come late. */
} ctl_plausibility_params_t;

typedef struct {
    ctl_ab_t error;        /**< e. */
    ctl_ab_t before;       /**< flux - R T_s i / 2 of the last sample. */
    ctl_ab_t current;      /**< Of the last sample. */
    ctl_ab_t acting, next; /**< Voltage after the last sample, and after the one to come. */
    num_t    allowed;      /**< a. */
    uint16_t skip;         /**< Samples until the next verdict. */
    uint16_t against;      /**< Samples in a row that cannot be. */
} ctl_plausibility_state_t;

typedef struct {
    ctl_plausibility_params_t params;
    ctl_plausibility_state_t  state;
} ctl_plausibility_t;

/** What there is in a sample. */
typedef struct {
    ctl_dq_t    current_dq; /**< Measured, in the frame of `rotor`. */
    ctl_rotor_t rotor;      /**< Electrical angle of the sample. */
    num_t       speed;      /**< Mechanical; only its size matters. */
    num_t       v_dc;       /**< Dc link, voltage unit. */
    ctl_ab_t    volt;       /**< Calculated from this sample: acts after the next one. */
} ctl_plausibility_in_t;

/** Validate; begin without knowledge. On error @p self stays as it was. The field of the diagnosis: 1 ld, 2 lq, and so on. */
ctl_diag_t ctl_plausibility_init(ctl_plausibility_t *self, const ctl_plausibility_params_t *params);
/** One sample, any input. @return false when this and the last sample cannot belong to the motor. */
bool ctl_plausibility_step(ctl_plausibility_t *self, const ctl_plausibility_in_t *in);

/** Begin again: the bridge was off, or samples are missing. Without voltage until the next call of the step. */
static inline void ctl_plausibility_restart(ctl_plausibility_state_t *s)
{
    const ctl_ab_t zero = {(num_t)0, (num_t)0};
    s->next = zero;
    s->skip = CTL_PLAUSIBILITY_SKIP;
}

static inline num_t ctl_plausibility_size(num_t alpha, num_t beta) { return num_add(num_abs(alpha), num_abs(beta)); }

/** ctl_plausibility_step for parameters that ctl_plausibility_init would accept, other ones in each sample if need be. What is not a
 *  number is found as well: no comparison holds with it. */
static inline bool ctl_plausibility_step_unchecked(const ctl_plausibility_params_t *p, ctl_plausibility_state_t *s,
                                                   const ctl_plausibility_in_t *in)
{
    const ctl_ab_t i = ctl_inverse_park_unchecked(in->current_dq, in->rotor);
    const ctl_ab_t v = s->next;
    const ctl_ab_t old = s->acting;
    const ctl_dq_t linked = {num_mac(p->psi, p->ld, in->current_dq.d), num_mul(p->lq, in->current_dq.q)};
    const ctl_ab_t flux = ctl_inverse_park_unchecked(linked, in->rotor);
    const ctl_ab_t drop = {num_mul(p->r_half, i.alpha), num_mul(p->r_half, i.beta)};
    const ctl_ab_t step = {num_sub(num_sub(num_add(flux.alpha, drop.alpha), s->before.alpha), num_mul(p->v, old.alpha)),
                           num_sub(num_sub(num_add(flux.beta, drop.beta), s->before.beta), num_mul(p->v, old.beta))};
    num_t          may = num_mac(p->rest, p->per_dc, in->v_dc);
    may = num_mac(may, p->per_speed, num_abs(in->speed));
    may = num_mac(may, p->per_current, ctl_plausibility_size(i.alpha, i.beta));
    may = num_mac(may, p->per_change,
                  ctl_plausibility_size(num_sub(i.alpha, s->current.alpha), num_sub(i.beta, s->current.beta)));
    may = num_mac(may, p->per_volt, ctl_plausibility_size(old.alpha, old.beta));
    may = num_mac(may, p->per_volt_change, ctl_plausibility_size(num_sub(v.alpha, old.alpha), num_sub(v.beta, old.beta)));

    s->before.alpha = num_sub(flux.alpha, drop.alpha);
    s->before.beta = num_sub(flux.beta, drop.beta);
    s->current = i;
    s->acting = v;
    s->next = in->volt;
    if (s->skip != 0U) {
        s->skip--;
        s->error.alpha = (num_t)0;
        s->error.beta = (num_t)0;
        s->allowed = num_mul(NUM_C(4.0f), may); /* as if it had always been so */
        s->against = 0U;
        return true;
    }
    s->error.alpha = num_mac(step.alpha, CTL_PLAUSIBILITY_KEEP, s->error.alpha);
    s->error.beta = num_mac(step.beta, CTL_PLAUSIBILITY_KEEP, s->error.beta);
    s->allowed = num_mac(may, CTL_PLAUSIBILITY_KEEP, s->allowed);
    if (ctl_plausibility_size(s->error.alpha, s->error.beta) <= num_min(s->allowed, CTL_PLAUSIBILITY_MOST)) {
        s->against = 0U;
        return true;
    }
    s->against++;
    return s->against < CTL_PLAUSIBILITY_AGAINST;
}

#endif
