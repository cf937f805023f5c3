/**
 * @file  sim_host/plant/runge_kutta.h
 * @brief Four stages of Runge-Kutta over @p h from the present state, which stays; inside of the plant.
 */
#ifndef SIM_HOST_PLANT_RUNGE_KUTTA_H
#define SIM_HOST_PLANT_RUNGE_KUTTA_H

#include "sim_host/plant/machine.h"

/** A rotor and a load behind a coupling. */
typedef struct {
    sim_state_t x;
    sim_load_t  load;
} sim_whole_t;

/** With a coupling. */
sim_whole_t sim_whole_runge_kutta(const sim_plant_t *s, const sim_step_t *step, double h);

static SIM_WITHIN sim_state_t sim_ahead(const sim_state_t *x, const sim_rate_t *r, double h)
{
    const sim_state_t y = {x->id_a + h * r->did, x->iq_a + h * r->diq, x->speed_rad_s + h * r->dw,
                           x->theta_m_rad + h * r->dtheta};
    return y;
}

static SIM_WITHIN sim_rate_t sim_mean_rate(const sim_rate_t *k1, const sim_rate_t *k2, const sim_rate_t *k3, const sim_rate_t *k4)
{
    const double     sixth = 1.0 / 6.0;
    const sim_rate_t mean = {
        (k1->did + 2.0 * (k2->did + k3->did) + k4->did) * sixth, (k1->diq + 2.0 * (k2->diq + k3->diq) + k4->diq) * sixth,
        (k1->dw + 2.0 * (k2->dw + k3->dw) + k4->dw) * sixth, (k1->dtheta + 2.0 * (k2->dtheta + k3->dtheta) + k4->dtheta) * sixth};
    return mean;
}

/** Of a machine that turns as one piece. */
static SIM_WITHIN sim_state_t sim_four_stages(const sim_plant_t *s, const sim_step_t *step, double h, sim_machine_kind_t kind)
{
    const sim_state_t *const x = &s->x;
    const sim_rate_t         k1 = sim_first_rates(s, step, x, 0.0, kind);
    const sim_state_t        x2 = sim_ahead(x, &k1, 0.5 * h);
    const sim_rate_t         k2 = sim_later_rates(s, step, &x2, 0.0, kind);
    const sim_state_t        x3 = sim_ahead(x, &k2, 0.5 * h);
    const sim_rate_t         k3 = sim_later_rates(s, step, &x3, 0.0, kind);
    const sim_state_t        x4 = sim_ahead(x, &k3, h);
    const sim_rate_t         k4 = sim_later_rates(s, step, &x4, 0.0, kind);
    const sim_rate_t         mean = sim_mean_rate(&k1, &k2, &k3, &k4);
    return sim_ahead(x, &mean, h);
}

#endif
