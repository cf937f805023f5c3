#include "sim_host/plant/effect.h"

static void model(const double *p, sim_model_t *m) { m->inertia_kgm2 *= p[0]; }

const sim_effect_t effect_inertia = {
    .name = "inertia",
    .acts_on = "model",
    .doc = "Inertia over its nominal value.",
    .signature = "q current and overshoot during steps; time scale of the coast-down. Not in the back-EMF.",
    .confused_with = {"torque_constant", "two_mass"},
    .shown_by = {{"staircase", ""}, {"coast_down", ""}, {"load_step", ""}},
    .told_apart = "The torque constant changes the back-EMF and iq under a measured load as well.",
    .param_count = 1,
    .param =
        {
            {"factor", "", "Factor on the nominal value.", 1.0, 0.01, 100.0, SIM_FACTOR, 1.5},
        },
    .model = model,
};
