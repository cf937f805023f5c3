#include "sim_host/plant/effect.h"

static void model(const double *p, sim_model_t *m) { m->psi_wb *= p[0]; }

const sim_effect_t effect_torque_constant = {
    .name = "torque_constant",
    .acts_on = "model",
    .doc = "Flux linkage over its nominal value (magnet temperature, demagnetisation).",
    .signature = "Voltage per speed and current per load torque change by the same factor.",
    .confused_with = {"winding_resistance", "inertia", "current_gain"},
    .shown_by = {{"staircase", ""}, {"staircase_load", ""}},
    .told_apart = "Back-EMF at no load.",
    .param_count = 1,
    .param =
        {
            {"factor", "", "Factor on the nominal flux linkage.", 1.0, 0.01, 100.0, SIM_FACTOR, 0.95},
        },
    .model = model,
};
