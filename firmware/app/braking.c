/* Braking into a dc link that cannot give its energy back: a resistor takes it, and the torque comes down as the voltage rises. Speed
 * interrupt: the resistor in every sample, the torque where one is asked for. */
#include "firmware/app/internal.h"
#include "hal/hal_inverter.h"

#define HOT_Q24 ((int32_t)16777216)
#define COOL_Q24 ((int32_t)15099494) /* 0.9 */

#define AHEAD_SAMPLES 2.0f /* mean age of a sample, the delay of the current loop, and the filter of the measurement, at 1 kHz */
#define HEAT_MARGIN 1.25f  /* of the flux, the resistance and the torque that is really there */

void drive_make_braking(const drive_params_t *p, const drive_scale_t *scale, drive_braking_setup_t *s)
{
    const float flux = (float)p->pole_pairs * p->motor_psi_wb * HEAT_MARGIN;
    const float most = 100.0f * scale->current_a * scale->inv_speed; /* of the range of the fixed build */
    const float heats = (p->motor_resistance_ohm > 0.0f) ? (flux / p->motor_resistance_ohm) : most;
    s->limited = p->regeneration_limit_v > 0.0f;
    s->chops = p->chopper_v > 0.0f;
    s->chop_v = p->chopper_v;
    s->chop_per_v = 1.0f / p->chopper_band_v;
    s->per_ohm = 1.0f / p->chopper_ohm;
    s->resistor.per_square = (p->chopper_continuous_w > 0.0f) ? (1.0f / p->chopper_continuous_w) : 0.0f;
    s->resistor.rate = ctl_thermal_rate((float)p->speed_divider / (float)DRIVE_PWM_HZ, p->chopper_thermal_s);
    s->end_v = p->regeneration_limit_v;
    s->per_band = 1.0f / p->regeneration_band_v;
    s->heats = drive_number(((heats < most) ? heats : most) * scale->speed_rad_s * scale->inv_current);
}

/* The share of the braking torque that the dc link leaves, with what it will be when that acts. NaN: none. */
static float share(drive_t *d)
{
    const drive_braking_setup_t *const s = &d->setup->braking;
    const float                        now_v = d->sample.vdc_v;
    const float                        rise_v = now_v - d->braking.before_v;
    const float part = (s->end_v - now_v - ((rise_v > 0.0f) ? (AHEAD_SAMPLES * rise_v) : 0.0f)) * s->per_band;
    d->braking.before_v = now_v;
    return (part > 0.0f) ? part : 0.0f; /* above 1 nothing is cut */
}

/* A motor gives 1.5 (p psi w i - R i^2) to the dc link: from i = p psi w / R on nothing, so braking as hard as that is not limited. The
 * observer's part, which the current interrupt takes off, counts. */
num_t drive_limit_braking(drive_t *d, num_t torque)
{
    const num_t speed = d->speed.meas;
    const bool  forwards = speed >= (num_t)0;
    const num_t most = num_mul(drive_active_order(d)->iq_max, num_from_float(share(d)));
    const num_t net = num_sub(torque, d->observer.estimate);
    const num_t brakes = forwards ? num_neg(net) : net;
    if ((brakes <= most) || (brakes >= num_mul(num_abs(speed), d->setup->braking.heats))) {
        return torque;
    }
    return num_add(d->observer.estimate, forwards ? num_neg(most) : most);
}

/* In proportion to the voltage above its threshold. NaN: off. */
static float on_time(const drive_t *d)
{
    const float part = (d->sample.vdc_v - d->setup->braking.chop_v) * d->setup->braking.chop_per_v;
    return (part > 0.0f) ? ((part < 1.0f) ? part : 1.0f) : 0.0f;
}

void drive_chop(drive_t *d)
{
    const drive_braking_setup_t *const s = &d->setup->braking;
    drive_braking_t *const             b = &d->braking;
    float                              duty = on_time(d);
    ctl_thermal_step(&s->resistor, &b->resistor, b->brake_w); /* of the sample that ends now */
    b->rests = ctl_thermal_beyond(b->resistor, b->rests ? COOL_Q24 : HOT_Q24);
    if (b->rests) {
        if (drive_is_armed(d) && (duty > 0.0f) && !s->limited) {
            drive_trip(d, FAULT_brake_overload); /* else the braking comes down, or nobody brakes */
        }
        duty = 0.0f;
    }
    b->brake_w = (duty > 0.0f) ? (duty * d->sample.vdc_v * d->sample.vdc_v * s->per_ohm) : 0.0f;
    hal_brake_duty(duty);
}

float drive_chopper_heat(const drive_t *d) { return ctl_thermal_heat(d->braking.resistor); }
