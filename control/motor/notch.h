/**
 * @file  control/motor/notch.h
 * @brief Notch filter: takes a band around one frequency out of a signal, and leaves mean and all else.
 *
 *     H(s) = (s^2 + 2 depth damping w s + w^2) / (s^2 + 2 damping w s + w^2)                             (1)
 *
 * by the bilinear transform, exact at w: gain `depth` there, 1 at zero and at half the sample rate. As the mean of the signal and of an
 * all-pass A, which has gain 1 at every frequency and turns the signal over at w (Regalia and Mitra 1987):
 *
 *     y = m x + (1 - m) A x,   A = (a2 + a1 z^-1 + z^-2) / (1 + a1 z^-1 + a2 z^-2)                       (2)
 *
 * Its states are inputs and outputs of A and so never larger than these, however low w is.
 *
 * Total    a value that is not finite counts as the one before; the output stays within 8 times the largest input for damping >= 0.05.
 * Cost     3 products. Float and fixed agree within 2e-5 of the input from 1/100 of the sample rate on.
 */
#ifndef CONTROL_MOTOR_NOTCH_H
#define CONTROL_MOTOR_NOTCH_H

#include "control/numeric/diag.h"

typedef struct {
    num_t a1, a2; /**< Of the all-pass: a2 in (-1, 1), |a1| < 1 + a2. */
    num_t mean;   /**< m = (1 + depth) / 2, [0.5, 1]. */
} ctl_notch_params_t;

typedef struct {
    num_t in[2], out[2]; /**< Of the all-pass; the newest first. */
} ctl_notch_state_t;

enum { CTL_NOTCH_A1 = 1, CTL_NOTCH_A2, CTL_NOTCH_MEAN };

/** (2) from (1). Main loop. @param cycles  of w per sample, (0, 0.5). @param damping  of (1), > 0: half of the width over w. @param depth  [0, 1]. */
void ctl_notch_design(ctl_notch_params_t *p, float cycles, float damping, float depth);
/** Whether these parameters make a stable filter. */
ctl_diag_t ctl_notch_check(const ctl_notch_params_t *p);
/** As after a long time at @p x, which has to be finite. */
static inline void ctl_notch_reset(ctl_notch_state_t *s, num_t x)
{
    s->in[0] = x;
    s->in[1] = x;
    s->out[0] = x;
    s->out[1] = x;
}
/** (2) for a finite input, of parameters that ctl_notch_check accepts. */
static inline num_t ctl_notch_step_unchecked(const ctl_notch_params_t *p, ctl_notch_state_t *s, num_t x)
{
    const num_t late = num_mac(s->in[1], p->a1, num_sub(s->in[0], s->out[0]));
    const num_t turned = num_mac(late, p->a2, num_sub(x, s->out[1]));
    s->in[1] = s->in[0];
    s->in[0] = x;
    s->out[1] = s->out[0];
    s->out[0] = turned;
    return num_mac(turned, p->mean, num_sub(x, turned));
}
/** (2) for any input. */
num_t ctl_notch_step(const ctl_notch_params_t *p, ctl_notch_state_t *s, num_t x);

#endif
