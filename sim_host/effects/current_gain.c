#include "sim_host/plant/effect.h"

static void current_sensor(const double *p, double i_ab_a[2])
{
    i_ab_a[0] *= p[0];
    i_ab_a[1] *= p[1];
}

const sim_effect_t effect_current_gain = {
    .name = "current_gain",
    .acts_on = "current_sensor",
    .doc = "Gain of the phase-current sensors; only the mismatch of the two shows without a torque sensor.",
    .signature = "Second electrical order proportional to the current; nothing without load.",
    .confused_with = {"torque_constant", "cogging"},
    .shown_by = {{"staircase_load", ""}, {"standstill_steps", ""}},
    .told_apart = "In proportion to the current, nothing at no load; a gain common to both phases resembles a change of the "
                  "torque constant.",
    .param_count = 2,
    .param =
        {
            {"gain_a", "", "Gain of phase a, 1 = right.", 1.0, 0.1, 10.0, SIM_FACTOR, 1.03, SIM_VECTOR},
            {"gain_b", "", "Gain of phase b, 1 = right.", 1.0, 0.1, 10.0, SIM_FACTOR, 0.97, SIM_VECTOR},
        },
    .current_sensor = current_sensor,
};
