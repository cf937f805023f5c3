/* The speed loop: measurement, PI, and the repetitive controller (speed_repetitive.c). Its step is in speed_isr.c, its retune in
 * take_over.c. Main loop. */
#include "firmware/app/internal.h"
#include "hal/hal_clock.h"

/* @param per_sample  in rad/s; 0: 0, and one step at least for anything else */
static int64_t ramp_steps(float per_sample, uint16_t param, uint16_t *culprit)
{
    const float most = (float)CTL_RAMP_STEP_MAX / DRIVE_RAMP_STEPS; /* 512 rad/s in a sample */
    if (!(per_sample < most) && (*culprit == (uint16_t)PARAM_COUNT)) {
        *culprit = param;
    }
    const int64_t steps = drive_ramp_steps((per_sample < most) ? per_sample : 0.0f);
    return ((per_sample > 0.0f) && (steps == 0)) ? 1 : steps;
}

static void make_ramp(const drive_params_t *p, float ts_s, drive_speed_setup_t *s, uint16_t *culprit)
{
    s->ramp.rate = ramp_steps(p->speed_ramp_rad_s2 * ts_s, PARAM_speed_ramp_rad_s2, culprit);
    s->ramp.change = ramp_steps(p->speed_jerk_rad_s3 * ts_s * ts_s, PARAM_speed_jerk_rad_s3, culprit);
    s->stop_ramp.rate = ramp_steps(p->stop_ramp_rad_s2 * ts_s, PARAM_stop_ramp_rad_s2, culprit);
    s->stop_ramp.change = s->ramp.change;
    s->ramps = p->speed_ramp_rad_s2 > 0.0f;
}

uint16_t drive_make_speed(const drive_params_t *p, const drive_scale_t *scale, drive_speed_setup_t *s)
{
    const float ts_s = (float)p->speed_divider / (float)DRIVE_PWM_HZ;
    const float per_error = scale->error_unit / scale->current_a;
    uint16_t    culprit = PARAM_COUNT;

    s->pi = drive_pi(drive_fitted(p->speed_kp_a_per_unit * per_error, PARAM_speed_kp_a_per_unit, &culprit),
                     drive_fitted(p->speed_ki_a_per_unit_s * ts_s * per_error, PARAM_speed_ki_a_per_unit_s, &culprit),
                     drive_torque_limit_a(p) / scale->current_a, CTL_PI_HOLD_OUTWARD);
    s->error_scale = num_from_float(p->speed_error_gain * scale->speed_rad_s / scale->error_unit);
    s->weight = num_from_float(p->speed_setpoint_weight);
    s->weighted = p->speed_setpoint_weight < 1.0f;
    /* with ki T_s / kp the filter makes of the PI controller exactly the one whose proportional part has the weighted reference */
    s->follow = (p->speed_ki_a_per_unit_s * ts_s < p->speed_kp_a_per_unit)
                    ? num_from_float(p->speed_ki_a_per_unit_s * ts_s / p->speed_kp_a_per_unit)
                    : NUM_C(1.0f);
    /* held for a sample, and late by that of the current loop */
    s->feeds = p->speed_model_ff != 0U;
    s->notched = p->speed_notch_hz > 0.0f;
    ctl_notch_design(&s->notch, p->speed_notch_hz * ts_s, p->speed_notch_damping, p->speed_notch_depth);
    s->lead_rad = num_from_float(((0.5f * ts_s) + (p->observer_actuation_samples / (float)DRIVE_PWM_HZ)) * scale->speed_rad_s);
    s->between = (uint16_t)(p->speed_divider - 1U);
    s->inlined = p->speed_inline != 0U;
    make_ramp(p, ts_s, s, &culprit);

    s->source = (drive_speed_source_t)p->speed_source;
    s->mt.sample_cyc = (hal_clock_hz() / DRIVE_PWM_HZ) * p->speed_divider;
    s->mt.speed_1_count =
        drive_fitted(DRIVE_TWO_PI / (p->encoder_counts * ts_s * scale->speed_rad_s), PARAM_over_speed_rad_s, &culprit);
    s->mt.speed_max = num_from_float(4.0f * p->over_speed_rad_s / scale->speed_rad_s);
    s->mt.stop_samples = 100U;
    return (culprit != (uint16_t)PARAM_COUNT) ? culprit : drive_make_repetitive(p, scale, s);
}

uint16_t drive_judge_speed(const drive_speed_setup_t *s)
{
    ctl_pi_t pi;
    ctl_mt_t mt;
    if (ctl_pi_init(&pi, &s->pi).status != CTL_OK) {
        return PARAM_iq_limit_a; /* 0 leaves no room between the limits */
    }
    if (ctl_mt_init(&mt, &s->mt).status != CTL_OK) {
        return PARAM_encoder_counts;
    }
    if (s->notched && (ctl_notch_check(&s->notch).status != CTL_OK)) {
        return PARAM_speed_notch_hz; /* so low, or so wide, that the numeric has no number for it */
    }
    return drive_judge_repetitive(s);
}

void drive_build_speed(drive_speed_t *v, const drive_speed_setup_t *s, num_t *memory)
{
    (void)ctl_pi_init(&v->pi, &s->pi);
    (void)ctl_mt_init(&v->mt, &s->mt);
    drive_build_repetitive(v, s, memory);
}

void drive_rest_speed(drive_speed_t *v, const drive_speed_setup_t *s)
{
    ctl_pi_reset(&v->pi, (num_t)0);
    ctl_mt_reset(&v->mt);
    if (s->rc_used) {
        ctl_rc_reset(&v->rc, true); /* what was learned over the angle survives a stop */
    }
}
