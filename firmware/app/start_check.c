/* A start into a motor that turns. The gates are released on the zero vector, a short circuit for the motor's own voltage, and
 * stay there until the first voltage of the current loop is loaded: one PWM period, or two when the release falls behind an
 * interrupt. The current that this drives is  i = w_e psi 2 T / Lq  (the q-axis voltage equation, resistance and the change of
 * the angle left out, both of which make it smaller). Up to half of over_current_a a start takes it, and the current loop begins
 * with the voltage of the motor instead of with none; beyond it the start is refused. */
#include "firmware/app/internal.h"

#define PERIODS 2.0f
#define SURGE_SHARE 0.5f /* of over_current_a: the reference of the start comes on top */

static float motor_voltage_v(const drive_t *d)
{
    const float speed_rad_s = num_to_float(d->tracking.pll.state.w) * d->scale.speed_rad_s;
    return speed_rad_s * (float)d->params->pole_pairs * d->params->motor_psi_wb;
}

float drive_start_surge_a(const drive_t *d)
{
    const float surge_a = motor_voltage_v(d) * PERIODS / ((float)DRIVE_PWM_HZ * d->params->motor_lq_h);
    return (surge_a < 0.0f) ? -surge_a : surge_a;
}

float drive_start_surge_max_a(const drive_t *d) { return SURGE_SHARE * d->params->over_current_a; }

void drive_preset_voltage(drive_t *d) { ctl_pi_reset(&d->current.q, drive_per_base(motor_voltage_v(d), d->scale.inv_voltage)); }
