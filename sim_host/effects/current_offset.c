#include "sim_host/plant/effect.h"

static void current_sensor(const double *p, double i_ab_a[2])
{
    i_ab_a[0] += p[0];
    i_ab_a[1] += p[1];
}

const sim_effect_t effect_current_offset = {
    .name = "current_offset",
    .acts_on = "current_sensor",
    .doc = "Additive error of the phase-current sensors.",
    .signature = "First electrical order in speed and q current, independent of load; the logged currents appear controlled, the "
                 "voltage commands carry the evidence.",
    .confused_with = {"misalignment", "current_gain", "cogging"},
    .shown_by = {{"staircase", "at low speed"}},
    .told_apart = "The ripple is constant in amperes and does not grow with load; the voltages hold the evidence.",
    .param_count = 2,
    .param =
        {
            {"offset_a_a", "A", "Offset of phase a.", 0.0, -100.0, 100.0, SIM_AMPLITUDE, 0.1, SIM_VECTOR},
            {"offset_b_a", "A", "Offset of phase b.", 0.0, -100.0, 100.0, SIM_AMPLITUDE, -0.05, SIM_VECTOR},
        },
    .current_sensor = current_sensor,
};
