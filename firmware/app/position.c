/* The position loop, at the rate of the speed loop: motion profile, P-PI cascade, and what its method adds. */
#include "firmware/app/internal.h"

#define LEARN_LEAD 3U /* samples from a torque command to the velocity it changes */

/* ---- configuration, main loop ----------------------------------------------------------------------------------------- */

/* Steps of 2^-32 turns that stay exact: through 16 whole bits of float at a time. */
static int64_t turns_q32(float turns)
{
    const float   cut = (turns < 2.0e6f) ? ((turns > -2.0e6f) ? turns : -2.0e6f) : 2.0e6f;
    const float   scaled = cut * 1024.0f;
    const int32_t high = (int32_t)scaled;
    return ((int64_t)high * INT64_C(0x400000)) + (int64_t)((scaled - (float)high) * 4194304.0f);
}

static uint16_t make_profile(const drive_params_t *p, float speed_rad_s, ctl_profile_params_t *out, const drive_setup_t *s)
{
    const float ts_s = (float)p->speed_divider / (float)DRIVE_PWM_HZ;
    out->speed = turns_q32(speed_rad_s / DRIVE_TWO_PI * ts_s);
    out->acceleration = turns_q32(p->profile_accel_rad_s2 / DRIVE_TWO_PI * ts_s * ts_s);
    if ((p->profile_accel_rad_s2 > 0.0f) && (out->acceleration == 0)) {
        out->acceleration = 1; /* slower than one step: the slowest there is */
    }
    out->smooth = p->profile_smooth_samples;
    out->speed_scale = num_from_float(DRIVE_TWO_PI / 65536.0f / ts_s * s->scale.inv_speed);
    out->accel_scale = num_from_float(DRIVE_TWO_PI / 1048576.0f / (ts_s * ts_s) * s->scale.inv_speed);
    ctl_profile_t    trial;
    const ctl_diag_t d = ctl_profile_init(&trial, out);
    if (d.status == CTL_OK) {
        return PARAM_COUNT;
    }
    return (d.field == (uint16_t)CTL_PROFILE_SPEED)
               ? PARAM_profile_speed_rad_s
               : ((d.field == (uint16_t)CTL_PROFILE_SMOOTH) ? PARAM_profile_smooth_samples : PARAM_profile_accel_rad_s2);
}

typedef struct {
    float cycles, amplitude_nm, phase_rad;
} line_t;

static void make_rdc(const drive_params_t *p, const drive_setup_t *s, ctl_rdc_params_t *out)
{
    const float  ts_s = (float)p->speed_divider / (float)DRIVE_PWM_HZ;
    const float  per_nm = s->scale.inv_current / (1.5f * (float)p->pole_pairs * p->motor_psi_wb);
    const line_t line[CTL_HARMONICS_MAX] = {
        {p->rdc_line1_cycles, p->rdc_line1_nm, p->rdc_line1_rad}, {p->rdc_line2_cycles, p->rdc_line2_nm, p->rdc_line2_rad},
        {p->rdc_line3_cycles, p->rdc_line3_nm, p->rdc_line3_rad}, {p->rdc_line4_cycles, p->rdc_line4_nm, p->rdc_line4_rad},
        {p->rdc_line5_cycles, p->rdc_line5_nm, p->rdc_line5_rad}, {p->rdc_line6_cycles, p->rdc_line6_nm, p->rdc_line6_rad}};

    out->inertia = num_from_float(p->rdc_inertia_kgm2 * s->scale.speed_rad_s * per_nm);
    out->friction.viscous = num_from_float(p->rdc_viscous_nms * s->scale.speed_rad_s * per_nm);
    out->friction.coulomb = num_from_float(p->rdc_coulomb_nm * per_nm);
    out->friction.stat = num_from_float(p->rdc_static_nm * per_nm);
    out->friction.stribeck = num_from_float(p->rdc_stribeck_rad_s * s->scale.inv_speed);
    out->friction.shape = num_from_float(p->rdc_shape);
    out->harmonics.lines = 0U;
    for (uint16_t i = 0U; i < CTL_HARMONICS_MAX; i++) {
        if (line[i].amplitude_nm > 0.0f) {
            ctl_line_t *const l = &out->harmonics.line[out->harmonics.lines];
            l->cycles_q20 = ctl_cycles_q20(line[i].cycles);
            l->amplitude = num_from_float(line[i].amplitude_nm * per_nm);
            l->phase = angle_from_rad(num_from_float(line[i].phase_rad));
            out->harmonics.lines++;
        }
    }
    const float per_inertia = (p->rdc_inertia_kgm2 > 0.0f) ? (1.0f / p->rdc_inertia_kgm2) : 0.0f;
    out->p_row[0] = num_from_float(p->rdc_p31 * per_inertia);
    out->p_row[1] = num_from_float(p->rdc_p32 * per_inertia);
    out->p_row[2] = num_from_float(p->rdc_p33 * per_inertia * s->scale.speed_rad_s);
    out->rho = num_from_float(p->rdc_rho_nm * per_nm);
    out->sigma = num_from_float(p->rdc_sigma);
    out->sample_s = num_from_float(ts_s);
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

uint16_t drive_make_position(const drive_params_t *p, drive_setup_t *s)
{
    const float                   ts_s = (float)p->speed_divider / (float)DRIVE_PWM_HZ;
    const float                   per_speed = s->scale.speed_rad_s * s->scale.inv_current;
    drive_position_setup_t *const q = &s->position;

    q->method = (drive_position_method_t)p->position_method;
    uint16_t bad = make_profile(p, p->profile_speed_rad_s, &q->profile, s);
    if (bad == (uint16_t)PARAM_COUNT) {
        const float speed = (p->homing_speed_rad_s < 0.0f) ? -p->homing_speed_rad_s : p->homing_speed_rad_s;
        bad = (make_profile(p, speed, &q->homing, s) == (uint16_t)PARAM_COUNT) ? (uint16_t)PARAM_COUNT
                                                                               : (uint16_t)PARAM_homing_speed_rad_s;
    }
    if (bad != (uint16_t)PARAM_COUNT) {
        return bad;
    }
    if (!(p->position_min_turn < p->position_max_turn)) {
        return PARAM_position_min_turn;
    }
    q->learns = (q->method == DRIVE_POSITION_RDC) && (p->rdc_learn_gain > 0.0f);
    if (s->observer_used && (q->learns || (q->method == DRIVE_POSITION_SILC) || (q->method == DRIVE_POSITION_SRC))) {
        return PARAM_position_method; /* the torque observer has the memory */
    }
    q->velocity_pi = s->speed_pi; /* limits and anti-windup are those of the speed loop */
    q->velocity_pi.kp = num_from_float(p->position_kv_a_per_rad_s * per_speed);
    q->velocity_pi.ki_ts = num_from_float(p->position_kv_a_per_rad_s * per_speed * ts_s / p->position_ti_s);
    q->kp = num_from_float(p->position_kp_per_s * s->scale.inv_speed);
    q->speed_per_rad = num_from_float(s->scale.inv_speed / ts_s);
    q->feed_speed = (p->position_velocity_ff != 0U) || (q->method == DRIVE_POSITION_RDC);
    q->cells = p->position_cells;
    q->ilc.gain = num_from_float(p->ilc_gain);
    q->ilc.lead = p->ilc_lead;
    q->ilc.limit = NUM_C(4.0f);
#ifndef EVENSPIN_FIXED
    q->ilc.limit = p->over_speed_rad_s;
#endif
    q->learn.gain = num_from_float(p->rdc_learn_gain);
    q->learn.lead = LEARN_LEAD;
    q->learn.limit = num_from_float(p->iq_limit_a * s->scale.inv_current);
    q->src.omega_half_ts = num_from_float(p->src_cutoff_per_rad * s->scale.speed_rad_s * ts_s * 0.5f);
    q->src.lambda = (angle_t)turns_q32(p->src_period_turn);
    q->src.limit = q->ilc.limit;
    make_rdc(p, s, &q->rdc);
    q->torque_delay = p->torque_delay_samples;
    q->error_max = num_from_float(p->following_error_rad);
    q->error_samples = p->following_error_samples;
    q->min = turns_q32(p->position_min_turn);
    q->max = turns_q32(p->position_max_turn);

    ctl_pi_t  pi;
    ctl_rdc_t rdc;
    if (ctl_pi_init(&pi, &q->velocity_pi).status != CTL_OK) {
        return PARAM_position_kv_a_per_rad_s;
    }
    const ctl_diag_t d = ctl_rdc_init(&rdc, &q->rdc);
    return (d.status == CTL_OK) ? (uint16_t)PARAM_COUNT : rdc_culprit(d.field);
}

/* The angle memories of the position loop use the room of the torque observer's; the two are never active together. */
void drive_build_position_memory(drive_t *d, const drive_setup_t *s)
{
    drive_position_t *const             o = &d->position;
    const drive_position_setup_t *const q = &s->position;
    if (!s->observer_used) {
        (void)ctl_ilc_init(&o->ilc, &q->ilc, d->observer_memory, q->cells);
        (void)ctl_ilc_init(&o->learn, &q->learn, &d->observer_memory[DRIVE_OBSERVER_CAPACITY / 2U], q->cells);
        if (q->method == DRIVE_POSITION_SRC) {
            (void)ctl_src_init(&o->src, &q->src, d->observer_memory, q->cells);
        }
    }
}

void drive_build_position(drive_t *d, const drive_setup_t *s)
{
    drive_position_t *const             o = &d->position;
    const drive_position_setup_t *const q = &s->position;
    (void)ctl_profile_init(&o->profile, &q->profile);
    (void)ctl_pi_init(&o->pi, &q->velocity_pi);
    (void)ctl_rdc_init(&o->rdc, &q->rdc);
    drive_build_position_memory(d, s);
}

bool drive_position_differs(const drive_setup_t *before, const drive_setup_t *s)
{
    return !s->observer_used && ((before->position.method != s->position.method) ||
                                 (before->position.cells != s->position.cells) || before->observer_used);
}

void drive_rest_position(drive_t *d)
{
    d->position.active = false;
    d->position.homing = false;
}

/* ---- one sample, speed interrupt ------------------------------------------------------------------------------------------ */

static void begin(drive_t *d)
{
    drive_position_t *const o = &d->position;
    ctl_profile_tune_raw(&o->profile, o->homing ? &d->setup->position.homing : &d->setup->position.profile);
    ctl_profile_reset(&o->profile, o->now);
    ctl_pi_reset(&o->pi, (num_t)0);
    ctl_rdc_reset(&o->rdc);
    ctl_ilc_reset(&o->ilc, true);
    ctl_ilc_reset(&o->learn, true);
    o->src.state.primed = false;
    o->error_count = 0U;
    for (uint16_t i = 0U; i < 8U; i++) {
        o->delayed[i] = (num_t)0;
    }
    o->active = true;
}

static void show(drive_shown_t *s, ctl_position_t position)
{
    const uint16_t idle = (uint16_t)(s->at ^ 1U);
    s->value[idle] = position;
    s->at = idle;
}

void drive_position_measure(drive_t *d)
{
    drive_position_t *const o = &d->position;
    const angle_t           theta = d->tracking.theta_m;
    if (!o->primed) {
        o->raw = (ctl_position_t)(uint64_t)theta;
        o->now = ctl_position_sub(o->raw, o->zero);
        o->primed = true;
    }
    o->raw = ctl_position_follow(o->raw, theta);
    o->before = o->now;
    o->now = ctl_position_sub(o->raw, o->zero);
    o->speed = num_mul(ctl_position_difference(o->now, o->before), d->setup->position.speed_per_rad);
    show(&o->now_shown, o->now);
}

/* Search the index: where to go meanwhile. When it has been passed, its position becomes zero. */
static ctl_position_t search(drive_t *d, ctl_position_t target)
{
    drive_position_t *const o = &d->position;
    const bool              forward = d->params->homing_speed_rad_s >= 0.0f;
    if (d->home_wanted) {
        d->home_wanted = false;
        o->homing = true;
        o->homed = false;
        o->home_limit = o->now + (forward ? (CTL_ONE_TURN + (CTL_ONE_TURN / 4)) : -(CTL_ONE_TURN + (CTL_ONE_TURN / 4)));
        ctl_profile_tune_raw(&o->profile, &d->setup->position.homing);
    }
    if (!o->homing) {
        return target;
    }
    if (d->speed.edge.index_seen) {
        const angle_t        at = angle_from_rad(num_from_float(d->speed.edge.index_rad));
        const ctl_position_t index = ctl_position_follow(o->raw, d->setup->encoder_reversed ? (0U - at) : at);
        const ctl_position_t shift = ctl_position_sub(index, o->zero);
        o->zero = index;
        o->now = ctl_position_sub(o->now, shift);
        show(&o->now_shown, o->now);
        o->before = ctl_position_sub(o->before, shift);
        o->homed = true;
        o->homing = false;
        ctl_profile_shift(&o->profile, shift); /* go on from here, without a step in the command */
        ctl_profile_tune_raw(&o->profile, &d->setup->position.profile);
        return target;
    }
    if (forward ? (o->now >= o->home_limit) : (o->now <= o->home_limit)) {
        drive_trip(d, FAULT_homing);
    }
    return o->home_limit + (forward ? CTL_ONE_TURN : -CTL_ONE_TURN);
}

static void guard(drive_t *d)
{
    drive_position_t *const             o = &d->position;
    const drive_position_setup_t *const q = &d->setup->position;
    const ctl_position_t                margin = CTL_ONE_TURN / 100;

    if (num_abs(o->error) <= q->error_max) {
        o->error_count = 0U;
    } else if (o->error_count < q->error_samples) {
        o->error_count++;
    } else {
        drive_trip(d, FAULT_following_error);
    }
    if (!o->homing && ((o->now > (q->max + margin)) || (o->now < (q->min - margin)))) {
        drive_trip(d, FAULT_position_limit);
    }
}

static num_t hold_back(drive_position_t *o, num_t torque, uint16_t samples)
{
    o->delay_head = (uint16_t)((o->delay_head + 1U) & 7U);
    o->delayed[o->delay_head] = torque;
    return o->delayed[(o->delay_head - samples) & 7U];
}

/* Cut to what turns_q32 takes, twice the widest soft limits. */
static ctl_position_t target_of(const drive_command_t *c)
{
    const int32_t most = 2000000;
    const int32_t turns = (c->target_turns > most) ? most : ((c->target_turns < -most) ? -most : c->target_turns);
    return ((ctl_position_t)turns * CTL_ONE_TURN) + turns_q32(c->target_rad * (1.0f / DRIVE_TWO_PI));
}

void drive_position_step(drive_t *d, const drive_command_t *command)
{
    drive_position_t *const             o = &d->position;
    const drive_position_setup_t *const q = &d->setup->position;

    if (!o->active) {
        begin(d);
    }
    const ctl_position_t target = target_of(command);
    ctl_position_t       to = (target > q->max) ? q->max : ((target < q->min) ? q->min : target);
    to = search(d, to);
    o->setpoint = ctl_profile_step(&o->profile, to);
    show(&o->ref_shown, o->setpoint.position);
    o->error = ctl_position_difference(o->setpoint.position, o->now);
    guard(d);

    const num_t   speed_error = num_sub(o->setpoint.speed, o->speed);
    const angle_t theta = (angle_t)(uint64_t)o->raw;
    num_t         feed = q->feed_speed ? o->setpoint.speed : (num_t)0;
    if (q->method == DRIVE_POSITION_SILC) {
        feed = num_add(feed, ctl_ilc_step(&o->ilc, theta, speed_error));
    } else if (q->method == DRIVE_POSITION_SRC) {
        /* plugged into the velocity loop: its error before the correction */
        feed = num_add(feed, ctl_src_step(&o->src, theta, o->speed, num_sub(num_mac(feed, q->kp, o->error), o->speed)));
    } else {
        /* ppi, rdc: no learning of the speed */
    }
    const num_t wanted = num_mac(feed, q->kp, o->error);
    const num_t feedback = ctl_pi_output(&o->pi, num_sub(wanted, o->speed));
    num_t       torque = feedback;
    if (q->method == DRIVE_POSITION_RDC) {
        torque = num_add(torque, ctl_rdc_step_raw(&o->rdc, &o->setpoint, num_neg(o->error), num_neg(speed_error)));
        if (q->learns) {
            torque = num_add(torque, ctl_ilc_step(&o->learn, theta, num_add(feedback, o->rdc.state.robust)));
        }
    }
    const num_t room = drive_active_order(d)->iq_max;
    const num_t limited = num_clamp(torque, num_neg(room), room);
    ctl_pi_commit(&o->pi, num_add(feedback, num_sub(limited, torque)));
    ctl_pi_reset(&d->speed.pi, limited); /* speed mode goes on with this torque */
    d->speed.iq_ref = hold_back(o, limited, q->torque_delay);
}

static float in_rad(ctl_position_t position)
{
    /* turns and part separately: a float has 24 bits */
    const int32_t turns = (int32_t)(position >> 32);
    const float   part = (float)(uint32_t)(uint64_t)position * 1.46291807926715968e-9f;
    return ((float)turns * DRIVE_TWO_PI) + part;
}

/* The speed interrupt writes the other one: this is whole unless it comes twice in between. */
static ctl_position_t whole(const drive_shown_t *s) { return s->value[s->at & 1U]; }

float drive_position_rad(const drive_t *d) { return in_rad(whole(&d->position.now_shown)); }
float drive_position_ref_rad(const drive_t *d) { return in_rad(whole(&d->position.ref_shown)); }
