/**
 * @file  control/motor/deadbeat.h
 * @brief Deadbeat control of the dq currents, with the computation delay taken care of by prediction.
 *
 *     i1 = i + T_s / L (v_last - R i + e(i) ) + c                       current at the next sample        (1)
 *     v  = L / T_s (i_ref - i1) + R i1 - e(i1) - c L / T_s              voltage for the period after it   (2)
 *     e_d = w Lq i_q,   e_q = -w (Ld i_d + psi)                                                           (3)
 *     c <- c + g (i - i1 of the last sample)                            what the model does not explain   (4)
 *
 * The voltage computed at k acts from k+1 to k+2 (v_last is the one acting now), and the current is at its reference
 * at k+2. R i and e are taken at the middle of the period, first order: at k+2 it is off by less than 0.1 % of the step
 * while w T_s < 0.06, by 0.3 % at 0.16. With g = 0 this is the textbook controller, whose errors of R, psi and, when
 * turning, L leave a steady-state error; (4) removes it: g is a pole at 1 - g.
 *
 * Robust   stable for L of the model over the true one between 0.2 and 1.8 with g = 0.1; 0.2 and 1.88 with 0.05; 0.31 and
 *          1.65 with 0.2; 0.58 and 1.4 with 0.5. The first answer to a step is that ratio times the step: 30 % too large
 *          an L overshoots by 30 %. With R, L, psi each off by 30 % it settles to 1 % within 40 samples
 *          (tests/control/motor/test_deadbeat.c, w T_s up to 0.16).
 * Source   Tang et al. 2020 section II (current references reached after a delay); the prediction is the common one, e.g.
 *          Moreno et al. 2009.
 * Total    non-finite currents count as predicted, references as the last; c and v stay bounded.
 * Cost     30 products, no division.
 */
#ifndef CONTROL_MOTOR_DEADBEAT_H
#define CONTROL_MOTOR_DEADBEAT_H

#include "control/motor/frames.h"
#include "control/numeric/diag.h"

typedef struct {
    num_t r;            /**< R, voltage over current unit, >= 0. */
    num_t ld_ts, lq_ts; /**< L / T_s, voltage over current unit, > 0. */
    num_t ts_ld, ts_lq; /**< T_s / L, current over voltage unit, > 0. */
    num_t w_ld, w_lq;   /**< L times electrical base speed: voltage per current and speed unit, >= 0. */
    num_t w_psi;        /**< psi times electrical base speed: voltage per speed unit, >= 0. */
    num_t correction;   /**< g, [0, 0.5]. */
    num_t c_max;        /**< Limit of c, current unit per sample, > 0. */
    num_t v_max;        /**< Limit of each voltage before the vector limit, > 0. */
} ctl_deadbeat_params_t;

typedef struct {
    ctl_dq_t predicted; /**< i1. */
    ctl_dq_t c;
    ctl_dq_t ref;
    bool     primed;
    uint32_t rejected;
} ctl_deadbeat_state_t;

typedef struct {
    ctl_deadbeat_params_t params;
    ctl_deadbeat_state_t  state;
} ctl_deadbeat_t;

enum { CTL_DEADBEAT_R = 1, CTL_DEADBEAT_LD, CTL_DEADBEAT_LQ, CTL_DEADBEAT_PSI, CTL_DEADBEAT_CORRECTION, CTL_DEADBEAT_LIMIT };

/** Validate, start from rest. On error @p self stays as it was. */
ctl_diag_t ctl_deadbeat_init(ctl_deadbeat_t *self, const ctl_deadbeat_params_t *params);
/** Start from rest; the count stays. */
void ctl_deadbeat_reset(ctl_deadbeat_state_t *state);
/**
 * One sample.
 * @param meas   currents now.
 * @param ref    wanted currents.
 * @param speed  speed, speed unit (the electrical factor is in w_ld, w_lq, w_psi).
 * @param v_last voltage acting now, as realised: what this returned in the last sample, after the limit.
 * @return voltage for the next period, before the vector limit.
 */
ctl_dq_t ctl_deadbeat_step(ctl_deadbeat_t *self, const ctl_dq_t *meas, const ctl_dq_t *ref, num_t speed, const ctl_dq_t *v_last);

/** (3) and the resistance: voltage that the winding takes besides L di/dt. */
static inline ctl_dq_t ctl_deadbeat_drop(const ctl_deadbeat_params_t *p, num_t i_d, num_t i_q, num_t w)
{
    const ctl_dq_t v = {num_sub(num_mul(p->r, i_d), num_mul(w, num_mul(p->w_lq, i_q))),
                        num_mac(num_mul(p->r, i_q), w, num_mac(p->w_psi, p->w_ld, i_d))};
    return v;
}

/** ctl_deadbeat_step for finite numbers, and parameters that ctl_deadbeat_init would accept; they may be other ones in each sample. */
static inline ctl_dq_t ctl_deadbeat_step_unchecked(const ctl_deadbeat_params_t *p, ctl_deadbeat_state_t *s, ctl_dq_t i,
                                                   ctl_dq_t ref, num_t w, ctl_dq_t v)
{
    if (s->primed) { /* (4) */
        s->c.d = num_clamp(num_mac(s->c.d, p->correction, num_sub(i.d, s->predicted.d)), num_neg(p->c_max), p->c_max);
        s->c.q = num_clamp(num_mac(s->c.q, p->correction, num_sub(i.q, s->predicted.q)), num_neg(p->c_max), p->c_max);
    }
    s->primed = true;

    /* (1): a first guess with the drop of now, then with the drop in the middle of the travel */
    const ctl_dq_t now = ctl_deadbeat_drop(p, i.d, i.q, w);
    const num_t    rise_d = num_mac(s->c.d, p->ts_ld, num_sub(v.d, now.d));
    const num_t    rise_q = num_mac(s->c.q, p->ts_lq, num_sub(v.q, now.q));
    const ctl_dq_t mid = ctl_deadbeat_drop(p, num_mac(i.d, NUM_C(0.5f), rise_d), num_mac(i.q, NUM_C(0.5f), rise_q), w);
    const ctl_dq_t i1 = {num_add(num_mac(i.d, p->ts_ld, num_sub(v.d, mid.d)), s->c.d),
                         num_add(num_mac(i.q, p->ts_lq, num_sub(v.q, mid.q)), s->c.q)};

    /* (2), the drop in the middle between i1 and the reference */
    const ctl_dq_t later =
        ctl_deadbeat_drop(p, num_mul(num_add(i1.d, ref.d), NUM_C(0.5f)), num_mul(num_add(i1.q, ref.q), NUM_C(0.5f)), w);
    const ctl_dq_t out = {
        num_clamp(num_mac(later.d, p->ld_ts, num_sub(num_sub(ref.d, i1.d), s->c.d)), num_neg(p->v_max), p->v_max),
        num_clamp(num_mac(later.q, p->lq_ts, num_sub(num_sub(ref.q, i1.q), s->c.q)), num_neg(p->v_max), p->v_max),
    };
    s->predicted = i1;
    s->ref = ref;
    return out;
}

#endif
