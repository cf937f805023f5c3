/**
 * @file  control/motor/dead_time.h
 * @brief The voltage that the dead time of a bridge takes away, from the currents that will flow.
 *
 * While both switches of a leg are off, its diodes carry the current: a phase voltage is lower by V = dead time / PWM period times the dc
 * link where current flows out of the leg, and higher by V where it flows in. What has to be added for that:
 *
 *     v_x = V sat( i_x / soft ),   x = a, b, c                                                           (1)
 *
 * soft in place of a sign: near zero the sign of a current is not known, and a wrong one would double the error and chatter.
 * Source   the common compensation by the sign of the phase currents.
 * Total    a current that is not finite gives no voltage and false; |v_x| <= V in any case.
 * Cost     17 products; the common part of (1) drops out.
 */
#ifndef CONTROL_MOTOR_DEAD_TIME_H
#define CONTROL_MOTOR_DEAD_TIME_H

#include "control/motor/frames.h"

/** (1) for finite currents. @param i  in the frame of @p rotor, as the voltage. @param volt  V. @param per_current  1 / soft. */
static inline ctl_dq_t ctl_dead_time_unchecked(ctl_dq_t i, ctl_rotor_t rotor, num_t volt, num_t per_current)
{
    const ctl_abc_t x = ctl_inverse_clarke_unchecked(ctl_inverse_park_unchecked(i, rotor));
    const ctl_abc_t v = {num_mul(num_clamp(num_mul(x.a, per_current), NUM_C(-1.0f), NUM_C(1.0f)), volt),
                         num_mul(num_clamp(num_mul(x.b, per_current), NUM_C(-1.0f), NUM_C(1.0f)), volt),
                         num_mul(num_clamp(num_mul(x.c, per_current), NUM_C(-1.0f), NUM_C(1.0f)), volt)};
    return ctl_park_unchecked(ctl_clarke_unchecked(v), rotor);
}

/** ctl_dead_time_unchecked for any current; sine and cosine within +-1, @p volt and @p per_current >= 0. */
bool ctl_dead_time(const ctl_dq_t *i, const ctl_rotor_t *rotor, num_t volt, num_t per_current, ctl_dq_t *out);

#endif
