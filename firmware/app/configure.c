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
    /* fal(x u) = u^alpha fal'(x) with u = error_unit; inside, everything is divided by u again: u^(alpha - 1). So it is for
     * lambda(x u), too, which multiplies the output.
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

/* A scaled number. When it is beyond the numeric, 128 per unit in the fixed build, its parameter is noted as the culprit:
 * cutting it would give another drive than the one asked for. */
static num_t fitted(float x, uint16_t param, uint16_t *culprit)
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

    s->speed_pi = make_pi(fitted(p->speed_kp_a_per_unit * per_error, PARAM_speed_kp_a_per_unit, culprit),
                          fitted(p->speed_ki_a_per_unit_s * ts_s * per_error, PARAM_speed_ki_a_per_unit_s, culprit),
                          p->iq_limit_a / s->scale.current_a);
    s->speed_pi.anti_windup = CTL_PI_HOLD_OUTWARD;
    s->error_scale = num_from_float(p->speed_error_gain * s->scale.speed_rad_s / s->scale.error_unit);

    s->speed_source = (drive_speed_source_t)p->speed_source;
    s->mt.sample_cyc = (hal_clock_hz() / DRIVE_PWM_HZ) * p->speed_divider;
    s->mt.speed_1_count = fitted(TWO_PI / (p->encoder_counts * ts_s * s->scale.speed_rad_s), PARAM_over_speed_rad_s, culprit);
    s->mt.speed_max = num_from_float(4.0f * p->over_speed_rad_s / s->scale.speed_rad_s);
    s->mt.stop_samples = 100U;
}

static void make_repetitive(const drive_params_t *p, drive_setup_t *s, uint16_t *culprit)
{
    const float ts_s = (float)p->speed_divider / (float)DRIVE_PWM_HZ;
    const bool  fal = p->method == (uint16_t)DRIVE_METHOD_FAL_FORC;
    const float fal_scale = fal ? fal_gain_scale(s->scale.error_unit, p->rc_fal_alpha) : 1.0f;

    s->rc_used = (p->method >= (uint16_t)DRIVE_METHOD_CRC) && (p->method <= (uint16_t)DRIVE_METHOD_FAL_FORC);
    s->rc.gain = num_from_float(p->rc_gain * fal_scale);
    s->rc.lead = p->rc_lead;
    s->rc.q.side = num_from_float(p->rc_q_side);
    s->rc.q.centre = num_from_float(p->rc_q_centre);
    s->rc.order = (p->method == (uint16_t)DRIVE_METHOD_CRC) ? 0U : p->rc_order;
    s->rc.truncate = p->rc_truncate != 0U;
    s->rc.fal_at = fal ? ((p->rc_fal_at == 0U) ? CTL_RC_FAL_INPUT : CTL_RC_FAL_OUTPUT) : CTL_RC_FAL_NONE;
    s->rc.fal.alpha = num_from_float(p->rc_fal_alpha);
    s->rc.fal.delta = num_from_float(p->rc_fal_delta / s->scale.error_unit);
    s->rc.memory = (ctl_rc_memory_t)p->rc_memory;
    /* fal at the output: what it will multiply is smaller by this than what leaves the controller */
    s->rc.limit = num_from_float(p->rc_limit_unit / s->scale.error_unit * ((s->rc.fal_at == CTL_RC_FAL_OUTPUT) ? fal_scale : 1.0f));
    s->rc.freeze_above = num_from_float(p->rc_freeze_above_unit / s->scale.error_unit);
    s->rc.freeze_samples = p->rc_freeze_samples;
    s->rc_capacity = (p->rc_memory == (uint16_t)CTL_RC_ANGLE) ? p->rc_cells : (uint16_t)DRIVE_RC_CAPACITY;
    if (s->rc_used) {
        s->rc_period_scale = fitted(TWO_PI / ((float)p->pole_pairs * ts_s * s->scale.speed_rad_s), PARAM_over_speed_rad_s, culprit);
    }
}

static void make_deadbeat(const drive_params_t *p, drive_setup_t *s)
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
    s->deadbeat.v_max = num_from_float(AXIS_BOUND);
}

/* Torque is counted in ampere of q current: J / (T_s k_T) is all that the observer needs of the machine. */
static uint16_t make_observer(const drive_params_t *p, drive_setup_t *s)
{
    const float ts_s = 1.0f / (float)DRIVE_PWM_HZ;
    const float torque_per_amp = 1.5f * (float)p->pole_pairs * p->motor_psi_wb;
    const float amp_per_speed = p->observer_inertia_kgm2 / (ts_s * torque_per_amp);

    s->observer_used = p->method >= (uint16_t)DRIVE_METHOD_DOB;
    s->meter_used = s->observer_used || (s->speed_source == DRIVE_SPEED_FIR);
    if (!s->meter_used) {
        return PARAM_COUNT;
    }
    s->meter.speed_per_rad = num_from_float(s->scale.inv_speed / ts_s);
    s->meter.torque_per_16 = num_from_float(amp_per_speed * s->scale.speed_rad_s * s->scale.inv_current / 16.0f);
    s->meter.a22 = num_from_float(1.0f - (p->observer_viscous_nms * ts_s / p->observer_inertia_kgm2));
    s->meter.actuation = num_from_float(p->observer_actuation_samples);
    s->meter.step_max_rad = num_min(num_from_float(4.0f * p->over_speed_rad_s * ts_s), NUM_C(3.1415f));
    if (ctl_fir_design(&s->meter.fir1, p->observer_fir1_order, num_from_float(p->observer_fir1_hz * ts_s)).status != CTL_OK) {
        return PARAM_observer_fir1_hz;
    }
    if (ctl_fir_design(&s->meter.fir2, p->observer_fir2_order, num_from_float(p->observer_fir2_hz * ts_s)).status != CTL_OK) {
        return PARAM_observer_fir2_hz;
    }

    ctl_observer_params_t *const o = &s->observer;
    const ctl_observer_kind_t    kind[] = {CTL_OBSERVER_DOB, CTL_OBSERVER_RO, CTL_OBSERVER_ARO};
    o->kind = s->observer_used ? kind[p->method - (uint16_t)DRIVE_METHOD_DOB] : CTL_OBSERVER_DOB;
    o->memory.gain = num_from_float(p->observer_gain);
    o->memory.forgetting = num_from_float(p->observer_forgetting);
    o->memory.write = (ctl_write_t)p->aro_write;
    o->memory.read = (ctl_read_t)p->aro_read;
    o->memory.limit = num_from_float(p->observer_limit_a * s->scale.inv_current);
    o->age_half = (p->observer_age_samples > 0.0f) ? (uint16_t)((2.0f * p->observer_age_samples) + 0.5f) : ctl_meter_age_half(&s->meter);
    o->ahead = s->meter.actuation;
    o->rad_per_speed = num_from_float(ts_s * s->scale.speed_rad_s);
    o->fast_gain = num_from_float(p->aro_fast_gain);
    o->fast_samples = (uint32_t)(p->aro_fast_s * (float)DRIVE_PWM_HZ);
    o->remove_mean = p->aro_remove_mean != 0U;
    o->rest_torque = num_from_float(p->aro_rest_torque_a * s->scale.inv_current);
    o->rest_turns = num_from_float(p->aro_rest_turns);
    o->rest_step = num_from_float(p->aro_rest_accel_rad_s2 * ts_s * s->scale.inv_speed);
    o->rest_samples = (uint32_t)(p->aro_rest_s * (float)DRIVE_PWM_HZ);
    o->encoder_counts = (uint32_t)p->encoder_counts;
    o->sync_band = num_from_float(p->aro_sync_hz * ts_s);
    s->observer_hold = p->observer_hold != 0U;
    s->observer_capacity = (o->kind == CTL_OBSERVER_ARO) ? p->aro_cells : (uint16_t)DRIVE_OBSERVER_CAPACITY;
    return PARAM_COUNT;
}

static uint16_t observer_culprit(uint16_t field)
{
    static const uint16_t PARAM_OF[] = {PARAM_COUNT,
                                        PARAM_method,
                                        PARAM_observer_gain,
                                        PARAM_observer_forgetting,
                                        PARAM_observer_limit_a,
                                        PARAM_observer_age_samples,
                                        PARAM_observer_actuation_samples,
                                        PARAM_over_speed_rad_s,
                                        PARAM_aro_fast_gain,
                                        PARAM_aro_rest_torque_a,
                                        PARAM_aro_sync_hz,
                                        PARAM_aro_cells};
    return (field < (sizeof PARAM_OF / sizeof PARAM_OF[0])) ? PARAM_OF[field] : (uint16_t)PARAM_method;
}

static uint16_t meter_culprit(uint16_t field)
{
    static const uint16_t PARAM_OF[] = {PARAM_COUNT,
                                        PARAM_over_speed_rad_s,
                                        PARAM_observer_inertia_kgm2,
                                        PARAM_observer_viscous_nms,
                                        PARAM_observer_fir1_hz,
                                        PARAM_observer_fir2_hz,
                                        PARAM_observer_actuation_samples,
                                        PARAM_over_speed_rad_s};
    return (field < (sizeof PARAM_OF / sizeof PARAM_OF[0])) ? PARAM_OF[field] : (uint16_t)PARAM_observer_inertia_kgm2;
}

static uint16_t judge_observer(const drive_setup_t *s)
{
    ctl_meter_t    meter;
    ctl_observer_t observer;
    num_t          room[CTL_ARO_AGE_MAX + 34U];
    if (!s->meter_used) {
        return PARAM_COUNT;
    }
    ctl_diag_t d = ctl_meter_init(&meter, &s->meter);
    if (d.status != CTL_OK) {
        return meter_culprit(d.field);
    }
    d = ctl_observer_init(&observer, &s->observer, room, (uint16_t)(sizeof room / sizeof room[0]));
    return (d.status == CTL_OK) ? (uint16_t)PARAM_COUNT : observer_culprit(d.field);
}

static uint16_t judge_deadbeat(const drive_setup_t *s)
{
    static const uint16_t PARAM_OF[] = {PARAM_COUNT,      PARAM_motor_resistance_ohm, PARAM_motor_ld_h,   PARAM_motor_lq_h,
                                        PARAM_motor_psi_wb, PARAM_deadbeat_correction, PARAM_over_current_a};
    ctl_deadbeat_t   trial;
    const ctl_diag_t d = ctl_deadbeat_init(&trial, &s->deadbeat);
    return (d.status == CTL_OK) ? (uint16_t)PARAM_COUNT : PARAM_OF[d.field];
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
    uint16_t bad = params_check(p);
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
    s->current_pi = make_pi(fitted(p->current_kp_v_per_a * per_amp, PARAM_current_kp_v_per_a, &bad),
                            fitted(p->current_ki_v_per_as * ts_s * per_amp, PARAM_current_ki_v_per_as, &bad), AXIS_BOUND);

    s->pll.kp_ts = num_from_float(p->pll_kp_per_s * ts_s);
    s->pll.ki_ts = fitted(p->pll_ki_per_s2 * ts_s / s->scale.speed_rad_s, PARAM_pll_ki_per_s2, &bad);
    s->pll.rad_per_speed_ts = num_from_float(ts_s * s->scale.speed_rad_s);
    s->pll.speed_max = num_from_float(1.5f * p->over_speed_rad_s / s->scale.speed_rad_s);

    make_speed(p, s, &bad);
    make_repetitive(p, s, &bad);
    if (bad != (uint16_t)PARAM_COUNT) {
        return bad;
    }
    make_deadbeat(p, s);
    const uint16_t unfit = make_observer(p, s);
    if (unfit != (uint16_t)PARAM_COUNT) {
        return unfit;
    }

    s->voltage_limit = num_from_float(p->voltage_limit_v / s->scale.voltage_v);
    s->advance = num_from_float(p->angle_advance_periods * ts_s * (float)p->pole_pairs * s->scale.speed_rad_s);
    s->id_limit = num_from_float(p->id_limit_a / s->scale.current_a);
    s->align_current = num_from_float(p->align_current_a / s->scale.current_a);
    /* a twentieth of the alignment as lead time damps every rotor that swings at 20 rad or more in that time */
    s->align_damping = num_from_float(0.05f * (float)p->align_periods * ts_s * (float)p->pole_pairs * s->scale.speed_rad_s);
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
    const uint16_t model = judge_deadbeat(s);
    const uint16_t observer = (model != (uint16_t)PARAM_COUNT) ? model : judge_observer(s);
    return (observer != (uint16_t)PARAM_COUNT) ? observer : drive_make_position(p, s);
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
    (void)ctl_deadbeat_init(&d->current.deadbeat, &s->deadbeat);
    drive_build_position(d);
    if (s->meter_used) {
        (void)ctl_meter_init(&d->observer.meter, &s->meter);
    }
    if (s->observer_used) {
        (void)ctl_observer_init(&d->observer.observer, &s->observer, d->observer_memory, s->observer_capacity);
        ctl_observer_hold(&d->observer.observer, s->observer_hold);
    }
    return PARAM_COUNT;
}

/* A new base would rescale every state: only drive_init does that. All bases are 1 in the float build. */
static uint16_t changed_base(const drive_scale_t *wanted, const drive_scale_t *used)
{
    if (wanted->current_a != used->current_a) {
        return PARAM_over_current_a;
    }
    if (wanted->voltage_v != used->voltage_v) {
        return PARAM_over_voltage_v;
    }
    if (wanted->speed_rad_s != used->speed_rad_s) {
        return PARAM_over_speed_rad_s;
    }
    return (wanted->error_unit != used->error_unit) ? (uint16_t)PARAM_speed_error_gain : (uint16_t)PARAM_COUNT;
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
    *culprit = changed_base(&d->next.scale, &d->scale);
    if (*culprit != (uint16_t)PARAM_COUNT) {
        return false;
    }
    d->next_params = *params;
    d->next_ready = 1U;
    return true;
}

static void take_over_repetitive(drive_t *d, const drive_setup_t *before, const drive_setup_t *s)
{
    const bool same_memory = before->rc_used && (before->rc.memory == s->rc.memory) && (before->rc_capacity == s->rc_capacity) &&
                             (before->rc.order == s->rc.order) && (before->rc.lead == s->rc.lead);
    if (s->rc_used && same_memory) {
        d->speed.rc.params = s->rc;
        (void)ctl_fal_init(&d->speed.rc.fal, &s->rc.fal);
        return;
    }
    if (s->rc_used) {
        (void)ctl_rc_init(&d->speed.rc, &s->rc, d->rc_memory, s->rc_capacity);
    }
    d->speed.correction = (num_t)0;
}

static void take_over_observer(drive_t *d, const drive_setup_t *before, const drive_setup_t *s)
{
    const bool same_chain = before->meter_used && (before->meter.fir1.order == s->meter.fir1.order) &&
                            (before->meter.fir2.order == s->meter.fir2.order);
    const bool same_memory = before->observer_used && (before->observer.kind == s->observer.kind) &&
                             (before->observer_capacity == s->observer_capacity);
    if (s->meter_used && same_chain) {
        d->observer.meter.params = s->meter;
        d->observer.meter.state.speed_fir.params = s->meter.fir1;
        d->observer.meter.state.ref_fir.params = s->meter.fir1;
        d->observer.meter.state.torque_fir.params = s->meter.fir2;
    } else if (s->meter_used) {
        (void)ctl_meter_init(&d->observer.meter, &s->meter);
    } else {
        /* nobody looks at it */
    }
    if (s->observer_used && same_memory) {
        d->observer.observer.params = s->observer;
        d->observer.observer.state.memory.params = s->observer.memory;
    } else if (s->observer_used) {
        (void)ctl_observer_init(&d->observer.observer, &s->observer, d->observer_memory, s->observer_capacity);
    } else {
        d->observer.estimate = (num_t)0;
    }
    ctl_observer_hold(&d->observer.observer, s->observer_hold);
}

void drive_take_over(drive_t *d)
{
    const drive_setup_t *const s = &d->next;
    take_over_repetitive(d, &d->setup, s);
    take_over_observer(d, &d->setup, s);
    if (s->deadbeat_used && !d->setup.deadbeat_used) {
        ctl_deadbeat_reset(&d->current.deadbeat);
    }
    d->setup = *s;
    d->params = d->next_params;
    if (!d->tracking.zero_found) {
        d->tracking.zero_e = s->encoder_offset;
    }
    d->current.d.params = s->current_pi;
    d->current.q.params = s->current_pi;
    d->current.deadbeat.params = s->deadbeat;
    d->speed.pi.params = s->speed_pi;
    d->tracking.pll.params = s->pll;
    d->speed.mt.params = s->mt;
    d->next_ready = 0U;
}
