#include "sim_host/plant/step.h"

#include <stddef.h>

#include "sim_host/plant/encoder.h"
#include "sim_host/plant/lag.h"
#include "sim_host/plant/runge_kutta.h"

/* A flank is met this part of a step late rather than early, so that the next step begins in the new state. */
#define FLANK_LATE 1e-4

/** Direction of the friction, and whether it holds the shaft. */
static SIM_WITHIN void judge_friction(const sim_plant_t *s, sim_step_t *step, double coupling_nm, sim_machine_kind_t kind)
{
    if (s->x.speed_rad_s != 0.0) {
        step->friction_sign = (s->x.speed_rad_s > 0.0) ? 1.0 : -1.0;
    } else {
        const double push = sim_shaft_torque(s, &s->x, sim_motor_torque(s, &s->x), coupling_nm, kind);
        step->stuck = fabs(push) <= sim_friction_nm(s, 0.0, kind);
        step->friction_sign = (push > 0.0) ? 1.0 : -1.0;
    }
}

static SIM_WITHIN void judge_rigid(const sim_plant_t *s, sim_step_t *step, sim_machine_kind_t kind)
{
    if (s->model.rotor_locked != 0.0) {
        step->stuck = true;
    } else if ((s->friction_count > 0) || (s->outside.load_brake_nm > 0.0)) {
        judge_friction(s, step, 0.0, kind);
    }
    step->drag_nm = s->outside.load_torque_nm + step->friction_sign * s->outside.load_brake_nm;
}

/** judge_rigid with a coupling: friction on the rotor, the brake on the load. */
static void judge_coupled(const sim_plant_t *s, sim_step_t *step)
{
    const double brake_nm = s->outside.load_brake_nm;
    step->side = sim_coupling_side(&s->coupling, s->load.twist_rad, s->x.speed_rad_s - s->load.speed_rad_s);
    const double coupling_nm = sim_through_coupling(s, &s->x, &s->load, step->side);
    if (s->friction_count > 0) {
        judge_friction(s, step, coupling_nm, SIM_COUPLED);
    }
    if (brake_nm > 0.0) {
        step->brake_sign = sim_direction_of(s->load.speed_rad_s);
        if (s->load.speed_rad_s == 0.0) {
            const double push = sim_load_torque(s, &s->x, &s->load, coupling_nm);
            step->load_stuck = fabs(push) <= brake_nm;
            step->brake_sign = (push > 0.0) ? 1.0 : -1.0;
        }
    }
}

/** Time within the step at which the contact of the coupling changes between the present and @p y; h when it does not. */
static double flank_time(const sim_plant_t *s, const sim_step_t *step, const sim_whole_t *y, double h)
{
    const sim_coupling_t *const c = &s->coupling;
    const double                rate = s->x.speed_rad_s - s->load.speed_rad_s;
    const double                rate_y = y->x.speed_rad_s - y->load.speed_rad_s;
    double                      first = h;
    for (int side = -1; c->has_backlash && (side <= 1); side += 2) {
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

/** Go on to @p x: what bends with the rotor's travel goes along. */
static SIM_WITHIN void go_on(sim_plant_t *s, const sim_state_t *x)
{
    if (s->bristle != NULL) {
        s->bristle_nm = sim_bristle_nm(s, x);
    }
    s->x = *x;
}

/** A step of rotor and load behind a coupling: ends where one of them passes zero against friction or a flank begins or
 *  ends contact. In the @p last piece of a step flanks wait. @return time done. */
static double coupled_step(sim_plant_t *s, sim_step_t *step, double h, bool last)
{
    const double w0 = s->x.speed_rad_s;
    const double v0 = s->load.speed_rad_s;
    sim_whole_t  y = sim_whole_runge_kutta(s, step, h);
    bool         turns = !step->stuck && (y.x.speed_rad_s * step->friction_sign < 0.0);
    bool         load_turns = !step->load_stuck && (y.load.speed_rad_s * step->brake_sign < 0.0);
    if ((turns && (w0 == 0.0)) || (load_turns && (v0 == 0.0))) { /* it would start backwards: friction holds it */
        step->stuck = step->stuck || (turns && (w0 == 0.0));
        step->load_stuck = step->load_stuck || (load_turns && (v0 == 0.0));
        y = sim_whole_runge_kutta(s, step, h);
        turns = !step->stuck && (y.x.speed_rad_s * step->friction_sign < 0.0);
        load_turns = !step->load_stuck && (y.load.speed_rad_s * step->brake_sign < 0.0);
    }
    const double stop = turns ? h * w0 / (w0 - y.x.speed_rad_s) : h;
    const double load_stop = load_turns ? h * v0 / (v0 - y.load.speed_rad_s) : h;
    const double flank = last ? h : flank_time(s, step, &y, h);
    double       done = (stop < load_stop) ? stop : load_stop;
    done = (flank < done) ? flank : done;
    if (done < h) {
        y = sim_whole_runge_kutta(s, step, done);
        y.x.speed_rad_s = (turns && (done == stop)) ? 0.0 : y.x.speed_rad_s;
        y.load.speed_rad_s = (load_turns && (done == load_stop)) ? 0.0 : y.load.speed_rad_s;
    }
    go_on(s, &y.x);
    s->load = y.load;
    return done;
}

/** One step where rotor and load are one piece. @return the state at its end. */
static SIM_WITHIN sim_state_t rigid_step(const sim_plant_t *s, sim_step_t *step, double h, double *time_done,
                                         sim_machine_kind_t kind)
{
    double      done = h;
    sim_state_t y = sim_four_stages(s, step, h, kind);
    if (!step->stuck && (y.speed_rad_s * step->friction_sign < 0.0)) {
        const double w0 = s->x.speed_rad_s;
        done = h * w0 / (w0 - y.speed_rad_s); /* 0 when it would start backwards: friction holds it */
        if (!(done > 0.0)) {
            step->stuck = true;
            done = h;
        }
        y = sim_four_stages(s, step, done, kind);
        y.speed_rad_s = 0.0;
    }
    *time_done = done;
    return y;
}

sim_still_t sim_stator_view(const sim_plant_t *s, const sim_step_t *step)
{
    sim_rate_t r;
    (void)sim_current_rates(s, &s->x, sim_turned_voltage(step, s->model.pole_pairs * (s->x.theta_m_rad - step->theta0_rad)),
                            (s->saturation != NULL) ? SIM_SATURATING : SIM_WITH_HOOKS, &r);
    const double      we = s->model.pole_pairs * s->x.speed_rad_s;
    const double      did = r.did - we * s->x.iq_a; /* turned along with the frame */
    const double      diq = r.diq + we * s->x.id_a;
    const double      c = s->cosine_e;
    const double      n = s->sine_e;
    const sim_still_t v = {{s->x.id_a * c - s->x.iq_a * n, s->x.id_a * n + s->x.iq_a * c},
                           {did * c - diq * n, did * n + diq * c}};
    return v;
}

SIM_NOINLINE static void filter_currents(sim_plant_t *s, const sim_still_t *before, const sim_still_t *after, double h)
{
    sim_lag_t lag;
    sim_lag_prepare(&lag, s->parts.current_lag_s, h);
    for (int k = 0; k < 2; k++) {
        const sim_lag_input_t in = {before->i[k], after->i[k], before->slope[k], after->slope[k]};
        s->lagging_a[k] = sim_lag_step(&lag, &in, s->lagging_a[k]);
    }
}

/** Judge and do a step of a machine that turns as one piece. @return time done. */
static SIM_WITHIN double move_rigid(sim_plant_t *s, sim_step_t *step, double h, sim_machine_kind_t kind)
{
    double done;
    judge_rigid(s, step, kind);
    const sim_state_t x = rigid_step(s, step, h, &done, kind);
    go_on(s, &x);
    sim_frame_turn_by(s, s->model.pole_pairs * (s->x.theta_m_rad - step->theta0_rad));
    return done;
}

SIM_NOINLINE static double move_with_hooks(sim_plant_t *s, sim_step_t *step, double h)
{
    return move_rigid(s, step, h, SIM_WITH_HOOKS);
}

SIM_NOINLINE static double move_saturating(sim_plant_t *s, sim_step_t *step, double h)
{
    return move_rigid(s, step, h, SIM_SATURATING);
}

SIM_NOINLINE static double move_coupled(sim_plant_t *s, sim_step_t *step, double h, bool last)
{
    judge_coupled(s, step);
    const double done = coupled_step(s, step, h, last);
    sim_frame_turn_by(s, s->model.pole_pairs * (s->x.theta_m_rad - step->theta0_rad));
    return done;
}

/* The plain machine gets code without hooks, in line: half the time of the general one. */
static SIM_WITHIN double move(sim_plant_t *s, sim_step_t *step, double h, bool last)
{
    switch (s->kind) {
    case SIM_PLAIN:
        return move_rigid(s, step, h, SIM_PLAIN);
    case SIM_WITH_HOOKS:
        return move_with_hooks(s, step, h);
    case SIM_SATURATING:
        return move_saturating(s, step, h);
    default:
        return move_coupled(s, step, h, last);
    }
}

SIM_NOINLINE static double move_and_filter(sim_plant_t *s, sim_step_t *step, double h, bool last)
{
    const sim_still_t before = sim_stator_view(s, step);
    const double      done = move(s, step, h, last);
    if (done > 0.0) {
        const sim_still_t after = sim_stator_view(s, step);
        filter_currents(s, &before, &after, done);
    }
    return done;
}

double sim_step_piece(sim_plant_t *s, const double v_ab[2], double h, bool last, double t0_s)
{
    const double before = sim_encoder_angle(s);
    sim_step_t   step = sim_step_begin(s, v_ab);
    const double done = (s->parts.current_lag_s > 0.0) ? move_and_filter(s, &step, h, last) : move(s, &step, h, last);
    sim_encoder_note(s, before, t0_s, done);
    return done;
}
