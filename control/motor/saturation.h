/**
 * @file  control/motor/saturation.h
 * @brief What saturation of the iron leaves of an axis' inductance, for a gain that follows it.
 *
 *     L(i) / L = 1 / (1 + (i_x^2 + cross i_y^2) / i_sat^2), no less than CTL_SATURATION_LEAST            (1)
 *
 * the differential inductance of axis x with the current i_y of the other axis; cross 0: an axis saturates with its own current, 1:
 * with the amplitude of both. A proportional gain k_p that was made for L keeps its bandwidth, k_p / L, as k_p L(i) / L with
 * the current at which its voltage acts.
 * Source   the soft saturation that `inductance_saturation` of the simulator has, docs/effects.md.
 * Total    a current that is not finite counts as 0 and gives false; the result is within [CTL_SATURATION_LEAST, 1] in any case.
 * Cost     4 products and a division for each axis. Float and fixed agree within 1e-6.
 */
#ifndef CONTROL_MOTOR_SATURATION_H
#define CONTROL_MOTOR_SATURATION_H

#include "control/motor/frames.h"

#define CTL_SATURATION_LEAST NUM_C(0.1f)   /**< A gain ten times smaller than its parameter: beyond, the model is a guess. */
#define CTL_SATURATION_LARGEST NUM_C(4.0f) /**< Of i / i_sat: (1) has been at its least since 3. */

typedef struct {
    num_t per_current; /**< 1 / i_sat, >= 0; 0: no saturation. */
    num_t cross;       /**< [0, 1]. */
} ctl_saturation_params_t;

/** (1) for finite currents of the axis itself and of the other one. */
static inline num_t ctl_saturation_unchecked(const ctl_saturation_params_t *p, num_t own, num_t other)
{
    const num_t x = num_min(num_abs(num_mul(own, p->per_current)), CTL_SATURATION_LARGEST);
    const num_t y = num_min(num_abs(num_mul(other, p->per_current)), CTL_SATURATION_LARGEST);
    const num_t under = num_mac(num_mac(NUM_C(1.0f), x, x), num_mul(y, y), p->cross);
    return num_max(num_quotient(NUM_C(1.0f), under), CTL_SATURATION_LEAST);
}

/** (1) of both axes for any currents, into @p share. */
bool ctl_saturation(const ctl_saturation_params_t *p, const ctl_dq_t *i, ctl_dq_t *share);

#endif
