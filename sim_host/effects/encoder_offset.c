#include "sim_host/plant/effect.h"

static double angle_sensor(const double *p, const sim_model_t *m, double theta_m_rad)
{
    return theta_m_rad + p[0] / m->pole_pairs;
}

const sim_effect_t effect_encoder_offset = {
    .name = "encoder_offset",
    .acts_on = "angle_sensor",
    .doc = "Commutation angle error: the measured electrical angle is too large by this.",
    .signature = "d voltage proportional to speed with the sign of the error; torque per ampere falls with its cosine.",
    .confused_with = {"torque_constant", "current_loop_delay"},
    .shown_by = {{"staircase", ""}},
    .told_apart = "Vd over speed is constant; a delay makes it grow with speed.",
    .param_count = 1,
    .param =
        {
            {"angle_el_rad", "rad", "Error, electrical.", 0.0, -3.2, 3.2, SIM_AMPLITUDE, 0.1},
        },
    .angle_sensor = angle_sensor,
};
