/**
 * @file  control/position/friction.h
 * @brief Friction over speed: viscous, Coulomb, and the Stribeck rise towards standstill.
 *
 *     T = B v + [ T_c + (T_s - T_c) exp( -(|v| / v_s)^delta ) ] sgn(v)                                   (1)
 *
 * sgn(0) = 0: at standstill it gives nothing. T_s is the whole static friction, not the part above Coulomb's.
 * Source   Yeh and Liu 2024, equations 1 and 2.
 * Total    a non-finite speed gives 0; |T| <= T_s + B |v|.
 * Cost     num_pow and num_exp2: about 45 operations, no libm. Float: 1e-5 of T_s.
 */
#ifndef CONTROL_POSITION_FRICTION_H
#define CONTROL_POSITION_FRICTION_H

#include "control/numeric/diag.h"
#include "control/numeric/num_math.h"

typedef struct {
    num_t viscous;  /**< B, torque per speed unit, >= 0. */
    num_t coulomb;  /**< T_c, torque unit, >= 0. */
    num_t stat;     /**< T_s, torque unit, >= T_c. */
    num_t stribeck; /**< v_s, speed unit, > 0. */
    num_t shape;    /**< delta, [0.1, 10]. */
} ctl_friction_t;

enum { CTL_FRICTION_VISCOUS = 1, CTL_FRICTION_COULOMB, CTL_FRICTION_STATIC, CTL_FRICTION_STRIBECK, CTL_FRICTION_SHAPE };

/** Are these parameters good? */
ctl_diag_t ctl_friction_check(const ctl_friction_t *p);
/** (1) for parameters that ctl_friction_check accepted. */
num_t ctl_friction(const ctl_friction_t *p, num_t speed);

static inline num_t ctl_friction_unchecked(const ctl_friction_t *p, num_t speed)
{
    const num_t size = num_abs(speed);
    const num_t share = num_clamp(num_quotient(size, p->stribeck), NUM_EPS, NUM_MAX);
    const num_t decay = num_exp2_unchecked(num_neg(num_mul(num_pow_unchecked(share, p->shape), NUM_C(1.44269504f)))); /* log2 e */
    const num_t rise = num_mul(num_sub(p->stat, p->coulomb), decay);
    const num_t sign = (speed > (num_t)0) ? NUM_C(1.0f) : ((speed < (num_t)0) ? NUM_C(-1.0f) : (num_t)0);
    return num_mac(num_mul(num_add(p->coulomb, rise), sign), p->viscous, speed);
}

#endif
