#include "sim_host/plant/effect.h"

static void phase_voltage(const double *p, const sim_model_t *m, const double i_abc_a[3], double v_abc_v[3])
{
    const double loss_v = p[0] * m->pwm_hz * m->dc_link_v;
    for (int k = 0; k < 3; k++) {
        v_abc_v[k] -= (i_abc_a[k] > 0.0) ? loss_v : ((i_abc_a[k] < 0.0) ? -loss_v : 0.0);
    }
}

const sim_effect_t effect_dead_time = {
    .name = "dead_time",
    .acts_on = "inverter",
    .doc = "Dead time of the bridge: average volt-second loss that opposes each phase current.",
    .signature = "Voltage offset that follows the signs of the phase currents, sixth electrical order at low speed, step at zero in the voltage-current curve.",
    .param_count = 1,
    .param = {
        {"dead_time_s", "s", "Dead time per edge pair.", 0.0, 0.0, 2e-05},
    },
    .phase_voltage = phase_voltage,
};
