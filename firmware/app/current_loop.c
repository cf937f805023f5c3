/* The current loop: two PI controllers, or deadbeat control. Its step is in current_isr.c, its retune in take_over.c. Main loop. */
#include "firmware/app/internal.h"

/* @param culprit  of what is beyond the numeric, unless there is one already */
static void make_deadbeat(const drive_params_t *p, const drive_scale_t *scale, drive_current_setup_t *s, uint16_t *culprit)
{
    const float ts_s = 1.0f / (float)DRIVE_PWM_HZ;
    const float volt_per_amp = scale->current_a * scale->inv_voltage;
    const float we = (float)p->pole_pairs * scale->speed_rad_s;

    s->deadbeat.r = drive_fitted(p->motor_resistance_ohm * volt_per_amp, PARAM_motor_resistance_ohm, culprit);
    s->deadbeat.ld_ts = drive_fitted(p->motor_ld_h / ts_s * volt_per_amp, PARAM_motor_ld_h, culprit);
    s->deadbeat.lq_ts = drive_fitted(p->motor_lq_h / ts_s * volt_per_amp, PARAM_motor_lq_h, culprit);
    s->deadbeat.ts_ld = drive_fitted(ts_s / (p->motor_ld_h * volt_per_amp), PARAM_motor_ld_h, culprit);
    s->deadbeat.ts_lq = drive_fitted(ts_s / (p->motor_lq_h * volt_per_amp), PARAM_motor_lq_h, culprit);
    s->deadbeat.w_ld = drive_fitted(we * p->motor_ld_h * volt_per_amp, PARAM_motor_ld_h, culprit);
    s->deadbeat.w_lq = drive_fitted(we * p->motor_lq_h * volt_per_amp, PARAM_motor_lq_h, culprit);
    s->deadbeat.w_psi = drive_fitted(we * p->motor_psi_wb * scale->inv_voltage, PARAM_motor_psi_wb, culprit);
    s->deadbeat.correction = drive_number(p->deadbeat_correction);
    s->deadbeat.c_max = drive_number(p->over_current_a * scale->inv_current);
    s->deadbeat.v_max = drive_number(DRIVE_AXIS_BOUND);
}

uint16_t drive_make_current(const drive_params_t *p, const drive_scale_t *scale, drive_current_setup_t *s)
{
    const float ts_s = 1.0f / (float)DRIVE_PWM_HZ;
    const float per_amp = scale->current_a * scale->inv_voltage;
    uint16_t    culprit = PARAM_COUNT;

    /* ctl_vector_limit limits the voltage as a whole, keeping its direction; the limits of the two controllers are far
     * outside and only keep them bounded */
    s->pi = drive_pi(drive_fitted(p->current_kp_v_per_a * per_amp, PARAM_current_kp_v_per_a, &culprit),
                     drive_fitted(p->current_ki_v_per_as * ts_s * per_amp, PARAM_current_ki_v_per_as, &culprit), DRIVE_AXIS_BOUND,
                     CTL_PI_HOLD);
    s->voltage_limit = (p->voltage_limit_v > 0.0f) ? drive_number(p->voltage_limit_v / scale->voltage_v) : NUM_MAX;
    s->advance = drive_number(p->angle_advance_periods * ts_s * (float)p->pole_pairs * scale->speed_rad_s / DRIVE_TWO_PI);
    s->deadbeat_used = p->current_controller == 1U;
    s->decouples = (p->field_weakening != 0U) && !s->deadbeat_used;
    uint16_t unused = PARAM_COUNT; /* a controller that is not asked for may be beyond the numeric */
    make_deadbeat(p, scale, s, (s->deadbeat_used || s->decouples || drive_smooths(p)) ? &culprit : &unused);
    return culprit;
}

uint16_t drive_judge_current(const drive_current_setup_t *s)
{
    static const uint16_t PARAM_OF[] = {[0] = PARAM_COUNT,
                                        [CTL_DEADBEAT_R] = PARAM_motor_resistance_ohm,
                                        [CTL_DEADBEAT_LD] = PARAM_motor_ld_h,
                                        [CTL_DEADBEAT_LQ] = PARAM_motor_lq_h,
                                        [CTL_DEADBEAT_PSI] = PARAM_motor_psi_wb,
                                        [CTL_DEADBEAT_CORRECTION] = PARAM_deadbeat_correction,
                                        [CTL_DEADBEAT_LIMIT] = PARAM_over_current_a};
    ctl_pi_t              pi;
    ctl_deadbeat_t        trial;
    if (ctl_pi_init(&pi, &s->pi).status != CTL_OK) {
        return PARAM_current_kp_v_per_a;
    }
    const ctl_diag_t d = ctl_deadbeat_init(&trial, &s->deadbeat);
    return (d.status == CTL_OK)
               ? (uint16_t)PARAM_COUNT
               : PARAM_OF[(d.field < (sizeof PARAM_OF / sizeof PARAM_OF[0])) ? d.field : (uint16_t)CTL_DEADBEAT_R];
}

void drive_build_current(drive_current_t *c, const drive_current_setup_t *s)
{
    (void)ctl_pi_init(&c->d, &s->pi);
    (void)ctl_pi_init(&c->q, &s->pi);
    c->deadbeat.rejected = 0U;
    ctl_deadbeat_reset(&c->deadbeat);
}

void drive_rest_current(drive_current_t *c, const drive_current_setup_t *s)
{
    ctl_pi_tune_gains(&c->d, &s->pi); /* which may have followed a saturation */
    ctl_pi_tune_gains(&c->q, &s->pi);
    c->decoupled = false;
    ctl_pi_reset(&c->d, (num_t)0);
    ctl_pi_reset(&c->q, (num_t)0);
    ctl_deadbeat_reset(&c->deadbeat);
}
