/* From the parameter list to the blocks. Main loop. */
#include "firmware/app/internal.h"
#include "hal/hal_clock.h"

static drive_scale_t make_scale(const drive_params_t *p)
{
#ifdef EVENSPIN_FIXED
    /* limits of the drive at 2 and 4 per unit: a wide margin to 128, and 6e-8 of these bases as the smallest step */
    const float   speed = p->over_speed_rad_s * 0.25f;
    drive_scale_t s = {p->over_current_a * 0.5f, p->over_voltage_v * 0.5f, speed, speed * p->speed_error_gain, 1.0f, 1.0f, 1.0f};
#else
    drive_scale_t s = {1.0f, 1.0f, 1.0f, 1.0f, 1.0f, 1.0f, 1.0f};
    (void)p;
#endif
    s.inv_current = 1.0f / s.current_a;
    s.inv_voltage = 1.0f / s.voltage_v;
    s.inv_speed = 1.0f / s.speed_rad_s;
    return s;
}

num_t drive_fitted(float x, uint16_t param, uint16_t *culprit)
{
    const num_t n = num_from_float(x);
    if ((num_abs(n) >= NUM_MAX) && (*culprit == (uint16_t)PARAM_COUNT)) {
        *culprit = param;
    }
    return n;
}

static ctl_pi_params_t make_pi(num_t kp, num_t ki_ts, float limit)
{
    const ctl_pi_params_t pi = {kp, ki_ts, num_from_float(-limit), num_from_float(limit), CTL_PI_HOLD};
    return pi;
}

static void make_speed(const drive_params_t *p, drive_setup_t *s, uint16_t *culprit)
{
    const float ts_s = (float)p->speed_divider / (float)DRIVE_PWM_HZ;
    const float per_error = s->scale.error_unit / s->scale.current_a;

    s->speed_pi = make_pi(drive_fitted(p->speed_kp_a_per_unit * per_error, PARAM_speed_kp_a_per_unit, culprit),
                          drive_fitted(p->speed_ki_a_per_unit_s * ts_s * per_error, PARAM_speed_ki_a_per_unit_s, culprit),
                          p->iq_limit_a / s->scale.current_a);
    s->speed_pi.anti_windup = CTL_PI_HOLD_OUTWARD;
    s->error_scale = num_from_float(p->speed_error_gain * s->scale.speed_rad_s / s->scale.error_unit);

    s->speed_source = (drive_speed_source_t)p->speed_source;
    s->mt.sample_cyc = (hal_clock_hz() / DRIVE_PWM_HZ) * p->speed_divider;
    s->mt.speed_1_count =
        drive_fitted(DRIVE_TWO_PI / (p->encoder_counts * ts_s * s->scale.speed_rad_s), PARAM_over_speed_rad_s, culprit);
    s->mt.speed_max = num_from_float(4.0f * p->over_speed_rad_s / s->scale.speed_rad_s);
    s->mt.stop_samples = 100U;
}

uint16_t drive_make_setup(const drive_params_t *p, drive_setup_t *s)
{
    uint16_t bad = params_check(p);
    if (bad != (uint16_t)PARAM_COUNT) {
        return bad;
    }
    bad = drive_board_refuses(p);
    bad = (bad != (uint16_t)PARAM_COUNT) ? bad : drive_relation_refuses(p);
    if (bad != (uint16_t)PARAM_COUNT) {
        return bad;
    }
    bad = drive_judge_alignment(p);
    if (bad != (uint16_t)PARAM_COUNT) {
        return bad;
    }
    const float ts_s = 1.0f / (float)DRIVE_PWM_HZ;

    s->scale = make_scale(p);
    /* ctl_vector_limit limits the voltage as a whole, keeping its direction; the limits of the two controllers are far
     * outside and only keep them bounded */
    const float per_amp = s->scale.current_a * s->scale.inv_voltage;
    s->current_pi =
        make_pi(drive_fitted(p->current_kp_v_per_a * per_amp, PARAM_current_kp_v_per_a, &bad),
                drive_fitted(p->current_ki_v_per_as * ts_s * per_amp, PARAM_current_ki_v_per_as, &bad), DRIVE_AXIS_BOUND);

    s->pll.kp_ts = num_from_float(p->pll_kp_per_s * ts_s);
    s->pll.ki_ts = drive_fitted(p->pll_ki_per_s2 * ts_s / s->scale.speed_rad_s, PARAM_pll_ki_per_s2, &bad);
    s->pll.rad_per_speed_ts = num_from_float(ts_s * s->scale.speed_rad_s);
    s->pll.speed_max = num_from_float(1.5f * p->over_speed_rad_s / s->scale.speed_rad_s);

    make_speed(p, s, &bad);
    drive_make_repetitive(p, s, &bad);
    if (bad != (uint16_t)PARAM_COUNT) {
        return bad;
    }
    drive_make_deadbeat(p, s);
    bad = drive_make_observer(p, s);
    if (bad != (uint16_t)PARAM_COUNT) {
        return bad;
    }

    s->voltage_limit = (p->voltage_limit_v > 0.0f) ? num_from_float(p->voltage_limit_v / s->scale.voltage_v) : NUM_MAX;
    s->advance = num_from_float(p->angle_advance_periods * ts_s * (float)p->pole_pairs * s->scale.speed_rad_s / DRIVE_TWO_PI);
    s->encoder_offset = angle_from_rad(num_from_float(p->encoder_offset_rad));
    s->period_cyc = hal_clock_hz() / DRIVE_PWM_HZ;
    s->pole_pairs = p->pole_pairs;
    s->speed_divider = p->speed_divider;
    s->speed_inline = p->speed_inline != 0U;
    drive_make_motion(p, s);
    s->encoder_reversed = p->encoder_reversed != 0U;

    /* let every block judge, on copies: what is refused must not have changed anything */
    ctl_pi_t  pi;
    ctl_pll_t pll;
    ctl_mt_t  mt;
    if (ctl_pi_init(&pi, &s->current_pi).status != CTL_OK) {
        return PARAM_current_kp_v_per_a;
    }
    if (ctl_pi_init(&pi, &s->speed_pi).status != CTL_OK) {
        return PARAM_iq_limit_a; /* 0 leaves no room between the limits */
    }
    const ctl_diag_t d = ctl_pll_init(&pll, &s->pll);
    if (d.status != CTL_OK) {
        return (d.field == (uint16_t)CTL_PLL_KP)
                   ? PARAM_pll_kp_per_s
                   : ((d.field == (uint16_t)CTL_PLL_KI) ? PARAM_pll_ki_per_s2 : PARAM_over_speed_rad_s);
    }
    if (ctl_mt_init(&mt, &s->mt).status != CTL_OK) {
        return PARAM_encoder_counts;
    }
    bad = drive_judge_repetitive(s);
    bad = (bad != (uint16_t)PARAM_COUNT) ? bad : drive_judge_deadbeat(s);
    bad = (bad != (uint16_t)PARAM_COUNT) ? bad : drive_judge_observer(s);
    return (bad != (uint16_t)PARAM_COUNT) ? bad : drive_make_position(p, s);
}

uint16_t drive_build(drive_t *d)
{
    drive_setup_t *const s = &d->set[0].setup; /* the set in force */
    const uint16_t       bad = drive_make_setup(d->params, s);
    if (bad != (uint16_t)PARAM_COUNT) {
        /* no block has memory: none may run, although the interrupts go on in FAULT */
        s->rc_used = false;
        s->meter_used = false;
        s->observer_used = false;
        return bad;
    }
    d->scale = s->scale;
    d->zero.e = s->encoder_offset;
    /* all of these were accepted a moment ago */
    (void)ctl_pi_init(&d->current.d, &s->current_pi);
    (void)ctl_pi_init(&d->current.q, &s->current_pi);
    (void)ctl_pi_init(&d->speed.pi, &s->speed_pi);
    (void)ctl_pll_init(&d->tracking.pll, &s->pll);
    (void)ctl_mt_init(&d->speed.mt, &s->mt);
    (void)ctl_deadbeat_init(&d->current.deadbeat, &s->deadbeat);
    drive_build_repetitive(d, s);
    drive_build_meter(d, s);
    drive_build_observer(d, s);
    drive_build_position(d, s);
    drive_command_again(d);
    return PARAM_COUNT;
}
