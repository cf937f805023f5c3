/* The observers of the disturbance torque, and the meter in front of them. Their step is in current_isr.c, their retune in
 * take_over.c. Main loop. */
#include "firmware/app/internal.h"

drive_observer_word_t drive_observer_asked(const drive_params_t *p)
{
    return (drive_observer_word_t)((p->method >= (uint16_t)DRIVE_METHOD_DOB) ? ((p->method - (uint16_t)DRIVE_METHOD_DOB) + 1U)
                                                                             : p->disturbance_observer);
}

/* Without an observer it is the smallest kind, which is not run. */
static ctl_observer_kind_t kind_of(drive_observer_word_t asked)
{
    switch (asked) {
    case DRIVE_OBSERVER_RO:
        return CTL_OBSERVER_RO;
    case DRIVE_OBSERVER_ARO:
        return CTL_OBSERVER_ARO;
    default:
        return CTL_OBSERVER_DOB;
    }
}

/* Torque is counted in ampere of q current: J / (T_s k_T) is all that the observer needs of the machine. */
uint16_t drive_make_observer(const drive_params_t *p, const drive_scale_t *scale, drive_observer_setup_t *s)
{
    const float ts_s = 1.0f / (float)DRIVE_PWM_HZ;
    const float torque_per_amp = 1.5f * (float)p->pole_pairs * p->motor_psi_wb;
    const float amp_per_speed = p->observer_inertia_kgm2 / (ts_s * torque_per_amp);

    s->used = drive_observer_asked(p) != DRIVE_OBSERVER_NONE;
    s->speed_asked = p->speed_source == (uint16_t)DRIVE_SPEED_FIR;
    s->meter_used = s->used || s->speed_asked;
    if (!s->meter_used) {
        return PARAM_COUNT;
    }
    uint16_t culprit = PARAM_COUNT;
    s->meter.speed_per_rad = drive_fitted(scale->inv_speed / ts_s, PARAM_over_speed_rad_s, &culprit);
    s->meter.torque_per_16 =
        drive_fitted(amp_per_speed * scale->speed_rad_s * scale->inv_current / 16.0f, PARAM_observer_inertia_kgm2, &culprit);
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
    o->kind = kind_of(drive_observer_asked(p));
    o->memory.gain = num_from_float(p->observer_gain);
    o->memory.forgetting = num_from_float(p->observer_forgetting);
    o->memory.write = (ctl_write_t)p->aro_write;
    o->memory.read = (ctl_read_t)p->aro_read;
    o->memory.limit = num_from_float(p->observer_limit_a * scale->inv_current);
    o->age_half =
        (p->observer_age_samples > 0.0f) ? (uint16_t)((2.0f * p->observer_age_samples) + 0.5f) : ctl_meter_age_half(&s->meter);
    o->ahead = s->meter.actuation;
    o->rad_per_64 = num_from_float(64.0f * ts_s * scale->speed_rad_s); /* of one sample fixed point would know it to 10^-6 */
    o->fast_gain = num_from_float(p->aro_fast_gain);
    o->fast_samples = (uint32_t)(p->aro_fast_s * (float)DRIVE_PWM_HZ);
    o->remove_mean = p->aro_remove_mean != 0U;
    o->feeds = (p->position_method == (uint16_t)DRIVE_POSITION_RDC) || (p->speed_model_ff != 0U);
    o->rest_torque = num_from_float(p->aro_rest_torque_a * scale->inv_current);
    o->rest_turns = num_from_float(p->aro_rest_turns);
    o->rest_step = num_from_float(p->aro_rest_accel_rad_s2 * ts_s * scale->inv_speed);
    o->rest_samples = (uint32_t)(p->aro_rest_s * (float)DRIVE_PWM_HZ);
    o->encoder_counts = (uint32_t)p->encoder_counts;
    o->sync_band = num_from_float(p->aro_sync_hz * ts_s);
    o->drift_most = (uint16_t)((256.0f * p->aro_drift_counts) + 0.5f);
    s->hold = p->observer_hold != 0U;
    s->capacity = (o->kind == CTL_OBSERVER_ARO) ? p->aro_cells : (uint16_t)DRIVE_OBSERVER_CAPACITY;
    return culprit;
}

static uint16_t observer_culprit(uint16_t field)
{
    static const uint16_t PARAM_OF[] = {[0] = PARAM_COUNT,
                                        [CTL_OBSERVER_KIND] = PARAM_method,
                                        [CTL_OBSERVER_GAIN] = PARAM_observer_gain,
                                        [CTL_OBSERVER_FORGETTING] = PARAM_observer_forgetting,
                                        [CTL_OBSERVER_LIMIT] = PARAM_observer_limit_a,
                                        [CTL_OBSERVER_AGE] = PARAM_observer_age_samples,
                                        [CTL_OBSERVER_AHEAD] = PARAM_observer_actuation_samples,
                                        [CTL_OBSERVER_RAD] = PARAM_over_speed_rad_s,
                                        [CTL_OBSERVER_FAST_GAIN] = PARAM_aro_fast_gain,
                                        [CTL_OBSERVER_REST] = PARAM_aro_rest_torque_a,
                                        [CTL_OBSERVER_SYNC] = PARAM_aro_sync_hz,
                                        [CTL_OBSERVER_MEMORY] = PARAM_aro_cells};
    return (field < (sizeof PARAM_OF / sizeof PARAM_OF[0])) ? PARAM_OF[field] : (uint16_t)PARAM_method;
}

static uint16_t meter_culprit(uint16_t field)
{
    static const uint16_t PARAM_OF[] = {[0] = PARAM_COUNT,
                                        [CTL_METER_SPEED] = PARAM_over_speed_rad_s,
                                        [CTL_METER_TORQUE] = PARAM_observer_inertia_kgm2,
                                        [CTL_METER_A22] = PARAM_observer_viscous_nms,
                                        [CTL_METER_FIR1] = PARAM_observer_fir1_hz,
                                        [CTL_METER_FIR2] = PARAM_observer_fir2_hz,
                                        [CTL_METER_ACTUATION] = PARAM_observer_actuation_samples,
                                        [CTL_METER_STEP] = PARAM_over_speed_rad_s};
    return (field < (sizeof PARAM_OF / sizeof PARAM_OF[0])) ? PARAM_OF[field] : (uint16_t)PARAM_observer_inertia_kgm2;
}

uint16_t drive_judge_observer(const drive_observer_setup_t *s)
{
    if (!s->meter_used) {
        return PARAM_COUNT;
    }
    ctl_diag_t d = ctl_meter_check(&s->meter);
    if (d.status != CTL_OK) {
        return meter_culprit(d.field);
    }
    d = ctl_observer_check(&s->observer);
    return (d.status == CTL_OK) ? (uint16_t)PARAM_COUNT : observer_culprit(d.field);
}

void drive_build_meter(drive_observer_t *o, const drive_observer_setup_t *s)
{
    if (s->meter_used) {
        (void)ctl_meter_init(&o->meter, &s->meter);
    }
}

void drive_build_observer(drive_observer_t *o, const drive_observer_setup_t *s, num_t *memory)
{
    if (s->used) {
        (void)ctl_observer_init(&o->observer, &s->observer, memory, s->capacity);
        ctl_observer_hold(&o->observer, s->hold);
    }
}

void drive_rest_observer(drive_observer_t *o, const drive_observer_setup_t *s)
{
    ctl_meter_reset(&o->meter);
    if (s->used) {
        ctl_observer_reset(&o->observer, true); /* what was learned survives a stop */
    }
}

static bool same_filter(const ctl_fir_params_t *a, const ctl_fir_params_t *b)
{
    bool same = a->order == b->order;
    for (uint16_t i = 0U; same && (i <= a->order); i++) {
        same = a->tap[i] == b->tap[i];
    }
    return same;
}

/* A speed filter that nobody has asked for stands. */
static bool same_meter(const drive_observer_setup_t *before, const drive_observer_setup_t *s)
{
    return before->meter_used && same_filter(&before->meter.fir1, &s->meter.fir1) &&
           same_filter(&before->meter.fir2, &s->meter.fir2) && (before->speed_asked || !s->speed_asked);
}

bool drive_meter_differs(const drive_observer_setup_t *before, const drive_observer_setup_t *s)
{
    return s->meter_used && !same_meter(before, s);
}

bool drive_observer_differs(const drive_observer_setup_t *before, const drive_observer_setup_t *s)
{
    return s->used && !(before->used && (before->observer.kind == s->observer.kind) && (before->capacity == s->capacity));
}
