/* From the parameter list to the blocks. Everything here runs in the main loop but drive_take_over. */
#include "control/numeric/num_math.h"
#include "firmware/app/internal.h"
#include "hal/hal_clock.h"

#define TWO_PI 6.28318530718f
#ifdef EVENSPIN_FIXED
#define AXIS_BOUND 120.0f
#else
#define AXIS_BOUND 1.0e6f
#endif

static drive_scale_t make_scale(const drive_params_t *p)
{
#ifdef EVENSPIN_FIXED
    /* limits of the drive at 2 and 4 per unit: a wide margin to 128, and 6e-8 of these bases as the smallest step */
    const float         speed = p->over_speed_rad_s * 0.25f;
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

/* What fal's gain becomes when its argument is per unit; 1 in the float build. */
static float fal_gain_scale(float unit, float alpha)
{
#ifdef EVENSPIN_FIXED
    /* fal(x u) = u^alpha fal'(x) with u = error_unit; inside, everything is divided by u again: u^(alpha - 1).
     * unit^(alpha-1) = 2^((alpha-1) log2 unit), with unit = m 2^k so that both parts are in range */
    float   m = unit;
    int16_t k = 0;
    while (m >= 2.0f) {
        m *= 0.5f;
        k++;
    }
    while (m < 1.0f) {
        m *= 2.0f;
        k--;
    }
    const float log2_unit = (float)k + num_to_float(num_log2(num_from_float(m)));
    return num_to_float(num_exp2(num_from_float((alpha - 1.0f) * log2_unit)));
#else
    (void)unit;
    (void)alpha;
    return 1.0f;
#endif
}

static ctl_pi_params_t make_pi(float kp, float ki_ts, float limit)
{
    const ctl_pi_params_t pi = {num_from_float(kp), num_from_float(ki_ts), num_from_float(-limit), num_from_float(limit), CTL_PI_HOLD};
    return pi;
}

static void make_speed(const drive_params_t *p, drive_setup_t *s)
{
    const float ts_s = (float)p->speed_divider / (float)DRIVE_PWM_HZ;
    const float per_error = s->scale.error_unit / s->scale.current_a;

    s->speed_pi = make_pi(p->speed_kp_a_per_unit * per_error, p->speed_ki_a_per_unit_s * ts_s * per_error,
                          p->iq_limit_a / s->scale.current_a);
    s->speed_pi.anti_windup = CTL_PI_HOLD_OUTWARD;
    s->error_scale = num_from_float(p->speed_error_gain * s->scale.speed_rad_s / s->scale.error_unit);

    s->use_mt = p->speed_source == 1U;
    s->mt.sample_cyc = (hal_clock_hz() / DRIVE_PWM_HZ) * p->speed_divider;
    s->mt.speed_1_count = num_from_float(TWO_PI / ((float)p->encoder_counts * ts_s * s->scale.speed_rad_s));
    s->mt.speed_max = num_from_float(4.0f * p->over_speed_rad_s / s->scale.speed_rad_s);
    s->mt.stop_samples = 100U;
}

static void make_repetitive(const drive_params_t *p, drive_setup_t *s)
{
    const float ts_s = (float)p->speed_divider / (float)DRIVE_PWM_HZ;
    const bool  fal = p->method == (uint16_t)DRIVE_METHOD_FAL_FORC;

    s->rc_used = p->method != (uint16_t)DRIVE_METHOD_PI;
    s->rc.gain = num_from_float(p->rc_gain * ((fal && (p->rc_fal_at == 0U)) ? fal_gain_scale(s->scale.error_unit, p->rc_fal_alpha) : 1.0f));
    s->rc.lead = p->rc_lead;
    s->rc.q.side = num_from_float(p->rc_q_side);
    s->rc.q.centre = num_from_float(p->rc_q_centre);
    s->rc.order = (p->method == (uint16_t)DRIVE_METHOD_CRC) ? 0U : p->rc_order;
    s->rc.truncate = p->rc_truncate != 0U;
    s->rc.fal_at = fal ? ((p->rc_fal_at == 0U) ? CTL_RC_FAL_INPUT : CTL_RC_FAL_OUTPUT) : CTL_RC_FAL_NONE;
    s->rc.fal.alpha = num_from_float(p->rc_fal_alpha);
    s->rc.fal.delta = num_from_float(p->rc_fal_delta / s->scale.error_unit);
    s->rc.memory = (ctl_rc_memory_t)p->rc_memory;
    s->rc.limit = num_from_float(p->rc_limit_unit / s->scale.error_unit);
    s->rc.freeze_above = num_from_float(p->rc_freeze_above_unit / s->scale.error_unit);
    s->rc.freeze_samples = p->rc_freeze_samples;
    s->rc_capacity = (p->rc_memory == (uint16_t)CTL_RC_ANGLE) ? p->rc_cells : (uint16_t)DRIVE_RC_CAPACITY;
    s->rc_period_scale = num_from_float(TWO_PI / ((float)p->pole_pairs * ts_s * s->scale.speed_rad_s));
}

/* Which parameter a block meant. */
static uint16_t rc_culprit(uint16_t field)
{
    static const uint16_t PARAM_OF[] = {PARAM_COUNT,        PARAM_rc_gain,      PARAM_rc_lead,      PARAM_rc_q_centre,
                                        PARAM_rc_order,     PARAM_rc_fal_at,    PARAM_rc_fal_alpha, PARAM_rc_fal_delta,
                                        PARAM_rc_memory,    PARAM_rc_limit_unit, PARAM_rc_freeze_above_unit, PARAM_rc_cells};
    return (field < (sizeof PARAM_OF / sizeof PARAM_OF[0])) ? PARAM_OF[field] : (uint16_t)PARAM_rc_gain;
}

uint16_t drive_make_setup(const drive_params_t *p, drive_setup_t *s)
{
    const uint16_t bad = params_check(p);
    if (bad != (uint16_t)PARAM_COUNT) {
        return bad;
    }
    if (!(p->under_voltage_v < p->over_voltage_v)) {
        return PARAM_under_voltage_v;
    }
    if (!(p->iq_limit_a <= p->over_current_a)) {
        return PARAM_iq_limit_a;
    }
    const float ts_s = 1.0f / (float)DRIVE_PWM_HZ;

    s->scale = make_scale(p);
    /* ctl_vector_limit limits the voltage as a whole, keeping its direction; the limits of the two controllers are far
     * outside and only keep them bounded */
    const float per_amp = s->scale.current_a * s->scale.inv_voltage;
    s->current_pi = make_pi(p->current_kp_v_per_a * per_amp, p->current_ki_v_per_as * ts_s * per_amp, AXIS_BOUND);

    s->pll.kp_ts = num_from_float(p->pll_kp_per_s * ts_s);
    s->pll.ki_ts = num_from_float(p->pll_ki_per_s2 * ts_s / s->scale.speed_rad_s);
    s->pll.rad_per_speed_ts = num_from_float(ts_s * s->scale.speed_rad_s);
    s->pll.speed_max = num_from_float(1.5f * p->over_speed_rad_s / s->scale.speed_rad_s);

    make_speed(p, s);
    make_repetitive(p, s);

    s->voltage_limit = num_from_float(p->voltage_limit_v / s->scale.voltage_v);
    s->advance = num_from_float(p->angle_advance_periods * ts_s * (float)p->pole_pairs * s->scale.speed_rad_s);
    s->id_limit = num_from_float(p->id_limit_a / s->scale.current_a);
    s->align_current = num_from_float(p->align_current_a / s->scale.current_a);
    s->encoder_offset = angle_from_rad(num_from_float(p->encoder_offset_rad));
    s->period_cyc = hal_clock_hz() / DRIVE_PWM_HZ;
    s->pole_pairs = p->pole_pairs;
    s->speed_divider = p->speed_divider;
    s->speed_inline = p->speed_inline != 0U;
    s->encoder_reversed = p->encoder_reversed != 0U;

    /* let every block judge, on copies: what is refused must not have changed anything */
    ctl_pi_t  pi;
    ctl_pll_t pll;
    ctl_mt_t  mt;
    ctl_rc_t  rc;
    num_t     cells[16];
    if (ctl_pi_init(&pi, &s->current_pi).status != CTL_OK) {
        return PARAM_current_kp_v_per_a;
    }
    if (ctl_pi_init(&pi, &s->speed_pi).status != CTL_OK) {
        return PARAM_iq_limit_a; /* 0 leaves no room between the limits */
    }
    const ctl_diag_t d = ctl_pll_init(&pll, &s->pll);
    if (d.status != CTL_OK) {
        return (d.field == (uint16_t)CTL_PLL_KP) ? PARAM_pll_kp_per_s
                                                 : ((d.field == (uint16_t)CTL_PLL_KI) ? PARAM_pll_ki_per_s2 : PARAM_over_speed_rad_s);
    }
    if (ctl_mt_init(&mt, &s->mt).status != CTL_OK) {
        return PARAM_encoder_counts;
    }
    if (s->rc_used) {
        /* the judgement needs no more than the smallest memory, unless the lead asks for it */
        ctl_rc_params_t    trial = s->rc;
        const uint16_t     room = (uint16_t)(sizeof cells / sizeof cells[0]);
        const uint16_t     need = (uint16_t)(trial.lead + trial.order + 5U);
        if (s->rc_capacity < need) {
            return PARAM_rc_cells;
        }
        if (need > room) {
            trial.lead = (trial.lead <= CTL_RC_LEAD_MAX) ? 2U : trial.lead;
        }
        const ctl_diag_t r = ctl_rc_init(&rc, &trial, cells, room);
        if (r.status != CTL_OK) {
            return rc_culprit(r.field);
        }
    }
    return PARAM_COUNT;
}

uint16_t drive_build(drive_t *d)
{
    drive_setup_t *const s = &d->setup;
    const uint16_t       bad = drive_make_setup(&d->params, s);
    if (bad != (uint16_t)PARAM_COUNT) {
        return bad;
    }
    d->scale = s->scale;
    d->tracking.zero_e = s->encoder_offset;
    /* all of these were accepted a moment ago */
    (void)ctl_pi_init(&d->current.d, &s->current_pi);
    (void)ctl_pi_init(&d->current.q, &s->current_pi);
    (void)ctl_pi_init(&d->speed.pi, &s->speed_pi);
    (void)ctl_pll_init(&d->tracking.pll, &s->pll);
    (void)ctl_mt_init(&d->speed.mt, &s->mt);
    if (s->rc_used) {
        (void)ctl_rc_init(&d->speed.rc, &s->rc, d->rc_memory, s->rc_capacity);
    }
    return PARAM_COUNT;
}

bool drive_tune(drive_t *d, const drive_params_t *params, uint16_t *culprit)
{
    *culprit = PARAM_COUNT;
    if (d->next_ready != 0U) {
        return false;
    }
    *culprit = drive_make_setup(params, &d->next);
    if (*culprit != (uint16_t)PARAM_COUNT) {
        return false;
    }
#ifdef EVENSPIN_FIXED
    /* a new base would rescale every state: only at rest */
    if ((d->next.scale.current_a != d->scale.current_a) || (d->next.scale.voltage_v != d->scale.voltage_v) ||
        (d->next.scale.error_unit != d->scale.error_unit)) {
        *culprit = PARAM_over_speed_rad_s;
        return false;
    }
#endif
    d->params = *params;
    d->next_ready = 1U;
    return true;
}

void drive_take_over(drive_t *d)
{
    const drive_setup_t *const s = &d->next;
    const bool same_memory = d->setup.rc_used && (d->setup.rc.memory == s->rc.memory) && (d->setup.rc_capacity == s->rc_capacity) &&
                             (d->setup.rc.order == s->rc.order) && (d->setup.rc.lead == s->rc.lead);
    d->setup = *s;
    if (d->params.align_periods == 0U) {
        d->tracking.zero_e = s->encoder_offset;
    }
    d->current.d.params = s->current_pi;
    d->current.q.params = s->current_pi;
    d->speed.pi.params = s->speed_pi;
    d->tracking.pll.params = s->pll;
    d->speed.mt.params = s->mt;
    if (s->rc_used && same_memory) {
        d->speed.rc.params = s->rc;
        (void)ctl_fal_init(&d->speed.rc.fal, &s->rc.fal);
    } else if (s->rc_used) {
        (void)ctl_rc_init(&d->speed.rc, &s->rc, d->rc_memory, s->rc_capacity);
        d->speed.correction = (num_t)0;
    } else {
        d->speed.correction = (num_t)0;
    }
    d->next_ready = 0U;
}
