/* The position loop's configuration: profile, cascade, and what its method adds. Its step is in position.c, its retune in take_over.c.
 * Main loop. */
#include "firmware/app/internal.h"

#define LEARN_LEAD 3U /* samples from a torque command to the velocity it changes */

static uint16_t make_profile(const drive_params_t *p, float speed_rad_s, ctl_profile_params_t *out, const drive_scale_t *scale)
{
    const float ts_s = (float)p->speed_divider / (float)DRIVE_PWM_HZ;
    out->speed = drive_turns_q32(speed_rad_s / DRIVE_TWO_PI * ts_s);
    out->acceleration = drive_turns_q32(p->profile_accel_rad_s2 / DRIVE_TWO_PI * ts_s * ts_s);
    if ((p->profile_accel_rad_s2 > 0.0f) && (out->acceleration == 0)) {
        out->acceleration = 1; /* slower than one step: the slowest there is */
    }
    out->smooth = p->profile_smooth_samples;
    out->speed_scale = drive_number(DRIVE_TWO_PI / 65536.0f / ts_s * scale->inv_speed);
    out->accel_scale = drive_number(DRIVE_TWO_PI / 1048576.0f / (ts_s * ts_s) * scale->inv_speed);
    const ctl_diag_t d = ctl_profile_check(out);
    if (d.status == CTL_OK) {
        return PARAM_COUNT;
    }
    return (d.field == (uint16_t)CTL_PROFILE_SPEED)
               ? PARAM_profile_speed_rad_s
               : ((d.field == (uint16_t)CTL_PROFILE_SMOOTH) ? PARAM_profile_smooth_samples : PARAM_profile_accel_rad_s2);
}

/* @param culprit  of what is beyond the numeric, unless there is one already */
static void make_rdc(const drive_params_t *p, const drive_scale_t *scale, ctl_rdc_params_t *out, uint16_t *culprit)
{
    const float ts_s = (float)p->speed_divider / (float)DRIVE_PWM_HZ;
    const float per_nm = scale->inv_current / (1.5f * (float)p->pole_pairs * p->motor_psi_wb);
    out->inertia = drive_fitted(p->rdc_inertia_kgm2 * scale->speed_rad_s * per_nm, PARAM_rdc_inertia_kgm2, culprit);
    out->friction.viscous = drive_fitted(p->rdc_viscous_nms * scale->speed_rad_s * per_nm, PARAM_rdc_viscous_nms, culprit);
    out->friction.coulomb = drive_fitted(p->rdc_coulomb_nm * per_nm, PARAM_rdc_coulomb_nm, culprit);
    out->friction.stat = drive_fitted(p->rdc_static_nm * per_nm, PARAM_rdc_static_nm, culprit);
    out->friction.stribeck = drive_number(p->rdc_stribeck_rad_s * scale->inv_speed);
    out->friction.shape = drive_number(p->rdc_shape);
    out->harmonics.lines = 0U;
    for (uint16_t i = 0U; i < CTL_HARMONICS_MAX; i++) {
        const uint16_t first = (uint16_t)(PARAM_rdc_line1_cycles + (3U * i)); /* cycles, amplitude and phase stand in a row */
        const float    amplitude_nm = params_get(p, (uint16_t)(first + 1U));
        if (amplitude_nm > 0.0f) {
            ctl_line_t *const l = &out->harmonics.line[out->harmonics.lines];
            l->cycles_q20 = ctl_cycles_q20(params_get(p, first));
            l->amplitude = drive_number(amplitude_nm * per_nm);
            l->phase = angle_from_rad(drive_number(params_get(p, (uint16_t)(first + 2U))));
            out->harmonics.lines++;
        }
    }
    const float per_inertia = (p->rdc_inertia_kgm2 > 0.0f) ? (1.0f / p->rdc_inertia_kgm2) : 0.0f;
    out->p_row[0] = drive_fitted(p->rdc_p31 * per_inertia, PARAM_rdc_p31, culprit);
    out->p_row[1] = drive_fitted(p->rdc_p32 * per_inertia, PARAM_rdc_p32, culprit);
    out->p_row[2] = drive_fitted(p->rdc_p33 * per_inertia * scale->speed_rad_s, PARAM_rdc_p33, culprit);
    out->rho = drive_fitted(p->rdc_rho_nm * per_nm, PARAM_rdc_rho_nm, culprit);
    out->sigma = drive_number(p->rdc_sigma);
    out->sample_s = drive_number(ts_s);
    out->integral_max = NUM_C(100.0f);
}

static uint16_t rdc_culprit(uint16_t field)
{
    static const uint16_t PARAM_OF[] = {[0] = PARAM_COUNT,
                                        [CTL_RDC_INERTIA] = PARAM_rdc_inertia_kgm2,
                                        [CTL_RDC_FRICTION] = PARAM_rdc_stribeck_rad_s,
                                        [CTL_RDC_STATIC] = PARAM_rdc_static_nm,
                                        [CTL_RDC_HARMONICS] = PARAM_rdc_line1_nm,
                                        [CTL_RDC_P] = PARAM_rdc_p33,
                                        [CTL_RDC_RHO] = PARAM_rdc_rho_nm,
                                        [CTL_RDC_SIGMA] = PARAM_rdc_sigma,
                                        [CTL_RDC_SAMPLE] = PARAM_speed_divider};
    return (field < (sizeof PARAM_OF / sizeof PARAM_OF[0])) ? PARAM_OF[field] : (uint16_t)PARAM_rdc_inertia_kgm2;
}

uint16_t drive_make_position(const drive_params_t *p, const drive_scale_t *scale, drive_position_setup_t *q)
{
    const float ts_s = (float)p->speed_divider / (float)DRIVE_PWM_HZ;
    const float per_speed = scale->speed_rad_s * scale->inv_current;

    q->method = (drive_position_method_t)p->position_method;
    uint16_t bad = make_profile(p, p->profile_speed_rad_s, &q->profile, scale);
    if (bad == (uint16_t)PARAM_COUNT) {
        const float speed = (p->homing_speed_rad_s < 0.0f) ? -p->homing_speed_rad_s : p->homing_speed_rad_s;
        bad = (make_profile(p, speed, &q->homing, scale) == (uint16_t)PARAM_COUNT) ? (uint16_t)PARAM_COUNT
                                                                                   : (uint16_t)PARAM_homing_speed_rad_s;
    }
    if (bad != (uint16_t)PARAM_COUNT) {
        return bad;
    }
    if (!(p->position_min_turn < p->position_max_turn)) {
        return PARAM_position_min_turn;
    }
    q->learns = (q->method == DRIVE_POSITION_RDC) && (p->rdc_learn_gain > 0.0f);
    q->velocity_pi = drive_pi(drive_number(p->position_kv_a_per_rad_s * per_speed),
                              drive_number(p->position_kv_a_per_rad_s * per_speed * ts_s / p->position_ti_s),
                              drive_torque_limit_a(p) / scale->current_a, CTL_PI_HOLD_OUTWARD);
    q->kp = drive_number(p->position_kp_per_s * scale->inv_speed);
    q->speed_per_rad = drive_number(scale->inv_speed / ts_s);
    q->feed_speed = (p->position_velocity_ff != 0U) || (q->method == DRIVE_POSITION_RDC);
    q->cells = p->position_cells;
    q->ilc.gain = (p->observer_hold != 0U) ? (num_t)0 : drive_number(p->ilc_gain);
    q->ilc.lead = p->ilc_lead;
    q->ilc.limit = NUM_C(4.0f);
#ifndef EVENSPIN_FIXED
    q->ilc.limit = p->over_speed_rad_s;
#endif
    q->learn.gain = (p->observer_hold != 0U) ? (num_t)0 : drive_number(p->rdc_learn_gain);
    q->learn.lead = LEARN_LEAD;
    q->learn.limit = drive_number(p->iq_limit_a * scale->inv_current);
    q->src.lambda = (angle_t)drive_turns_q32(p->src_period_turn);
    q->src.limit = q->ilc.limit;
    q->src.hold = p->observer_hold != 0U;
    uint16_t unused = PARAM_COUNT; /* a method that is not asked for may be beyond the numeric */
    q->src.omega_half_ts = drive_fitted(p->src_cutoff_per_rad * scale->speed_rad_s * ts_s * 0.5f, PARAM_src_cutoff_per_rad,
                                        (q->method == DRIVE_POSITION_SRC) ? &bad : &unused);
    make_rdc(p, scale, &q->rdc, ((q->method == DRIVE_POSITION_RDC) || (p->speed_model_ff != 0U)) ? &bad : &unused);
    q->torque_delay = p->torque_delay_samples;
    q->error_max = drive_number(p->following_error_rad);
    q->error_samples = p->following_error_samples;
    q->min = drive_turns_q32(p->position_min_turn);
    q->max = drive_turns_q32(p->position_max_turn);
    return bad;
}

uint16_t drive_judge_position(const drive_position_setup_t *q)
{
    ctl_pi_t  pi;
    ctl_rdc_t rdc;
    if (ctl_pi_init(&pi, &q->velocity_pi).status != CTL_OK) {
        return PARAM_position_kv_a_per_rad_s;
    }
    const ctl_diag_t d = ctl_rdc_init(&rdc, &q->rdc);
    return (d.status == CTL_OK) ? (uint16_t)PARAM_COUNT : rdc_culprit(d.field);
}

/* The room that the torque observer leaves is that of the position loop's angle memories. */
static uint16_t taken(const drive_observer_setup_t *s)
{
    return (s->used && (s->observer.kind != CTL_OBSERVER_DOB)) ? s->capacity : 0U;
}

void drive_build_position_memory(drive_position_t *o, const drive_setup_t *s, num_t *memory, uint16_t room)
{
    const drive_position_setup_t *const q = &s->position;
    const uint16_t                      from = taken(&s->observer);
    if (((uint32_t)from + (2U * (uint32_t)q->cells)) > room) {
        return; /* methods that need it are refused then: combinations.def */
    }
    (void)ctl_ilc_init(&o->ilc, &q->ilc, &memory[from], q->cells);
    (void)ctl_ilc_init(&o->learn, &q->learn, &memory[from + q->cells], q->cells);
    if (q->method == DRIVE_POSITION_SRC) {
        (void)ctl_src_init(&o->src, &q->src, &memory[from], q->cells);
    }
}

void drive_build_position(drive_position_t *o, const drive_position_setup_t *q)
{
    ctl_profile_reset(&o->profile, 0);
    (void)ctl_pi_init(&o->pi, &q->velocity_pi);
    o->rdc.rejected = 0U;
    ctl_rdc_reset(&o->rdc);
}

bool drive_position_differs(const drive_setup_t *before, const drive_setup_t *s)
{
    return (before->position.method != s->position.method) || (before->position.cells != s->position.cells) ||
           (taken(&before->observer) != taken(&s->observer));
}

void drive_rest_position(drive_position_t *o)
{
    o->active = false;
    o->homing = false;
}
