/* MTPA and field weakening: their share of the setup. The step is in reference_step.c. Main loop. */
#include "firmware/app/internal.h"

/* The correction of the voltage: time constants. Falling, several samples of a speed loop of 1 kHz; rising, several falls. */
#define SMOOTH_S 0.003f
#define FALL_S 0.006f
#define RISE_S 0.015f

static float part(float ts_s, float time_s) { return (ts_s < time_s) ? (ts_s / time_s) : 1.0f; }

float drive_torque_limit_a(const drive_params_t *p)
{
    const float k = (p->motor_ld_h - p->motor_lq_h) / p->motor_psi_wb;
    return (p->mtpa != 0U) ? (p->iq_limit_a * (1.0f + (((k < 0.0f) ? -k : k) * drive_id_max_a(p)))) : p->iq_limit_a;
}

uint16_t drive_make_reference(const drive_params_t *p, const drive_scale_t *scale, drive_reference_setup_t *s)
{
    static const uint16_t PARAM_OF[] = {[0] = PARAM_mtpa,
                                        [CTL_REFERENCE_SALIENCY] = PARAM_motor_psi_wb,
                                        [CTL_REFERENCE_D_FULL] = PARAM_motor_ld_h,
                                        [CTL_REFERENCE_Q_FULL] = PARAM_motor_lq_h,
                                        [CTL_REFERENCE_EMF] = PARAM_motor_psi_wb,
                                        [CTL_REFERENCE_OHM] = PARAM_motor_resistance_ohm,
                                        [CTL_REFERENCE_I_MAX] = PARAM_iq_limit_a,
                                        [CTL_REFERENCE_IQ_MAX] = PARAM_iq_limit_a,
                                        [CTL_REFERENCE_ID_MAX] = PARAM_id_limit_a,
                                        [CTL_REFERENCE_SHARE] = PARAM_voltage_margin,
                                        [CTL_REFERENCE_GAIN] = PARAM_speed_divider};
    const float           ts_s = (float)p->speed_divider / (float)DRIVE_PWM_HZ;
    uint16_t              culprit = PARAM_COUNT;

    s->used = (p->mtpa | p->field_weakening) != 0U;
    if (!s->used) {
        return PARAM_COUNT;
    }
    const float                  k = (p->motor_ld_h - p->motor_lq_h) / p->motor_psi_wb;
    const ctl_reference_params_t c = {
        .saliency = drive_fitted(k * scale->current_a, PARAM_motor_psi_wb, &culprit),
        .d_full = drive_fitted(p->motor_psi_wb / p->motor_ld_h * scale->inv_current, PARAM_motor_ld_h, &culprit),
        .q_full = drive_fitted(p->motor_psi_wb / p->motor_lq_h * scale->inv_current, PARAM_motor_lq_h, &culprit),
        .emf = drive_fitted((float)p->pole_pairs * p->motor_psi_wb * scale->speed_rad_s * scale->inv_voltage, PARAM_motor_psi_wb,
                            &culprit),
        .ohm =
            drive_fitted(p->motor_resistance_ohm * scale->current_a * scale->inv_voltage, PARAM_motor_resistance_ohm, &culprit),
        .i_max = drive_number(drive_longest_a(p) * scale->inv_current),
        .iq_max = drive_number(p->iq_limit_a * scale->inv_current),
        .id_max = drive_number(drive_id_max_a(p) * scale->inv_current),
        .share = drive_number(1.0f - p->voltage_margin),
        .smooth = drive_number(part(ts_s, SMOOTH_S)),
        .fall = drive_number(part(ts_s, FALL_S)),
        .rise = drive_number(part(ts_s, RISE_S)),
        .mtpa = p->mtpa != 0U,
        .weakens = p->field_weakening != 0U,
    };
    if (culprit != (uint16_t)PARAM_COUNT) {
        return culprit;
    }
    const ctl_diag_t d = ctl_reference_plan(&s->plan, &c);
    return (d.status == CTL_OK) ? (uint16_t)PARAM_COUNT
                                : PARAM_OF[(d.field < (sizeof PARAM_OF / sizeof PARAM_OF[0])) ? d.field : 0U];
}

void drive_rest_reference(ctl_reference_state_t *state, const drive_reference_setup_t *setup)
{
    if (setup->used) {
        ctl_reference_reset(&setup->plan, state);
    } else {
        state->iq_max = NUM_MAX; /* only the order's */
    }
}
