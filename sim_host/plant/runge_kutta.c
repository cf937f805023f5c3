#include "sim_host/plant/runge_kutta.h"

typedef struct {
    sim_rate_t x;
    double     dload, dtwist;
} whole_rate_t;

static SIM_WITHIN whole_rate_t whole_rates(const sim_plant_t *s, const sim_step_t *step, const sim_whole_t *y, bool first)
{
    const double coupling_nm = sim_through_coupling(s, &y->x, &y->load, step->side);
    whole_rate_t r = {.dload = 0.0};
    r.x = first ? sim_first_rates(s, step, &y->x, coupling_nm, SIM_COUPLED)
                : sim_later_rates(s, step, &y->x, coupling_nm, SIM_COUPLED);
    r.dtwist = r.x.dtheta - y->load.speed_rad_s;
    if (!step->load_stuck) {
        const double brake_nm = step->brake_sign * s->outside.load_brake_nm;
        r.dload = (sim_load_torque(s, &y->x, &y->load, coupling_nm) - brake_nm) * s->coupling.inv_load;
    }
    return r;
}

static SIM_WITHIN sim_whole_t whole_ahead(const sim_whole_t *y, const whole_rate_t *r, double h)
{
    const sim_whole_t z = {sim_ahead(&y->x, &r->x, h), {y->load.speed_rad_s + h * r->dload, y->load.twist_rad + h * r->dtwist}};
    return z;
}

sim_whole_t sim_whole_runge_kutta(const sim_plant_t *s, const sim_step_t *step, double h)
{
    const sim_whole_t  y = {s->x, s->load};
    const whole_rate_t k1 = whole_rates(s, step, &y, true);
    const sim_whole_t  y2 = whole_ahead(&y, &k1, 0.5 * h);
    const whole_rate_t k2 = whole_rates(s, step, &y2, false);
    const sim_whole_t  y3 = whole_ahead(&y, &k2, 0.5 * h);
    const whole_rate_t k3 = whole_rates(s, step, &y3, false);
    const sim_whole_t  y4 = whole_ahead(&y, &k3, h);
    const whole_rate_t k4 = whole_rates(s, step, &y4, false);
    const whole_rate_t mean = {sim_mean_rate(&k1.x, &k2.x, &k3.x, &k4.x),
                               (k1.dload + 2.0 * (k2.dload + k3.dload) + k4.dload) / 6.0,
                               (k1.dtwist + 2.0 * (k2.dtwist + k3.dtwist) + k4.dtwist) / 6.0};
    return whole_ahead(&y, &mean, h);
}
