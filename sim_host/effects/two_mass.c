#include "sim_host/plant/effect.h"

static void parts(const double *p, sim_parts_t *x)
{
    x->resonance_hz = p[0];
    x->load_ratio = p[1];
    x->damping_ratio = p[2];
    x->load_friction_share = p[3];
}

const sim_effect_t effect_two_mass = {
    .name = "two_mass",
    .acts_on = "shaft",
    .doc = "Rotor and load turn on a shaft that twists; their inertias add up to the nominal one. Dry friction and ripple act on "
           "the rotor, the load "
           "and the effect load_torque on the load. Together with the effect backlash the gap lies in this shaft.",
    .signature =
        "Resonance after steps of speed or load at one frequency whatever the amplitude; less inertia above the antiresonance.",
    .confused_with = {"backlash", "inertia"},
    .shown_by = {{"staircase", ""}, {"load_step", ""}},
    .told_apart = "Linear: the frequency stays, the static inertia is right.",
    .param_count = 4,
    .param =
        {
            {"f_res_hz", "Hz", "Resonance with both ends free, undamped; 0: stiff.", 0.0, 0.0, 5000.0, SIM_QUANTITY, 60.0},
            {"load_ratio", "", "Inertia of the load over the total, J_load / (J_rotor + J_load).", 0.5, 0.0, 0.999, SIM_SHARE,
             0.5},
            {"damping_ratio", "", "Damping ratio of this resonance.", 0.02, 0.0, 2.0, SIM_QUANTITY, 0.02},
            {"load_friction_share", "", "Share of the viscous friction that acts on the load; the rest acts on the rotor.", 0.0,
             0.0, 1.0, SIM_DETAIL, 0.5},
        },
    .parts = parts,
};
