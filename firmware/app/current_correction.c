/* Offsets and gains of the current sensors, as the parameters say or as learned. */
#include "firmware/app/internal.h"

static void make_learning(const drive_params_t *p, const drive_scale_t *scale, ctl_current_error_params_t *l)
{
    const float ts_s = 1.0f / (float)DRIVE_PWM_HZ;
    const float volt_per_amp = scale->current_a * scale->inv_voltage;
    const float we = (float)p->pole_pairs * scale->speed_rad_s;
    l->gain = p->current_learning_gain;
    l->least_current = p->current_learning_least_a * scale->inv_current;
    l->offset_max = p->current_offset_max_a * scale->inv_current;
    l->gain_max = p->current_gain_max;
    l->r = p->motor_resistance_ohm * volt_per_amp;
    l->w_l = 0.5f * (p->motor_ld_h + p->motor_lq_h) * we * volt_per_amp;
    l->turns_per_sample = 2.0f * we * ts_s / DRIVE_TWO_PI; /* every second one counts */
    /* the voltage of a sample is noted with the angle of the next one, when it begins to act */
    l->advance_turns = (p->angle_advance_periods - 1.0f) * we * ts_s / DRIVE_TWO_PI;
    l->pole_pairs = p->pole_pairs;
    l->three = p->current_sensors == 1U;
}

bool drive_smooths(const drive_params_t *p)
{
    return (p->flux_cos6 != 0.0f) || (p->flux_sin6 != 0.0f) || (p->flux_cos12 != 0.0f) || (p->flux_sin12 != 0.0f);
}

void drive_make_correction(const drive_params_t *p, const drive_scale_t *scale, drive_sensors_setup_t *s)
{
    s->used = p->current_correction != (uint16_t)DRIVE_CORRECTION_OFF;
    const bool refers = (p->mtpa | p->field_weakening) != 0U;
    s->flux = (ctl_fourier_t){drive_number(p->flux_cos6), drive_number(p->flux_sin6), drive_number(p->flux_cos12),
                              drive_number(p->flux_sin12)};
    s->smooths = drive_smooths(p);
    s->saturates = p->saturation_a > 0.0f;
    s->saturation.per_current = s->saturates ? num_from_float(scale->current_a / p->saturation_a) : (num_t)0;
    s->saturation.cross = drive_number(p->saturation_cross);
    s->plain_state = (s->used || refers || s->smooths || s->saturates || (p->dead_time_s > 0.0f)) ? DRIVE_STATES : DRIVE_RUN;
    s->three = (p->current_sensors == 1U) || !s->used;
    s->compensates = p->dead_time_s > 0.0f;
    s->dead_share = num_from_float(p->dead_time_s * (float)DRIVE_PWM_HZ);
    s->per_soft = num_from_float(scale->current_a / p->dead_time_soft_a);
    /* without a correction three sensors count as they are: three, too */
    s->more = s->compensates || s->smooths || s->saturates || s->three || refers;
    s->learns = p->current_correction == (uint16_t)DRIVE_CORRECTION_LEARNED;
    const float offset[3] = {p->current_offset_a_a, p->current_offset_b_a, p->current_offset_c_a};
    const float gain[3] = {p->current_gain_a, p->current_gain_b, p->current_gain_c};
    for (uint16_t k = 0U; k < 3U; k++) {
        s->offset[k] = offset[k] * scale->inv_current;
        s->gain[k] = gain[k];
    }
    make_learning(p, scale, &s->learning);
}

uint16_t drive_judge_correction(const drive_sensors_setup_t *s)
{
    static const uint16_t PARAM_OF[] = {[0] = PARAM_current_correction,
                                        [CTL_CURRENT_ERROR_GAIN] = PARAM_current_learning_gain,
                                        [CTL_CURRENT_ERROR_LEAST] = PARAM_current_learning_least_a,
                                        [CTL_CURRENT_ERROR_OFFSET_MAX] = PARAM_current_offset_max_a,
                                        [CTL_CURRENT_ERROR_GAIN_MAX] = PARAM_current_gain_max,
                                        [CTL_CURRENT_ERROR_R] = PARAM_motor_resistance_ohm,
                                        [CTL_CURRENT_ERROR_L] = PARAM_motor_lq_h,
                                        [CTL_CURRENT_ERROR_SPEED] = PARAM_over_speed_rad_s,
                                        [CTL_CURRENT_ERROR_POLE_PAIRS] = PARAM_pole_pairs};
    if (!s->learns) {
        return PARAM_COUNT;
    }
    const ctl_diag_t d = ctl_current_error_check(&s->learning);
    return (d.status == CTL_OK) ? (uint16_t)PARAM_COUNT
                                : PARAM_OF[(d.field < (sizeof PARAM_OF / sizeof PARAM_OF[0])) ? d.field : 0U];
}

/* ---- main loop ------------------------------------------------------------------------------------------------------- */

/* Into the map that the interrupt does not use. It reads `at` once a sample, and the main loop comes here once a turn. */
static void show(drive_sensors_t *c, const float *offset, const float *gain, float current_a)
{
    const uint16_t             idle = (uint16_t)((c->at & 1U) ^ 1U);
    drive_sensors_map_t *const m = &c->map[idle];
    for (uint16_t k = 0U; k < 3U; k++) {
        m->scale[k] = 1.0f / gain[k];
        m->shift_a[k] = offset[k] * current_a / gain[k];
    }
    hal_order();
    c->at = idle;
}

void drive_build_correction(drive_sensors_t *c, const drive_sensors_setup_t *s, const drive_scale_t *scale)
{
    static const float NONE[3] = {0.0f, 0.0f, 0.0f};
    static const float RIGHT[3] = {1.0f, 1.0f, 1.0f};
    if (!s->used) {
        show(c, NONE, RIGHT, scale->current_a);
    } else if (s->learns) {
        (void)ctl_current_error_init(&c->learned, &s->learning);
        ctl_current_error_reset(&c->learned, s->offset, s->gain);
        show(c, c->learned.state.offset, c->learned.state.gain, scale->current_a);
    } else {
        show(c, s->offset, s->gain, scale->current_a);
    }
}

bool drive_correction_differs(const drive_sensors_setup_t *before, const drive_sensors_setup_t *s)
{
    bool same = (before->used == s->used) && (before->learns == s->learns) && (before->three == s->three);
    for (uint16_t k = 0U; k < 3U; k++) {
        same = same && (before->offset[k] == s->offset[k]) && (before->gain[k] == s->gain[k]);
    }
    return !same;
}

/* Of the samples that the main loop has seen in this turn: it only scales a residual that vanishes. */
static ctl_dq_t mean_current(drive_sensors_t *c, ctl_dq_t newest)
{
    const float    share = (c->seen > 0U) ? (1.0f / (float)c->seen) : 0.0f;
    const ctl_dq_t mean = {num_from_float(c->seen_d * share), num_from_float(c->seen_q * share)};
    const bool     any = c->seen > 0U;
    c->seen = 0U;
    c->seen_d = 0.0f;
    c->seen_q = 0.0f;
    return any ? mean : newest;
}

void drive_attend_correction(drive_t *d)
{
    drive_sensors_t *const             c = &d->sensors;
    const drive_sensors_setup_t *const s = &d->setup->sensors;
    if (c->seen < CTL_TURN_LONGEST) {
        c->seen++;
        c->seen_d += num_to_float(d->current.meas.d);
        c->seen_q += num_to_float(d->current.meas.q);
    }
    if (c->log.ready == 0U) {
        if (s->learns && ctl_turn_is_slow(&c->log)) {
            c->learned.state.verdict = CTL_CURRENT_ERROR_SLOW;
        }
        return;
    }
    if (s->learns) {
        const num_t          v_dc = drive_per_base(d->sample.vdc_v, d->scale.inv_voltage);
        const ctl_turn_now_t now = {d->current.meas, d->current.volt, mean_current(c, d->current.meas), d->tracking.pll.state.w,
                                    num_min(d->setup->current.voltage_limit, num_mul(v_dc, NUM_C(0.57735026919f)))};
        c->learned.params = s->learning; /* of the set in force */
        const ctl_current_error_verdict_t verdict = ctl_current_error_learn(&c->learned, ctl_turn_complete(&c->log), &now);
        if ((verdict == CTL_CURRENT_ERROR_LEARNS) || (verdict == CTL_CURRENT_ERROR_BOUND)) {
            show(c, c->learned.state.offset, c->learned.state.gain, d->scale.current_a);
        }
    }
    ctl_turn_clear(&c->log);
    hal_order();
    c->log.ready = 0U;
}

/* ---- any context ------------------------------------------------------------------------------------------------------ */

float drive_current_offset_a(const drive_t *d, uint16_t phase)
{
    const drive_sensors_map_t *const m = &d->sensors.map[d->sensors.at & 1U];
    return (phase < 3U) ? (m->shift_a[phase] / m->scale[phase]) : 0.0f;
}

float drive_current_gain(const drive_t *d, uint16_t phase)
{
    return (phase < 3U) ? (1.0f / d->sensors.map[d->sensors.at & 1U].scale[phase]) : 1.0f;
}
