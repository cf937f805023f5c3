#include "sim_host/plant/effect.h"

static void model(const double *p, sim_model_t *m) { m->viscous_nms *= p[0]; }

const sim_effect_t effect_viscous_friction = {
    .name = "viscous_friction",
    .acts_on = "model",
    .doc = "Viscous friction over its nominal value.",
    .signature = "q current proportional to the speed; exponential coast-down.",
    .confused_with = {"coulomb_friction", "torque_constant"},
    .shown_by = {{"staircase", ""}, {"coast_down", ""}},
    .told_apart = "Slope over speed, shape of the coast-down.",
    .param_count = 1,
    .param =
        {
            {"factor", "", "Factor on the nominal value.", 1.0, 0.01, 100.0, SIM_FACTOR, 1.5},
        },
    .model = model,
};
