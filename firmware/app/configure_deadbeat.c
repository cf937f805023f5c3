/* Parameters to the deadbeat current controller. Main loop. */
#include "firmware/app/internal.h"

void drive_make_deadbeat(const drive_params_t *p, drive_setup_t *s)
{
    const float ts_s = 1.0f / (float)DRIVE_PWM_HZ;
    const float volt_per_amp = s->scale.current_a * s->scale.inv_voltage;
    const float we = (float)p->pole_pairs * s->scale.speed_rad_s;

    s->deadbeat_used = p->current_controller == 1U;
    s->deadbeat.r = num_from_float(p->motor_resistance_ohm * volt_per_amp);
    s->deadbeat.ld_ts = num_from_float(p->motor_ld_h / ts_s * volt_per_amp);
    s->deadbeat.lq_ts = num_from_float(p->motor_lq_h / ts_s * volt_per_amp);
    s->deadbeat.ts_ld = num_from_float(ts_s / (p->motor_ld_h * volt_per_amp));
    s->deadbeat.ts_lq = num_from_float(ts_s / (p->motor_lq_h * volt_per_amp));
    s->deadbeat.w_ld = num_from_float(we * p->motor_ld_h * volt_per_amp);
    s->deadbeat.w_lq = num_from_float(we * p->motor_lq_h * volt_per_amp);
    s->deadbeat.w_psi = num_from_float(we * p->motor_psi_wb * s->scale.inv_voltage);
    s->deadbeat.correction = num_from_float(p->deadbeat_correction);
    s->deadbeat.c_max = num_from_float(p->over_current_a * s->scale.inv_current);
    s->deadbeat.v_max = num_from_float(DRIVE_AXIS_BOUND);
}

uint16_t drive_judge_deadbeat(const drive_setup_t *s)
{
    static const uint16_t PARAM_OF[] = {[0] = PARAM_COUNT,
                                        [CTL_DEADBEAT_R] = PARAM_motor_resistance_ohm,
                                        [CTL_DEADBEAT_LD] = PARAM_motor_ld_h,
                                        [CTL_DEADBEAT_LQ] = PARAM_motor_lq_h,
                                        [CTL_DEADBEAT_PSI] = PARAM_motor_psi_wb,
                                        [CTL_DEADBEAT_CORRECTION] = PARAM_deadbeat_correction,
                                        [CTL_DEADBEAT_LIMIT] = PARAM_over_current_a};
    ctl_deadbeat_t        trial;
    const ctl_diag_t      d = ctl_deadbeat_init(&trial, &s->deadbeat);
    return (d.status == CTL_OK)
               ? (uint16_t)PARAM_COUNT
               : PARAM_OF[(d.field < (sizeof PARAM_OF / sizeof PARAM_OF[0])) ? d.field : (uint16_t)CTL_DEADBEAT_R];
}
