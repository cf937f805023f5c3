#include <math.h>

#include "sim_host/plant/effect.h"

static double friction_nm(const double *p, double speed_abs_rad_s) { return p[0] * exp(-pow(speed_abs_rad_s / p[1], p[2])); }

const sim_effect_t effect_stribeck_friction = {
    .name = "stribeck_friction",
    .acts_on = "friction",
    .doc = "Additional friction at low speed, T exp(-(w / w_s)^shape).",
    .signature = "Extra q current at low speed only; sticks at a reversal.",
    .confused_with = {"coulomb_friction", "backlash"},
    .shown_by = {{"reversal", "slowly through standstill"}},
    .told_apart = "Only below some rad/s; needs several speeds below that.",
    .param_count = 3,
    .param =
        {
            {"torque_nm", "N m", "Friction torque at standstill beyond Coulomb friction.", 0.0, 0.0, 10000.0, SIM_AMPLITUDE,
             0.02},
            {"speed_rad_s", "rad/s", "Stribeck speed w_s.", 1.0, 0.001, 10000.0, SIM_QUANTITY, 3.0},
            {"shape", "", "Exponent.", 2.0, 0.1, 10.0, SIM_DETAIL, 2.0},
        },
    .friction_nm = friction_nm,
};
