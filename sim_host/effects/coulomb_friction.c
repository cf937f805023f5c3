#include "sim_host/plant/effect.h"

static double friction_nm(const double *p, double speed_abs_rad_s)
{
    (void)speed_abs_rad_s;
    return p[0];
}

const sim_effect_t effect_coulomb_friction = {
    .name = "coulomb_friction",
    .acts_on = "friction",
    .doc = "Dry friction of constant size.",
    .signature = "Offset of the q current with the sign of the speed, the same at every speed; linear coast-down tail.",
    .confused_with = {"viscous_friction", "stribeck_friction", "load_torque"},
    .shown_by = {{"staircase", "in both directions"}, {"coast_down", ""}},
    .told_apart = "Flips with the direction and does not depend on the speed.",
    .param_count = 1,
    .param =
        {
            {"torque_nm", "N m", "Friction torque.", 0.0, 0.0, 10000.0, SIM_AMPLITUDE, 0.02},
        },
    .friction_nm = friction_nm,
};
