/**
 * @file  control/motor/svm.h
 * @brief Voltage vector limit and space-vector modulation.
 *
 *     duty_x = 1/2 + (v_x - (max(v) + min(v)) / 2) / v_dc,   x = a, b, c                                 (1)
 *
 * The common part that (1) adds (centred zero vectors) makes every vector up to v_dc / sqrt(3) reachable; the
 * phase-to-phase voltages are exactly those asked for. Beyond, duties clip at 0 and 1.
 *
 * Total    non-finite input gives a zero vector / duties of 1/2 and false: the caller counts.
 * Cost     limit: 1 product, and only when limited 4 more, a root and 3 divisions; modulation: 1 division, 6 products.
 * Error    of a duty below 4e-7 (float: 3e-7) for voltages up to v_dc; the cut vector is long by 4e-7 at most.
 */
#ifndef CONTROL_MOTOR_SVM_H
#define CONTROL_MOTOR_SVM_H

#include "control/motor/frames.h"
#include "control/numeric/num_math.h"

/**
 * Shorten @p v to at most @p limit (>= 0, same unit), keeping its direction.
 * @return true when the vector was good and is unchanged, bit for bit; false when it was shortened or replaced.
 */
bool ctl_vector_limit(const ctl_dq_t *v, num_t limit, ctl_dq_t *out);

/**
 * Duty cycles within [0, 1] for a voltage vector.
 * @param v_dc  dc-link voltage, same unit as @p v, > 0.
 * @return false when an input was not usable; all duties are then 1/2 (zero voltage).
 */
bool ctl_svm(const ctl_ab_t *v, num_t v_dc, ctl_abc_t *duty);

#define CTL_VECTOR_NONE_SQUARED 1.0e-36f

/**
 * ctl_vector_limit of finite inputs; float: 90 cycles less. Lengths up to 1e12, limits from 0 to 1e12. What is below 1e-18 counts as none: such a
 * length stays, whatever the limit, and such a limit leaves at most 1e-18.
 */
static inline bool ctl_vector_limit_unchecked(ctl_dq_t v, num_t limit, ctl_dq_t *out)
{
#ifdef EVENSPIN_FIXED
    return ctl_vector_limit(&v, limit, out);
#else
    const num_t square = (v.d * v.d) + (v.q * v.q);
    if (square <= num_max(limit * limit, CTL_VECTOR_NONE_SQUARED)) {
        *out = v;
        return true;
    }
    const num_t scale = limit / num_sqrt_unchecked(square);
    out->d = v.d * scale;
    out->q = v.q * scale;
    return false;
#endif
}

/** ctl_svm of finite inputs, without the clip at 0 and 1, for an actuator that clips: 40 cycles less than ctl_svm. */
static inline ctl_abc_t ctl_svm_unchecked(ctl_ab_t v, num_t v_dc)
{
    const num_t     scale = num_quotient(NUM_C(1.0f), v_dc);
    const ctl_ab_t  of_dc = {num_mul(v.alpha, scale), num_mul(v.beta, scale)};
    const ctl_abc_t x = ctl_inverse_clarke_unchecked(of_dc);
    const num_t     high = num_max(x.a, num_max(x.b, x.c));
    const num_t     low = num_min(x.a, num_min(x.b, x.c));
    const num_t     shift = num_sub(NUM_C(0.5f), num_mul(num_add(high, low), NUM_C(0.5f)));
    const ctl_abc_t duty = {num_add(x.a, shift), num_add(x.b, shift), num_add(x.c, shift)};
    return duty;
}

#endif
