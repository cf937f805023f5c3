/**
 * @file  control/motor/frames.h
 * @brief Clarke and Park transforms and their inverses, amplitude-invariant.
 *
 *     alpha = (2 a - b - c) / 3        beta = (b - c) / sqrt(3)                                          (1)
 *     d = alpha cos + beta sin         q = beta cos - alpha sin                                          (2)
 *
 * d lies on the magnet flux, phase a on alpha; see control/conventions.md. Units pass through.
 * Total    a component that is not finite is replaced by 0 and the function returns false: the caller counts.
 * Cost     4 products each; the sine and cosine come from angle_sincos once per interrupt.
 */
#ifndef CONTROL_MOTOR_FRAMES_H
#define CONTROL_MOTOR_FRAMES_H

#include "control/numeric/num.h"

typedef struct {
    num_t a, b, c;
} ctl_abc_t;
typedef struct {
    num_t alpha, beta;
} ctl_ab_t;
typedef struct {
    num_t d, q;
} ctl_dq_t;
typedef struct {
    num_t sine, cosine;
} ctl_rotor_t;

/** (1). A common part of a, b, c has no effect. */
bool ctl_clarke(const ctl_abc_t *in, ctl_ab_t *out);
/** Inverse of (1) with a + b + c = 0. */
bool ctl_inverse_clarke(const ctl_ab_t *in, ctl_abc_t *out);
/** (2). @param rotor sine and cosine of the electrical angle, each within +-1. */
bool ctl_park(const ctl_ab_t *in, const ctl_rotor_t *rotor, ctl_dq_t *out);
/** Inverse of (2). */
bool ctl_inverse_park(const ctl_dq_t *in, const ctl_rotor_t *rotor, ctl_ab_t *out);

#endif
