#include "sim_host/plant/machine.h"

sim_linkage_t sim_linkage(const sim_plant_t *s, const sim_state_t *x)
{
    const sim_acting_t *const a = s->saturation;
    sim_linkage_t             f;
    f.d_wb = a->effect->linkage_wb(a->p, s->model.ld_h, x->id_a, x->iq_a, &f.inv_d);
    f.q_wb = a->effect->linkage_wb(a->p, s->model.lq_h, x->iq_a, x->id_a, &f.inv_q);
    f.inv_d = 1.0 / f.inv_d;
    f.inv_q = 1.0 / f.inv_q;
    return f;
}

double sim_slope(const sim_plant_t *s, double l_h, double i_a, double other_a)
{
    const sim_effect_t *const e = s->saturation->effect;
    const double *const       p = s->saturation->p;
    double                    slope_h = 0.0;
    if (e->slope_h != NULL) {
        return e->slope_h(p, l_h, i_a, other_a);
    }
    (void)e->linkage_wb(p, l_h, i_a, other_a, &slope_h);
    return slope_h;
}

double sim_saturated_torque(const sim_plant_t *s, const sim_state_t *x, const sim_flux_t *h, const sim_linkage_t *f)
{
    return s->torque_per_amp * ((s->model.psi_wb + h->q_wb + f->d_wb) * x->iq_a + (h->d_wb - f->q_wb) * x->id_a);
}

double sim_motor_torque(const sim_plant_t *s, const sim_state_t *x)
{
    if (s->kind == SIM_PLAIN) {
        return sim_plain_torque(s, x);
    }
    const sim_flux_t h = sim_flux_harmonics(s, x);
    if (s->saturation == NULL) {
        return sim_harmonic_torque(s, x, &h);
    }
    const sim_linkage_t f = sim_linkage(s, x);
    return sim_saturated_torque(s, x, &h, &f);
}

double sim_through_coupling(const sim_plant_t *s, const sim_state_t *x, const sim_load_t *load, int side)
{
    return sim_coupling_torque(&s->coupling, side, load->twist_rad, x->speed_rad_s - load->speed_rad_s);
}

double sim_load_torque(const sim_plant_t *s, const sim_state_t *x, const sim_load_t *load, double coupling_nm)
{
    const sim_shaft_t shaft = {x->theta_m_rad - load->twist_rad, load->speed_rad_s, s->time_s};
    double            sum = coupling_nm - s->outside.load_torque_nm - s->coupling.load_viscous_nms * load->speed_rad_s;
    for (int i = 0; i < s->torque_count; i++) {
        if (s->torque[i]->effect->at_load) {
            sum += s->torque[i]->effect->torque_nm(s->torque[i]->p, &shaft);
        }
    }
    return sum;
}
