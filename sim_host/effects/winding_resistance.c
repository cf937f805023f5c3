#include "sim_host/plant/effect.h"

static void model(const double *p, sim_model_t *m) { m->resistance_ohm *= p[0]; }

const sim_effect_t effect_winding_resistance = {
    .name = "winding_resistance",
    .acts_on = "model",
    .doc = "Winding resistance over its nominal value.",
    .signature = "Voltage per current at standstill and under load, independent of speed.",
    .confused_with = {"dead_time", "torque_constant"},
    .shown_by = {{"standstill_steps", ""}, {"staircase_load", ""}},
    .told_apart = "A slope only, the same at every speed.",
    .param_count = 1,
    .param =
        {
            {"factor", "", "Factor on the nominal value.", 1.0, 0.01, 100.0, SIM_FACTOR, 1.1},
        },
    .model = model,
};
