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
    .param_count = 1,
    .param = {
        {"torque_nm", "N m", "Torque.", 0.0, -10000.0, 10000.0},
    },
    .torque_nm = torque_nm,
};
