/* Angle and speed of the rotor from the encoder. Its step is in current_isr.c, its retune in take_over.c. Main loop. */
#include "firmware/app/internal.h"

uint16_t drive_make_tracking(const drive_params_t *p, const drive_scale_t *scale, drive_tracking_setup_t *s)
{
    const float ts_s = 1.0f / (float)DRIVE_PWM_HZ;
    uint16_t    culprit = PARAM_COUNT;
    s->pll.kp_ts = num_from_float(p->pll_kp_per_s * ts_s);
    s->pll.ki_ts = drive_fitted(p->pll_ki_per_s2 * ts_s / scale->speed_rad_s, PARAM_pll_ki_per_s2, &culprit);
    s->pll.rad_per_speed_ts = num_from_float(ts_s * scale->speed_rad_s);
    s->pll.speed_max = num_from_float(1.5f * p->over_speed_rad_s / scale->speed_rad_s);
    s->encoder_offset = angle_from_rad(num_from_float(p->encoder_offset_rad));
    s->encoder_reversed = p->encoder_reversed != 0U;
    s->direction = s->encoder_reversed ? UINT32_MAX : 1U;
    s->pole_pairs = p->pole_pairs;
    s->error = (ctl_fourier_t){drive_number(p->encoder_cos1_rad), drive_number(p->encoder_sin1_rad),
                               drive_number(p->encoder_cos2_rad), drive_number(p->encoder_sin2_rad)};
    s->moves = false;
    s->corrects = ctl_fourier_is_used(&s->error);
    return culprit;
}

uint16_t drive_judge_tracking(const drive_tracking_setup_t *s)
{
    static const uint16_t PARAM_OF[] = {[0] = PARAM_over_speed_rad_s,
                                        [CTL_PLL_KP] = PARAM_pll_kp_per_s,
                                        [CTL_PLL_KI] = PARAM_pll_ki_per_s2,
                                        [CTL_PLL_RAD_PER_SPEED] = PARAM_over_speed_rad_s,
                                        [CTL_PLL_SPEED_MAX] = PARAM_over_speed_rad_s};
    ctl_pll_t             pll;
    const ctl_diag_t      d = ctl_pll_init(&pll, &s->pll);
    return (d.status == CTL_OK) ? (uint16_t)PARAM_COUNT
                                : PARAM_OF[(d.field < (sizeof PARAM_OF / sizeof PARAM_OF[0])) ? d.field : 0U];
}

void drive_build_tracking(drive_tracking_t *t, const drive_tracking_setup_t *s) { (void)ctl_pll_init(&t->pll, &s->pll); }
