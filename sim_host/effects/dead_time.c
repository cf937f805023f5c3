#include "sim_host/plant/effect.h"

/* The loss goes over linearly between the directions, within this many times the current that it moves in one step: a
 * current that only the loss drives falls to a third with each step and never passes zero, so that one which the rest
 * of the voltage cannot carry out of zero rests there, as behind blocking diodes, instead of chattering around it. */
#define PASSAGE_STEPS 1.5

static double direction(double i_a, double passage_a)
{
    return (i_a >= passage_a) ? 1.0 : ((i_a <= -passage_a) ? -1.0 : (i_a / passage_a));
}

static void phase_voltage(const double *p, const sim_bridge_t *bridge, const double i_abc_a[3], double v_abc_v[3])
{
    const double loss_v = p[0] * bridge->pwm_hz * bridge->dc_link_v;
    const double passage_a = PASSAGE_STEPS * loss_v * bridge->reach_a_per_v;
    for (int k = 0; k < 3; k++) {
        v_abc_v[k] -= loss_v * direction(i_abc_a[k], passage_a);
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
