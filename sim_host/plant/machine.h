/**
 * @file  sim_host/plant/machine.h
 * @brief Rates of change of currents, speed and angle: (1) to (4) of plant.h; inside of the plant.
 *
 * What every step runs is here to be unfolded into it; what only saturation or a coupling need is in machine.c.
 */
#ifndef SIM_HOST_PLANT_MACHINE_H
#define SIM_HOST_PLANT_MACHINE_H

#include <stddef.h>

#include "sim_host/plant/frame.h"

typedef struct {
    double did, diq, dw, dtheta;
} sim_rate_t;

typedef struct {
    double d, q;
} sim_dq_t;

/** Flux linkages of the axes from the currents, and the inverse of their slopes. */
typedef struct {
    double d_wb, q_wb, inv_d, inv_q;
} sim_linkage_t;

/** One integration step: voltage in the rotor frame at its start, direction of friction, whether the shaft is free. */
typedef struct {
    double vd_v, vq_v, theta0_rad;
    double friction_sign; /**< +1, -1, 0: no friction. */
    double drag_nm;       /**< Load and, where it does not depend on speed, friction with its sign. */
    bool   stuck;         /**< The shaft stands: the rotor, where a coupling is on. */
    double brake_sign;    /**< +1, -1, 0: direction of the brake of a load behind a coupling. */
    bool   load_stuck;
    int    side; /**< Flank of the coupling in contact, 0: none. */
} sim_step_t;

/** +1, -1, or 0 at standstill. */
static inline double sim_direction_of(double speed) { return (speed > 0.0) ? 1.0 : ((speed < 0.0) ? -1.0 : 0.0); }

/** With saturation: the slope of the linkage of an axis; all of both axes; and the torque that follows from it. */
double        sim_slope(const sim_plant_t *s, double l_h, double i_a, double other_a);
sim_linkage_t sim_linkage(const sim_plant_t *s, const sim_state_t *x);
double        sim_saturated_torque(const sim_plant_t *s, const sim_state_t *x, const sim_flux_t *h, const sim_linkage_t *f);
/** Torque of the motor, saturated or not. */
double sim_motor_torque(const sim_plant_t *s, const sim_state_t *x);
/** Torque of the coupling from the rotor to the load, with this @p side in contact. */
double sim_through_coupling(const sim_plant_t *s, const sim_state_t *x, const sim_load_t *load, int side);
/** Everything on the load behind a coupling but its brake. */
double sim_load_torque(const sim_plant_t *s, const sim_state_t *x, const sim_load_t *load, double coupling_nm);

static SIM_WITHIN double sim_friction_nm(const sim_plant_t *s, double speed_abs, sim_machine_kind_t kind)
{
    double sum = (kind == SIM_COUPLED) ? 0.0 : s->outside.load_brake_nm;
    for (int i = 0; i < s->friction_count; i++) {
        sum += s->friction[i]->effect->friction_nm(s->friction[i]->p, speed_abs);
    }
    return sum;
}

static SIM_WITHIN sim_flux_t sim_flux_harmonics(const sim_plant_t *s, const sim_state_t *x)
{
    sim_flux_t h = {0.0, 0.0};
    for (int i = 0; i < s->flux_count; i++) {
        s->flux[i]->effect->flux(s->flux[i]->p, &s->model, s->model.pole_pairs * x->theta_m_rad, s->time_s, &h);
    }
    return h;
}

/* Without flux harmonics and saturation. */
static SIM_WITHIN double sim_plain_torque(const sim_plant_t *s, const sim_state_t *x)
{
    const sim_model_t *const m = &s->model;
    return s->torque_per_amp * (m->psi_wb * x->iq_a + (m->ld_h - m->lq_h) * x->id_a * x->iq_a);
}

static SIM_WITHIN double sim_harmonic_torque(const sim_plant_t *s, const sim_state_t *x, const sim_flux_t *h)
{
    const sim_model_t *const m = &s->model;
    return s->torque_per_amp * ((m->psi_wb + h->q_wb) * x->iq_a + h->d_wb * x->id_a + (m->ld_h - m->lq_h) * x->id_a * x->iq_a);
}

/** Friction of a rotor that may not slide yet: from where it was at the start of the step. */
static inline double sim_bristle_nm(const sim_plant_t *s, const sim_state_t *x)
{
    const sim_acting_t *const a = s->bristle;
    return a->effect->bristle_nm(a->p, s->bristle_nm, x->theta_m_rad - s->x.theta_m_rad, fabs(x->speed_rad_s));
}

/** Everything on the shaft but friction that slides; behind a coupling: on the rotor. */
static SIM_WITHIN double sim_shaft_torque(const sim_plant_t *s, const sim_state_t *x, double motor_nm, double coupling_nm,
                                          sim_machine_kind_t kind)
{
    const sim_shaft_t shaft = {x->theta_m_rad, x->speed_rad_s, s->time_s};
    const bool        coupled = kind == SIM_COUPLED;
    const double      load = coupled ? coupling_nm : s->outside.load_torque_nm;
    double            sum = motor_nm - s->model.viscous_nms * x->speed_rad_s - load;
    for (int i = 0; i < s->torque_count; i++) {
        if (!coupled || !s->torque[i]->effect->at_load) {
            sum += s->torque[i]->effect->torque_nm(s->torque[i]->p, &shaft);
        }
    }
    if (s->bristle != NULL) {
        sum -= sim_bristle_nm(s, x);
    }
    return sum;
}

/** The voltage of a step in the frame of a rotor that has moved by this electrical angle since its start. */
static SIM_WITHIN sim_dq_t sim_turned_voltage(const sim_step_t *step, double moved)
{
    const double m2 = moved * moved;
    const double c = 1.0 - m2 * (0.5 - m2 * (1.0 / 24.0));
    const double n = moved * (1.0 - m2 * (1.0 / 6.0 - m2 * (1.0 / 120.0)));
    return (sim_dq_t){step->vd_v * c + step->vq_v * n, step->vq_v * c - step->vd_v * n};
}

/** (1) and (2). @return the torque (3). */
static SIM_WITHIN double sim_current_rates(const sim_plant_t *s, const sim_state_t *x, sim_dq_t v, sim_machine_kind_t kind,
                                           sim_rate_t *r)
{
    const sim_model_t *const m = &s->model;
    const double             we = m->pole_pairs * x->speed_rad_s;
    if (kind == SIM_PLAIN) {
        r->did = (v.d - m->resistance_ohm * x->id_a + we * (m->lq_h * x->iq_a)) * s->inv_ld;
        r->diq = (v.q - m->resistance_ohm * x->iq_a - we * (m->ld_h * x->id_a + m->psi_wb)) * s->inv_lq;
        return sim_plain_torque(s, x);
    }
    const sim_flux_t h = sim_flux_harmonics(s, x);
    if ((kind == SIM_WITH_HOOKS) || ((kind == SIM_COUPLED) && (s->saturation == NULL))) {
        r->did = (v.d - m->resistance_ohm * x->id_a + we * (m->lq_h * x->iq_a - h.d_wb)) * s->inv_ld;
        r->diq = (v.q - m->resistance_ohm * x->iq_a - we * (m->ld_h * x->id_a + m->psi_wb + h.q_wb)) * s->inv_lq;
        return sim_harmonic_torque(s, x, &h);
    }
    const sim_linkage_t f = sim_linkage(s, x);
    r->did = (v.d - m->resistance_ohm * x->id_a + we * (f.q_wb - h.d_wb)) * f.inv_d;
    r->diq = (v.q - m->resistance_ohm * x->iq_a - we * (f.d_wb + m->psi_wb + h.q_wb)) * f.inv_q;
    return sim_saturated_torque(s, x, &h, &f);
}

static SIM_WITHIN sim_rate_t sim_rates(const sim_plant_t *s, const sim_step_t *step, const sim_state_t *x, sim_dq_t v,
                                       double coupling_nm, sim_machine_kind_t kind)
{
    sim_rate_t   r;
    const double motor_nm = sim_current_rates(s, x, v, kind, &r);
    if (step->stuck) {
        r.dw = 0.0;
        r.dtheta = 0.0;
    } else {
        double torque;
        if (kind == SIM_PLAIN) {
            torque = motor_nm - s->model.viscous_nms * x->speed_rad_s - step->drag_nm;
        } else {
            torque = sim_shaft_torque(s, x, motor_nm, coupling_nm, kind) -
                     step->friction_sign * sim_friction_nm(s, fabs(x->speed_rad_s), kind);
        }
        r.dw = torque * s->inv_inertia;
        r.dtheta = x->speed_rad_s;
    }
    return r;
}

/** Rates in the course of a step: the frame has moved along with the rotor. */
static SIM_WITHIN sim_rate_t sim_later_rates(const sim_plant_t *s, const sim_step_t *step, const sim_state_t *x,
                                             double coupling_nm, sim_machine_kind_t kind)
{
    const double moved = s->model.pole_pairs * (x->theta_m_rad - step->theta0_rad);
    return sim_rates(s, step, x, sim_turned_voltage(step, moved), coupling_nm, kind);
}

/** At its start. */
static SIM_WITHIN sim_rate_t sim_first_rates(const sim_plant_t *s, const sim_step_t *step, const sim_state_t *x,
                                             double coupling_nm, sim_machine_kind_t kind)
{
    return sim_rates(s, step, x, (sim_dq_t){step->vd_v, step->vq_v}, coupling_nm, kind);
}

#endif
