#include "sim_host/plant/plant.h"

#include <math.h>
#include <stddef.h>

#include "sim_host/plant/lag.h"

#define PI 3.14159265358979323846
#define SQRT3 1.73205080756887729353

/* Keeps what only some effects need out of the code that every step runs. */
#define APART __attribute__((noinline))
#define WITHIN inline __attribute__((always_inline)) /* and this is that code */

#define TURNS_BEFORE_ANEW 256
#define BRIDGE_STEPS 2 /* per period while an effect makes the voltage follow the currents, which cross zero between steps */
#define PIECES_MAX 8 /* zero crossings of speed and currents within one step, and some to spare */

/* floor for |x| < 2^62, without a call */
static inline int64_t whole_below(double x)
{
    const int64_t cut = (int64_t)x;
    return ((double)cut > x) ? cut - 1 : cut;
}

/* ---- start --------------------------------------------------------------------------------------------------------- */

static double measured_angle(const sim_plant_t *s)
{
    double angle = s->x.theta_m_rad;
    for (int i = 0; i < s->angle_count; i++) {
        angle = s->angle[i]->effect->angle_sensor(s->angle[i]->p, &s->model, angle);
    }
    return angle - s->origin_rad;
}

static void turn_frame(sim_plant_t *s)
{
    const double theta_e = s->model.pole_pairs * s->x.theta_m_rad;
    s->cosine_e = cos(theta_e);
    s->sine_e = sin(theta_e);
    s->turns_left = TURNS_BEFORE_ANEW;
}

/* Turn by a small angle; the series is exact to 2e-12 at 0.3 rad. */
static WITHIN void turn_frame_by(sim_plant_t *s, double angle)
{
    if ((s->turns_left <= 0) || (fabs(angle) > 0.3)) {
        turn_frame(s);
        return;
    }
    const double a2 = angle * angle;
    const double c = 1.0 - a2 * (1.0 / 2 - a2 * (1.0 / 24 - a2 * (1.0 / 720 - a2 * (1.0 / 40320))));
    const double n = angle * (1.0 - a2 * (1.0 / 6 - a2 * (1.0 / 120 - a2 * (1.0 / 5040 - a2 * (1.0 / 362880)))));
    const double cosine = s->cosine_e * c - s->sine_e * n;
    s->sine_e = s->sine_e * c + s->cosine_e * n;
    s->cosine_e = cosine;
    s->turns_left--;
}

static void collect_effects(sim_plant_t *s, const double (*values)[SIM_EFFECT_PARAMS])
{
    for (int e = 0; (e < sim_effect_total) && (s->acting_count < SIM_EFFECTS_MAX); e++) {
        const sim_effect_t *const effect = sim_effects[e];
        bool                      on = false;
        for (int k = 0; k < effect->param_count; k++) {
            on = on || (values[e][k] != effect->param[k].off);
        }
        if (!on) {
            continue;
        }
        sim_acting_t *const a = &s->acting[s->acting_count++];
        a->effect = effect;
        for (int k = 0; k < SIM_EFFECT_PARAMS; k++) {
            a->p[k] = values[e][k];
        }
        if (effect->model != NULL) {
            effect->model(a->p, &s->model);
        }
        if (effect->parts != NULL) {
            effect->parts(a->p, &s->parts);
        }
        if (effect->linkage_wb != NULL) {
            s->saturation = a;
        }
        if (effect->torque_nm != NULL) {
            s->torque[s->torque_count++] = a;
        }
        if (effect->friction_nm != NULL) {
            s->friction[s->friction_count++] = a;
        }
        if (effect->flux != NULL) {
            s->flux[s->flux_count++] = a;
        }
        if (effect->phase_voltage != NULL) {
            s->voltage[s->voltage_count++] = a;
        }
        if (effect->current_sensor != NULL) {
            s->current[s->current_count++] = a;
        }
        if (effect->angle_sensor != NULL) {
            s->angle[s->angle_count++] = a;
        }
    }
}

/* One step has a relative error of (h / tau)^5 / 120 in a transient, and angle^6 / 720 in the turned voltage: 0.4 and
 * 0.3 rad keep both near 1e-6 at the speed where the back-EMF fills the dc link, and far below it at ordinary ones.
 * A swinging shaft loses angle^6 / 144 of its amplitude a step: 0.3 rad add 2e-5 to its damping ratio. */
static int needed_substeps(const sim_plant_t *s)
{
    const sim_model_t *const m = &s->model;
    const double l_min = (m->ld_h < m->lq_h) ? m->ld_h : m->lq_h;
    const double decay = m->resistance_ohm / l_min * s->period_s / 0.4;
    const double flux = (m->psi_wb > 1e-9) ? m->psi_wb : 1e-9;
    const double turn = m->dc_link_v / SQRT3 / flux * s->period_s / 0.3;
    const double swing = s->coupling.on ? s->coupling.resonance_rad_s * s->period_s / 0.3 : 0.0;
    const double bridge = (s->voltage_count > 0) ? BRIDGE_STEPS : 1.0;
    double       need = (decay > turn) ? decay : turn;
    need = (swing > need) ? swing : need;
    need = ceil((bridge > need) ? bridge : need);
    return (need < 1.0) ? 1 : ((need > 100.0) ? 100 : (int)need);
}

const char *sim_plant_start(sim_plant_t *s, const sim_model_t *m, const double (*values)[SIM_EFFECT_PARAMS], double edges_per_rev,
                            uint64_t seed)
{
    static const sim_plant_t nothing;
    *s = nothing;
    s->model = *m;
    for (int i = 0; i < sim_model_count(); i++) {
        if (!sim_field_accepts(sim_model_info(i), *sim_model_at(&s->model, i))) {
            return sim_model_info(i)->name;
        }
    }
    collect_effects(s, values);
    s->period_s = 1.0 / s->model.pwm_hz;
    if (s->model.rotor_locked == 0.0) { /* what hangs on a locked rotor does not show */
        sim_coupling_start(&s->coupling, s->model.inertia_kgm2, s->parts.load_ratio, s->parts.resonance_hz,
                           s->parts.damping_ratio, s->parts.has_play, s->parts.play_rad);
    }
    sim_delay_start(&s->delay, s->parts.delay_periods);
    s->substeps = (s->model.substeps > 0.0) ? (int)s->model.substeps : needed_substeps(s);
    s->inv_ld = 1.0 / s->model.ld_h;
    s->inv_lq = 1.0 / s->model.lq_h;
    s->inv_inertia = s->coupling.on ? s->coupling.inv_rotor : 1.0 / s->model.inertia_kgm2;
    s->torque_per_amp = 1.5 * s->model.pole_pairs;
    const bool hooks = (s->flux_count > 0) || (s->torque_count > 0) || (s->friction_count > 0);
    s->kind = ((s->saturation != NULL) || s->coupling.on) ? SIM_WITH_PARTS : (hooks ? SIM_WITH_HOOKS : SIM_PLAIN);
    s->x.theta_m_rad = s->model.initial_angle_rad;
    turn_frame(s);
    s->x.speed_rad_s = (s->model.rotor_locked != 0.0) ? 0.0 : s->model.initial_speed_rad_s;
    s->load.speed_rad_s = s->x.speed_rad_s;
    s->outside.dc_link_v = s->model.dc_link_v;
    s->vdc_filtered_v = s->model.dc_link_v;
    s->vdc_gain = 1.0 - exp(-2.0 * PI * s->model.vdc_filter_hz * s->period_s);
    s->index_turn = whole_below(measured_angle(s) * (0.5 / PI));
    s->index_seen = s->model.encoder_absolute != 0.0;
    s->origin_rad = s->index_seen ? 0.0 : measured_angle(s);
    s->edge_pitch_rad = 2.0 * PI / edges_per_rev;
    s->edge_cell = whole_below(measured_angle(s) / s->edge_pitch_rad);
    s->edge_count = s->edge_cell;
    sim_random_seed(&s->noise, seed);
    return NULL;
}

/* ---- electrical machine and shaft ------------------------------------------------------------------------------------- */

typedef struct {
    double did, diq, dw, dtheta;
} rate_t;

/** Flux linkages of the axes from the currents, and the inverse of their slopes. */
typedef struct {
    double d_wb, q_wb, inv_d, inv_q;
} linkage_t;

/** One integration step: voltage in the rotor frame at its start, direction of friction, whether the shaft is free. */
typedef struct {
    double vd_v, vq_v, theta0_rad;
    double friction_sign; /**< +1, -1, 0: no friction. */
    double drag_nm;       /**< Load and, where it does not depend on speed, friction with its sign. */
    bool   stuck;         /**< The shaft stands: the rotor, where a coupling is on. */
    double brake_sign;    /**< The same for the brake of a load behind a coupling. */
    bool   load_stuck;
    int    side;          /**< Flank of the coupling in contact, 0: none. */
} step_t;

static WITHIN double friction_nm(const sim_plant_t *s, double speed_abs, sim_machine_kind_t kind)
{
    double sum = ((kind == SIM_WITH_PARTS) && s->coupling.on) ? 0.0 : s->outside.load_brake_nm;
    for (int i = 0; i < s->friction_count; i++) {
        sum += s->friction[i]->effect->friction_nm(s->friction[i]->p, speed_abs);
    }
    return sum;
}

static WITHIN sim_flux_t flux_harmonics(const sim_plant_t *s, const sim_state_t *x)
{
    sim_flux_t h = {0.0, 0.0};
    for (int i = 0; i < s->flux_count; i++) {
        s->flux[i]->effect->flux(s->flux[i]->p, &s->model, s->model.pole_pairs * x->theta_m_rad, &h);
    }
    return h;
}

APART static linkage_t linkage(const sim_plant_t *s, const sim_state_t *x)
{
    const sim_acting_t *const a = s->saturation;
    linkage_t                 f;
    f.d_wb = a->effect->linkage_wb(a->p, s->model.ld_h, x->id_a, x->iq_a, &f.inv_d);
    f.q_wb = a->effect->linkage_wb(a->p, s->model.lq_h, x->iq_a, x->id_a, &f.inv_q);
    f.inv_d = 1.0 / f.inv_d;
    f.inv_q = 1.0 / f.inv_q;
    return f;
}

static WITHIN double motor_torque(const sim_plant_t *s, const sim_state_t *x, const sim_flux_t *h)
{
    const sim_model_t *const m = &s->model;
    return s->torque_per_amp * ((m->psi_wb + h->q_wb) * x->iq_a + h->d_wb * x->id_a + (m->ld_h - m->lq_h) * x->id_a * x->iq_a);
}

static double through_coupling(const sim_plant_t *s, const sim_state_t *x, const sim_load_t *load, int side)
{
    return sim_coupling_torque(&s->coupling, side, load->twist_rad, x->speed_rad_s - load->speed_rad_s);
}

APART static double saturated_torque(const sim_plant_t *s, const sim_state_t *x, const sim_flux_t *h, const linkage_t *f)
{
    return s->torque_per_amp * ((s->model.psi_wb + h->q_wb + f->d_wb) * x->iq_a + (h->d_wb - f->q_wb) * x->id_a);
}

/** Torque of the motor, saturated or not. */
APART static double any_motor_torque(const sim_plant_t *s, const sim_state_t *x)
{
    const sim_flux_t h = flux_harmonics(s, x);
    if (s->saturation == NULL) {
        return motor_torque(s, x, &h);
    }
    const linkage_t f = linkage(s, x);
    return saturated_torque(s, x, &h, &f);
}

/** Everything on the shaft but friction; behind a coupling: on the rotor. */
static WITHIN double shaft_torque(const sim_plant_t *s, const sim_state_t *x, double motor_nm, double coupling_nm, sim_machine_kind_t kind)
{
    const sim_shaft_t shaft = {x->theta_m_rad, x->speed_rad_s};
    const bool        coupled = (kind == SIM_WITH_PARTS) && s->coupling.on;
    const double      load = coupled ? coupling_nm : s->outside.load_torque_nm;
    double            sum = motor_nm - s->model.viscous_nms * x->speed_rad_s - load;
    for (int i = 0; i < s->torque_count; i++) {
        if (!coupled || !s->torque[i]->effect->at_load) {
            sum += s->torque[i]->effect->torque_nm(s->torque[i]->p, &shaft);
        }
    }
    return sum;
}

/** Everything on the load behind a coupling but its brake. */
static double load_torque(const sim_plant_t *s, const sim_state_t *x, const sim_load_t *load, double coupling_nm)
{
    const sim_shaft_t shaft = {x->theta_m_rad - load->twist_rad, load->speed_rad_s};
    double            sum = coupling_nm - s->outside.load_torque_nm;
    for (int i = 0; i < s->torque_count; i++) {
        if (s->torque[i]->effect->at_load) {
            sum += s->torque[i]->effect->torque_nm(s->torque[i]->p, &shaft);
        }
    }
    return sum;
}

static WITHIN rate_t rates(const sim_plant_t *s, const step_t *step, const sim_state_t *x, double coupling_nm,
                           sim_machine_kind_t kind)
{
    const sim_model_t *const m = &s->model;
    const double             moved = m->pole_pairs * (x->theta_m_rad - step->theta0_rad);
    const double             m2 = moved * moved;
    const double             c = 1.0 - m2 * (0.5 - m2 * (1.0 / 24.0));
    const double             n = moved * (1.0 - m2 * (1.0 / 6.0 - m2 * (1.0 / 120.0)));
    const double             vd = step->vd_v * c + step->vq_v * n;
    const double             vq = step->vq_v * c - step->vd_v * n;
    const double             we = m->pole_pairs * x->speed_rad_s;
    const sim_flux_t         h = (kind == SIM_PLAIN) ? (sim_flux_t){0.0, 0.0} : flux_harmonics(s, x);

    rate_t r;
    double motor_nm;
    if ((kind != SIM_WITH_PARTS) || (s->saturation == NULL)) {
        r.did = (vd - m->resistance_ohm * x->id_a + we * (m->lq_h * x->iq_a - h.d_wb)) * s->inv_ld;
        r.diq = (vq - m->resistance_ohm * x->iq_a - we * (m->ld_h * x->id_a + m->psi_wb + h.q_wb)) * s->inv_lq;
        motor_nm = motor_torque(s, x, &h);
    } else {
        const linkage_t f = linkage(s, x);
        r.did = (vd - m->resistance_ohm * x->id_a + we * (f.q_wb - h.d_wb)) * f.inv_d;
        r.diq = (vq - m->resistance_ohm * x->iq_a - we * (f.d_wb + m->psi_wb + h.q_wb)) * f.inv_q;
        motor_nm = saturated_torque(s, x, &h, &f);
    }
    if (step->stuck) {
        r.dw = 0.0;
        r.dtheta = 0.0;
    } else {
        double torque;
        if (kind == SIM_PLAIN) {
            torque = motor_nm - m->viscous_nms * x->speed_rad_s - step->drag_nm;
        } else {
            torque = shaft_torque(s, x, motor_nm, coupling_nm, kind) - step->friction_sign * friction_nm(s, fabs(x->speed_rad_s), kind);
        }
        r.dw = torque * s->inv_inertia;
        r.dtheta = x->speed_rad_s;
    }
    return r;
}

static WITHIN sim_state_t ahead(const sim_state_t *x, const rate_t *r, double h)
{
    const sim_state_t y = {x->id_a + h * r->did, x->iq_a + h * r->diq, x->speed_rad_s + h * r->dw, x->theta_m_rad + h * r->dtheta};
    return y;
}

static WITHIN rate_t mean_rate(const rate_t *k1, const rate_t *k2, const rate_t *k3, const rate_t *k4)
{
    const double sixth = 1.0 / 6.0;
    const rate_t mean = {(k1->did + 2.0 * (k2->did + k3->did) + k4->did) * sixth, (k1->diq + 2.0 * (k2->diq + k3->diq) + k4->diq) * sixth,
                         (k1->dw + 2.0 * (k2->dw + k3->dw) + k4->dw) * sixth, (k1->dtheta + 2.0 * (k2->dtheta + k3->dtheta) + k4->dtheta) * sixth};
    return mean;
}

static WITHIN sim_state_t four_stages(const sim_plant_t *s, const step_t *step, double h, sim_machine_kind_t kind)
{
    const sim_state_t *const x = &s->x;
    const rate_t             k1 = rates(s, step, x, 0.0, kind);
    const sim_state_t        x2 = ahead(x, &k1, 0.5 * h);
    const rate_t             k2 = rates(s, step, &x2, 0.0, kind);
    const sim_state_t        x3 = ahead(x, &k2, 0.5 * h);
    const rate_t             k3 = rates(s, step, &x3, 0.0, kind);
    const sim_state_t        x4 = ahead(x, &k3, h);
    const rate_t             k4 = rates(s, step, &x4, 0.0, kind);
    const rate_t             mean = mean_rate(&k1, &k2, &k3, &k4);
    return ahead(x, &mean, h);
}

/* The usual machine gets code without hooks: half the time of the general one. */
static WITHIN sim_state_t runge_kutta(const sim_plant_t *s, const step_t *step, double h)
{
    return (s->kind == SIM_PLAIN) ? four_stages(s, step, h, SIM_PLAIN) : four_stages(s, step, h, SIM_WITH_HOOKS);
}

/* ---- the machine with saturation or a coupling -------------------------------------------------------------------------- */

typedef struct {
    sim_state_t x;
    sim_load_t  load;
} whole_t;

typedef struct {
    rate_t x;
    double dload, dtwist;
} whole_rate_t;

static whole_rate_t whole_rates(const sim_plant_t *s, const step_t *step, const whole_t *y)
{
    whole_rate_t r = {.dload = 0.0};
    if (s->coupling.on) {
        const double coupling_nm = through_coupling(s, &y->x, &y->load, step->side);
        r.x = rates(s, step, &y->x, coupling_nm, SIM_WITH_PARTS);
        r.dtwist = r.x.dtheta - y->load.speed_rad_s;
        if (!step->load_stuck) {
            const double brake_nm = step->brake_sign * s->outside.load_brake_nm;
            r.dload = (load_torque(s, &y->x, &y->load, coupling_nm) - brake_nm) * s->coupling.inv_load;
        }
    } else {
        r.x = rates(s, step, &y->x, 0.0, SIM_WITH_PARTS);
    }
    return r;
}

static whole_t whole_ahead(const whole_t *y, const whole_rate_t *r, double h)
{
    const whole_t z = {ahead(&y->x, &r->x, h), {y->load.speed_rad_s + h * r->dload, y->load.twist_rad + h * r->dtwist}};
    return z;
}

APART static whole_t whole_runge_kutta(const sim_plant_t *s, const step_t *step, double h)
{
    const whole_t      y = {s->x, s->load};
    const whole_rate_t k1 = whole_rates(s, step, &y);
    const whole_t      y2 = whole_ahead(&y, &k1, 0.5 * h);
    const whole_rate_t k2 = whole_rates(s, step, &y2);
    const whole_t      y3 = whole_ahead(&y, &k2, 0.5 * h);
    const whole_rate_t k3 = whole_rates(s, step, &y3);
    const whole_t      y4 = whole_ahead(&y, &k3, h);
    const whole_rate_t k4 = whole_rates(s, step, &y4);
    const whole_rate_t mean = {mean_rate(&k1.x, &k2.x, &k3.x, &k4.x), (k1.dload + 2.0 * (k2.dload + k3.dload) + k4.dload) / 6.0,
                               (k1.dtwist + 2.0 * (k2.dtwist + k3.dtwist) + k4.dtwist) / 6.0};
    return whole_ahead(&y, &mean, h);
}

static double wrapped(double angle)
{
    const double a = angle - 2.0 * PI * (double)whole_below(angle * (0.5 / PI));
    return (a < 0.0) ? 0.0 : a;
}

static void note_index(sim_plant_t *s, double angle)
{
    const int64_t turn = whole_below((angle + s->origin_rad) * (0.5 / PI));
    if (turn != s->index_turn) {
        const int64_t passed = (turn > s->index_turn) ? turn : (turn + 1);
        s->index_turn = turn;
        s->index_seen = true;
        s->index_rad = wrapped((double)passed * 2.0 * PI - s->origin_rad);
    }
}

static void note_edges(sim_plant_t *s, double angle_before, double t0_s, double h)
{
    const double  angle = measured_angle(s);
    const int64_t cell = whole_below(angle / s->edge_pitch_rad);
    if (cell != s->edge_cell) {
        s->edge_count = (cell > s->edge_cell) ? cell : (cell + 1);
        const double way = angle - angle_before;
        const double part = (way != 0.0) ? ((double)s->edge_count * s->edge_pitch_rad - angle_before) / way : 1.0;
        s->edge_time_s = t0_s + h * ((part < 0.0) ? 0.0 : ((part > 1.0) ? 1.0 : part));
        s->edge_cell = cell;
        note_index(s, angle);
    }
}

/* ---- one step, and what ends it early ---------------------------------------------------------------------------------- */

/* A flank is met this part of a step late rather than early, so that the next step begins in the new state. */
#define FLANK_LATE 1e-4

static double direction_of(double speed) { return (speed > 0.0) ? 1.0 : ((speed < 0.0) ? -1.0 : 0.0); }

/** Which way does friction act, and does it hold? */
static WITHIN void judge_friction(const sim_plant_t *s, step_t *step, double coupling_nm, sim_machine_kind_t kind)
{
    if (s->x.speed_rad_s != 0.0) {
        step->friction_sign = (s->x.speed_rad_s > 0.0) ? 1.0 : -1.0;
    } else {
        const double push = shaft_torque(s, &s->x, any_motor_torque(s, &s->x), coupling_nm, kind);
        step->stuck = fabs(push) <= friction_nm(s, 0.0, kind);
        step->friction_sign = (push > 0.0) ? 1.0 : -1.0;
    }
}

static WITHIN void judge_rigid(const sim_plant_t *s, step_t *step, sim_machine_kind_t kind)
{
    if (s->model.rotor_locked != 0.0) {
        step->stuck = true;
    } else if ((s->friction_count > 0) || (s->outside.load_brake_nm > 0.0)) {
        judge_friction(s, step, 0.0, kind);
    }
    step->drag_nm = s->outside.load_torque_nm + step->friction_sign * s->outside.load_brake_nm;
}

/** The same behind a coupling: friction on the rotor, the brake on the load. */
static void judge_coupled(const sim_plant_t *s, step_t *step)
{
    const double brake_nm = s->outside.load_brake_nm;
    step->side = sim_coupling_side(&s->coupling, s->load.twist_rad, s->x.speed_rad_s - s->load.speed_rad_s);
    const double coupling_nm = through_coupling(s, &s->x, &s->load, step->side);
    if (s->friction_count > 0) {
        judge_friction(s, step, coupling_nm, SIM_WITH_PARTS);
    }
    if (brake_nm > 0.0) {
        step->brake_sign = direction_of(s->load.speed_rad_s);
        if (s->load.speed_rad_s == 0.0) {
            const double push = load_torque(s, &s->x, &s->load, coupling_nm);
            step->load_stuck = fabs(push) <= brake_nm;
            step->brake_sign = (push > 0.0) ? 1.0 : -1.0;
        }
    }
}

/** Time within the step at which the contact of the coupling changes between the present and @p y; h when it does not. */
static double flank_time(const sim_plant_t *s, const step_t *step, const whole_t *y, double h)
{
    const sim_coupling_t *const c = &s->coupling;
    const double                rate = s->x.speed_rad_s - s->load.speed_rad_s;
    const double                rate_y = y->x.speed_rad_s - y->load.speed_rad_s;
    double                      first = h;
    for (int side = -1; c->has_play && (side <= 1); side += 2) {
        const double before = sim_coupling_depth(c, side, s->load.twist_rad, rate);
        const double after = sim_coupling_depth(c, side, y->load.twist_rad, rate_y);
        const bool   changes = (step->side == 0) ? (after > 0.0) : ((step->side == side) && (after <= 0.0));
        if (changes && (before != after)) {
            const double at = h * (before / (before - after) + FLANK_LATE);
            first = (at < first) ? at : first;
        }
    }
    return first;
}

/** A step of rotor and load behind a coupling: ends where one of them passes zero against friction or a flank begins or
 *  ends contact. In the @p last piece of a step flanks wait. @return time done. */
static double coupled_step(sim_plant_t *s, step_t *step, double h, bool last)
{
    const double w0 = s->x.speed_rad_s;
    const double v0 = s->load.speed_rad_s;
    whole_t      y = whole_runge_kutta(s, step, h);
    bool         turns = !step->stuck && (y.x.speed_rad_s * step->friction_sign < 0.0);
    bool         load_turns = !step->load_stuck && (y.load.speed_rad_s * step->brake_sign < 0.0);
    if ((turns && (w0 == 0.0)) || (load_turns && (v0 == 0.0))) { /* it would start backwards: friction holds it */
        step->stuck = step->stuck || (turns && (w0 == 0.0));
        step->load_stuck = step->load_stuck || (load_turns && (v0 == 0.0));
        y = whole_runge_kutta(s, step, h);
        turns = !step->stuck && (y.x.speed_rad_s * step->friction_sign < 0.0);
        load_turns = !step->load_stuck && (y.load.speed_rad_s * step->brake_sign < 0.0);
    }
    const double stop = turns ? h * w0 / (w0 - y.x.speed_rad_s) : h;
    const double load_stop = load_turns ? h * v0 / (v0 - y.load.speed_rad_s) : h;
    const double flank = last ? h : flank_time(s, step, &y, h);
    double       done = (stop < load_stop) ? stop : load_stop;
    done = (flank < done) ? flank : done;
    if (done < h) {
        y = whole_runge_kutta(s, step, done);
        y.x.speed_rad_s = (turns && (done == stop)) ? 0.0 : y.x.speed_rad_s;
        y.load.speed_rad_s = (load_turns && (done == load_stop)) ? 0.0 : y.load.speed_rad_s;
    }
    s->x = y.x;
    s->load = y.load;
    return done;
}

static WITHIN sim_state_t one_piece(const sim_plant_t *s, const step_t *step, double h, bool saturates)
{
    return saturates ? whole_runge_kutta(s, step, h).x : runge_kutta(s, step, h);
}

/** The same where all that turns is one piece. @return its end. */
static WITHIN sim_state_t rigid_step(const sim_plant_t *s, step_t *step, double h, double *time_done, bool saturates)
{
    double      done = h;
    sim_state_t y = one_piece(s, step, h, saturates);
    if (!step->stuck && (y.speed_rad_s * step->friction_sign < 0.0)) {
        const double w0 = s->x.speed_rad_s;
        done = h * w0 / (w0 - y.speed_rad_s); /* 0 when it would start backwards: friction holds it */
        if (!(done > 0.0)) {
            step->stuck = true;
            done = h;
        }
        y = one_piece(s, step, done, saturates);
        y.speed_rad_s = 0.0;
    }
    *time_done = done;
    return y;
}

typedef struct {
    double i[2], slope[2];
} still_t;

/** Currents and their slopes in the frame of the stator, alpha and beta. */
APART static still_t stator_view(const sim_plant_t *s, const step_t *step)
{
    const rate_t  r = rates(s, step, &s->x, 0.0, SIM_WITH_PARTS); /* of the currents; no torque needed */
    const double  we = s->model.pole_pairs * s->x.speed_rad_s;
    const double  did = r.did - we * s->x.iq_a; /* turned along with the frame */
    const double  diq = r.diq + we * s->x.id_a;
    const double  c = s->cosine_e;
    const double  n = s->sine_e;
    const still_t v = {{s->x.id_a * c - s->x.iq_a * n, s->x.id_a * n + s->x.iq_a * c}, {did * c - diq * n, did * n + diq * c}};
    return v;
}

APART static void filter_currents(sim_plant_t *s, const still_t *before, const still_t *after, double h)
{
    sim_lag_t lag;
    sim_lag_prepare(&lag, s->parts.current_lag_s, h);
    for (int k = 0; k < 2; k++) {
        const sim_lag_input_t in = {before->i[k], after->i[k], before->slope[k], after->slope[k]};
        s->lagging_a[k] = sim_lag_step(&lag, &in, s->lagging_a[k]);
    }
}

static WITHIN step_t begin(const sim_plant_t *s, const double v_ab[2])
{
    const double c = s->cosine_e;
    const double n = s->sine_e;
    const step_t step = {.vd_v = v_ab[0] * c + v_ab[1] * n, .vq_v = v_ab[1] * c - v_ab[0] * n, .theta0_rad = s->x.theta_m_rad};
    return step;
}

APART static double move_with_parts(sim_plant_t *s, const double v_ab[2], double h, bool last)
{
    const bool  filters = s->parts.current_lag_s > 0.0;
    step_t      step = begin(s, v_ab);
    still_t     before = {{0.0, 0.0}, {0.0, 0.0}};
    double      done;
    if (s->coupling.on) {
        judge_coupled(s, &step);
    } else {
        judge_rigid(s, &step, SIM_WITH_PARTS);
    }
    if (filters) {
        before = stator_view(s, &step);
    }
    if (s->coupling.on) {
        done = coupled_step(s, &step, h, last);
    } else {
        s->x = rigid_step(s, &step, h, &done, s->saturation != NULL);
    }
    turn_frame_by(s, s->model.pole_pairs * (s->x.theta_m_rad - step.theta0_rad));
    if (filters && (done > 0.0)) {
        const still_t after = stator_view(s, &step);
        filter_currents(s, &before, &after, done);
    }
    return done;
}

/** Advance by at most h; ends early where a speed passes zero against friction, and at the flanks of a coupling unless
 *  this is the @p last piece. @return time done. */
static double piece(sim_plant_t *s, const double v_ab[2], double h, bool last, double t0_s)
{
    const double before = measured_angle(s);
    double       done;
    if ((s->kind == SIM_WITH_PARTS) || (s->parts.current_lag_s > 0.0)) {
        done = move_with_parts(s, v_ab, h, last);
    } else {
        step_t step = begin(s, v_ab);
        judge_rigid(s, &step, SIM_WITH_HOOKS);
        const sim_state_t y = rigid_step(s, &step, h, &done, false);
        s->x = y;
        turn_frame_by(s, s->model.pole_pairs * (y.theta_m_rad - step.theta0_rad));
    }
    note_edges(s, before, t0_s, done);
    return done;
}

/* ---- inverter ------------------------------------------------------------------------------------------------------------ */

static void to_phases(double alpha, double beta, double i_abc[3])
{
    i_abc[0] = alpha;
    i_abc[1] = 0.5 * (-alpha + SQRT3 * beta);
    i_abc[2] = -i_abc[0] - i_abc[1];
}

void sim_plant_phase_currents(const sim_plant_t *s, double i_abc[3])
{
    const double c = s->cosine_e;
    const double n = s->sine_e;
    to_phases(s->x.id_a * c - s->x.iq_a * n, s->x.id_a * n + s->x.iq_a * c, i_abc);
}

double sim_plant_load_speed(const sim_plant_t *s) { return s->coupling.on ? s->load.speed_rad_s : s->x.speed_rad_s; }

static void to_alpha_beta(const double v[3], double ab[2])
{
    ab[0] = (2.0 * v[0] - v[1] - v[2]) / 3.0;
    ab[1] = (v[1] - v[2]) / SQRT3;
}

static double most_inverse_inductance(const sim_plant_t *s)
{
    linkage_t f = {.inv_d = s->inv_ld, .inv_q = s->inv_lq};
    if (s->saturation != NULL) {
        f = linkage(s, &s->x);
    }
    return (f.inv_d > f.inv_q) ? f.inv_d : f.inv_q;
}

APART static void distort(const sim_plant_t *s, double h, double v[3])
{
    sim_bridge_t bridge = {
        .pwm_hz = s->model.pwm_hz, .dc_link_v = s->outside.dc_link_v, .reach_a_per_v = h * most_inverse_inductance(s)};
    double ab[2];
    to_alpha_beta(v, ab);
    const step_t  step = begin(s, ab);
    const still_t now = stator_view(s, &step);
    to_phases(now.i[0] + h * now.slope[0], now.i[1] + h * now.slope[1], bridge.end_a);
    for (int k = 0; k < s->voltage_count; k++) {
        s->voltage[k]->effect->phase_voltage(s->voltage[k]->p, &bridge, v);
    }
}

/** Voltage over the next @p h. */
static void bridge_voltage(const sim_plant_t *s, const double duty[3], double h, double ab[2])
{
    double v[3] = {duty[0] * s->outside.dc_link_v, duty[1] * s->outside.dc_link_v, duty[2] * s->outside.dc_link_v};
    if (s->voltage_count > 0) {
        distort(s, h, v);
    }
    to_alpha_beta(v, ab);
}

static void set_phase_currents(sim_plant_t *s, const double i_abc[3])
{
    double ab[2];
    to_alpha_beta(i_abc, ab);
    s->x.id_a = ab[0] * s->cosine_e + ab[1] * s->sine_e;
    s->x.iq_a = ab[1] * s->cosine_e - ab[0] * s->sine_e;
}

/* Back-EMF in the middle of the next h. */
static void back_emf(const sim_plant_t *s, double h, double ab[2])
{
    const double we = s->model.pole_pairs * s->x.speed_rad_s;
    const double angle = s->model.pole_pairs * s->x.theta_m_rad + 0.5 * h * we;
    ab[0] = -we * s->model.psi_wb * sin(angle);
    ab[1] = we * s->model.psi_wb * cos(angle);
}

/** Gates off: the diode of a phase with current puts it on the rail that opposes this current; a phase without floats. */
static void diode_voltage(const sim_plant_t *s, const double i[3], double h, double ab[2])
{
    double e[2];
    double v[3];
    double conducting = 0.0;
    back_emf(s, h, e);
    for (int k = 0; k < 3; k++) {
        v[k] = (i[k] > 0.0) ? -0.5 * s->outside.dc_link_v : ((i[k] < 0.0) ? 0.5 * s->outside.dc_link_v : 0.0);
        conducting += v[k];
    }
    for (int k = 0; k < 3; k++) {
        if (i[k] == 0.0) {
            const double emf = (k == 0) ? e[0] : 0.5 * (-e[0] + ((k == 1) ? SQRT3 : -SQRT3) * e[1]);
            v[k] = 0.5 * conducting + 1.5 * emf; /* gives v - mean(v) = emf: its current stays zero */
        }
    }
    to_alpha_beta(v, ab);
}

/** Advance by at most h with the gates off; ends early where the current of a phase passes zero, which then blocks.
 *  (Rectification of a back-EMF above the dc link is left out.) @return time done. */
static double freewheel(sim_plant_t *s, double h, bool last, double t0_s)
{
    const double none = 1e-9 * (1.0 + s->model.rated_current_a);
    double       i[3];
    double       ab[2];
    sim_plant_phase_currents(s, i);
    int conducting = 0;
    for (int k = 0; k < 3; k++) {
        i[k] = (fabs(i[k]) > none) ? i[k] : 0.0;
        conducting += (i[k] != 0.0) ? 1 : 0;
    }
    if (conducting < 2) {
        s->x.id_a = 0.0;
        s->x.iq_a = 0.0;
        back_emf(s, h, ab); /* the terminals follow it */
        const double done = piece(s, ab, h, last, t0_s);
        s->x.id_a = 0.0;
        s->x.iq_a = 0.0;
        return done;
    }
    diode_voltage(s, i, h, ab);

    /* when does the first of them arrive at zero? */
    const double  c = s->cosine_e;
    const double  n = s->sine_e;
    const step_t  step = {.vd_v = ab[0] * c + ab[1] * n, .vq_v = ab[1] * c - ab[0] * n, .theta0_rad = s->x.theta_m_rad, .stuck = true};
    const still_t still = stator_view(s, &step);
    const double  alpha = still.slope[0];
    const double  beta = still.slope[1];
    const double  di[3] = {alpha, 0.5 * (-alpha + SQRT3 * beta), 0.5 * (-alpha - SQRT3 * beta)};
    double        until = h;
    int           first = -1;
    for (int k = 0; k < 3; k++) {
        if ((i[k] * di[k] < 0.0) && (-i[k] / di[k] < until)) {
            until = -i[k] / di[k];
            first = k;
        }
    }
    const double done = piece(s, ab, last ? h : until, last, t0_s);

    double after[3];
    sim_plant_phase_currents(s, after);
    int blocked = 0;
    for (int k = 0; k < 3; k++) {
        if ((i[k] == 0.0) || (after[k] * i[k] <= 0.0) || ((k == first) && !last)) {
            after[k] = 0.0;
            blocked++;
        }
    }
    if (blocked > 1) {
        after[0] = after[1] = after[2] = 0.0;
    } else if (blocked == 1) { /* what flows in through one of the others leaves through the last */
        const int    k = (after[0] == 0.0) ? 0 : ((after[1] == 0.0) ? 1 : 2);
        const double through = 0.5 * (after[(k + 1) % 3] - after[(k + 2) % 3]);
        after[(k + 1) % 3] = through;
        after[(k + 2) % 3] = -through;
    }
    set_phase_currents(s, after);
    return done;
}

/* With saturation the slopes of the linkages, and with them R/L, go with the current: steps for the largest to come. */
APART static int steps_in(const sim_plant_t *s, double length_s)
{
    const double part = length_s / s->period_s;
    double       need = s->substeps * part;
    if ((s->saturation != NULL) && (s->model.substeps == 0.0)) {
        const double      volt_s = s->outside.dc_link_v / SQRT3 * length_s;
        const sim_state_t then = {.id_a = fabs(s->x.id_a) + volt_s * s->inv_ld, .iq_a = fabs(s->x.iq_a) + volt_s * s->inv_lq};
        const linkage_t   f = linkage(s, &then);
        const double      decay = s->model.resistance_ohm * ((f.inv_d > f.inv_q) ? f.inv_d : f.inv_q) * length_s / 0.4;
        need = (decay > need) ? decay : need;
    }
    need = ceil(need);
    return (need < 1.0) ? 1 : ((need > 1000.0) ? 1000 : (int)need);
}

/** Part of a period with constant duties. */
static inline void stretch(sim_plant_t *s, const double duty[3], bool armed, double from_s, double length_s, int steps)
{
    const double h = length_s / steps;
    double       ab[2] = {0.0, 0.0};

    for (int k = 0; k < steps; k++) {
        if (armed && ((k == 0) || (s->voltage_count > 0))) {
            bridge_voltage(s, duty, h, ab);
        }
        double left = h;
        for (int n = 0; (n < PIECES_MAX) && (left > 1e-12 * h); n++) {
            const double t0_s = from_s + k * h + (h - left);
            left -= armed ? piece(s, ab, left, n == PIECES_MAX - 1, t0_s) : freewheel(s, left, n >= PIECES_MAX / 2, t0_s);
        }
    }
}

APART static void period_with_parts(sim_plant_t *s, const double duty[3], bool armed)
{
    const double change_s = s->delay.part * s->period_s;
    const double rest_s = s->period_s - change_s;
    sim_delay_push(&s->delay, duty);
    if (change_s > 0.0) {
        stretch(s, sim_delay_first(&s->delay), armed, s->time_s, change_s, steps_in(s, change_s));
    }
    stretch(s, sim_delay_second(&s->delay), armed, s->time_s + change_s, rest_s, steps_in(s, rest_s));
}

void sim_plant_period(sim_plant_t *s, const double duty[3], bool armed)
{
    if ((s->parts.delay_periods > 0.0) || (s->saturation != NULL)) {
        period_with_parts(s, duty, armed);
    } else {
        stretch(s, duty, armed, s->time_s, s->period_s, s->substeps);
    }
    s->time_s += s->period_s;
    s->vdc_filtered_v += s->vdc_gain * (s->outside.dc_link_v - s->vdc_filtered_v);
}

/* ---- sensors --------------------------------------------------------------------------------------------------------------- */

static double convert(double x, double lsb, double range)
{
    const double y = (lsb > 0.0) ? rint(x / lsb) * lsb : x;
    return (y > range) ? range : ((y < -range) ? -range : y);
}

void sim_plant_read(sim_plant_t *s, sim_reading_t *out)
{
    const sim_model_t *const m = &s->model;
    double                   i[3];
    if (s->parts.current_lag_s > 0.0) {
        to_phases(s->lagging_a[0], s->lagging_a[1], i);
    } else {
        sim_plant_phase_currents(s, i);
    }
    for (int k = 0; k < s->current_count; k++) {
        s->current[k]->effect->current_sensor(s->current[k]->p, i);
    }
    if (m->current_noise_a > 0.0) {
        double n[2];
        sim_random_normal2(&s->noise, n);
        i[0] += m->current_noise_a * n[0];
        i[1] += m->current_noise_a * n[1];
    }
    out->ia_a = convert(i[0], m->current_lsb_a, m->current_range_a);
    out->ib_a = convert(i[1], m->current_lsb_a, m->current_range_a);
    out->vdc_v = s->vdc_filtered_v;

    double angle = measured_angle(s);
    if (m->counts_per_rev > 0.0) {
        const double count = 2.0 * PI / m->counts_per_rev;
        const double n = (double)whole_below(angle / count);
        angle = (n - m->counts_per_rev * (double)whole_below(n / m->counts_per_rev)) * count; /* wrapped as counts: exact */
    } else {
        angle -= 2.0 * PI * (double)whole_below(angle * (0.5 / PI));
    }
    out->theta_m_rad = ((angle < 0.0) || (angle >= 2.0 * PI)) ? 0.0 : angle;

    s->torque_nm = any_motor_torque(s, &s->x);
    s->load_nm = s->outside.load_torque_nm + direction_of(sim_plant_load_speed(s)) * s->outside.load_brake_nm;
}
