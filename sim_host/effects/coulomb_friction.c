#include <math.h>

#include "sim_host/plant/effect.h"

/* Size at a speed: all of it, also at standstill, or rising to it over some speeds. */
static double level_nm(const double *p, double speed_abs_rad_s)
{
    return (p[1] > 0.0) ? (p[0] * tanh(speed_abs_rad_s / p[1])) : p[0];
}

static double friction_nm(const double *p, double speed_abs_rad_s) { return (p[2] > 0.0) ? 0.0 : level_nm(p, speed_abs_rad_s); }

/* Dahl's model with exponent 1: bristles bend by the angle that the rotor moves until they slide. */
static double bristle_nm(const double *p, double held_nm, double moved_rad, double speed_abs_rad_s)
{
    if (p[2] == 0.0) {
        return 0.0;
    }
    const double end_nm = copysign(level_nm(p, speed_abs_rad_s), moved_rad);
    return end_nm + ((held_nm - end_nm) * exp(-fabs(moved_rad) / p[2]));
}

const sim_effect_t effect_coulomb_friction = {
    .name = "coulomb_friction",
    .acts_on = "friction",
    .doc = "Dry friction of constant size. At standstill it holds, or rises with the speed, or bends before it slides (Dahl).",
    .signature = "Offset of the q current with the sign of the speed, the same at every speed; linear coast-down tail.",
    .confused_with = {"viscous_friction", "stribeck_friction", "load_torque"},
    .shown_by = {{"staircase", "in both directions"}, {"coast_down", ""}},
    .told_apart = "Flips with the direction and does not depend on the speed.",
    .param_count = 3,
    .param =
        {
            {"torque_nm", "N m", "Friction torque.", 0.0, 0.0, 10000.0, SIM_AMPLITUDE, 0.02},
            {"smooth_rad_s", "rad/s", "The torque is that times tanh(w / smooth); 0: it holds the shaft.", 0.0, 0.0, 1000.0,
             SIM_DETAIL, 0.0},
            {"presliding_rad", "rad", "Travel from which the shaft slides; below, friction is a spring. 0: none.", 0.0, 0.0, 10.0,
             SIM_DETAIL, 0.0},
        },
    .friction_nm = friction_nm,
    .bristle_nm = bristle_nm,
};
