#include "sim_host/plant/effect.h"

static double torque_nm(const double *p, const sim_shaft_t *shaft)
{
    (void)shaft;
    return -p[0];
}

const sim_effect_t effect_load_torque = {
    .name = "load_torque",
    .acts_on = "torque",
    .doc = "Constant torque of fixed sign that no sensor sees; positive brakes positive rotation.",
    .signature = "Offset of the q current that keeps its sign in both directions; asymmetric coast-down.",
    .at_load = true,
    .confused_with = {"coulomb_friction", "current_offset"},
    .shown_by = {{"staircase", "in both directions"}},
    .told_apart = "Does not flip with the direction; the coast-down is not symmetric.",
    .param_count = 1,
    .param =
        {
            {"torque_nm", "N m", "Torque.", 0.0, -10000.0, 10000.0, SIM_AMPLITUDE, 0.05},
        },
    .torque_nm = torque_nm,
};
