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

/** Clarke transform, (1) of this header. A common part of a, b, c has no effect. */
bool ctl_clarke(const ctl_abc_t *in, ctl_ab_t *out);
/** Inverse Clarke transform, with a + b + c = 0. */
bool ctl_inverse_clarke(const ctl_ab_t *in, ctl_abc_t *out);
/** Park transform, (2) of this header. @param rotor sine and cosine of the electrical angle, each within +-1. */
bool ctl_park(const ctl_ab_t *in, const ctl_rotor_t *rotor, ctl_dq_t *out);
/** Inverse Park transform. */
bool ctl_inverse_park(const ctl_dq_t *in, const ctl_rotor_t *rotor, ctl_ab_t *out);

static inline ctl_ab_t ctl_clarke_unchecked(ctl_abc_t x)
{
    /* differences first: a fixed-point sum 2 a - b - c would saturate before it is divided */
    const ctl_ab_t out = {num_mul(num_add(num_sub(x.a, x.b), num_sub(x.a, x.c)), NUM_C(0.33333333333f)),
                          num_mul(num_sub(x.b, x.c), NUM_C(0.57735026919f))}; /* 1 / 3, 1 / sqrt(3) */
    return out;
}
static inline ctl_abc_t ctl_inverse_clarke_unchecked(ctl_ab_t x)
{
    const num_t     half = num_mul(x.alpha, NUM_C(-0.5f));
    const num_t     side = num_mul(x.beta, NUM_C(0.86602540378f)); /* sqrt(3) / 2 */
    const ctl_abc_t out = {x.alpha, num_add(half, side), num_sub(half, side)};
    return out;
}
static inline ctl_dq_t ctl_park_unchecked(ctl_ab_t x, ctl_rotor_t r)
{
    const ctl_dq_t out = {num_add(num_mul(x.alpha, r.cosine), num_mul(x.beta, r.sine)),
                          num_sub(num_mul(x.beta, r.cosine), num_mul(x.alpha, r.sine))};
    return out;
}
static inline ctl_ab_t ctl_inverse_park_unchecked(ctl_dq_t x, ctl_rotor_t r)
{
    const ctl_ab_t out = {num_sub(num_mul(x.d, r.cosine), num_mul(x.q, r.sine)),
                          num_add(num_mul(x.d, r.sine), num_mul(x.q, r.cosine))};
    return out;
}

#endif
