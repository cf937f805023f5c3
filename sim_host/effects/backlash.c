#include "sim_host/plant/effect.h"

static void parts(const double *p, sim_parts_t *x)
{
    x->has_backlash = true;
    x->backlash_rad = p[0];
    x->load_ratio = p[1];
    x->resonance_hz = p[2];
    x->damping_ratio = p[3];
    x->load_friction_share = p[4];
}

const sim_effect_t effect_backlash = {
    .name = "backlash",
    .acts_on = "shaft",
    .doc =
        "Play between rotor and load. A flank in contact is a damped spring that pushes and never pulls; between the flanks "
        "nothing couples them. "
        "Starts in the middle of the backlash. Dry friction and ripple act on the rotor, the load and the effect load_torque on "
        "the load.",
    .signature = "Rotor runs free and hits when the torque changes sign; limit cycle at no load; amplitude matters, unlike with "
                 "a resonance.",
    .confused_with = {"two_mass", "stribeck_friction"},
    .shown_by = {{"reversal", ""}, {"load_step", ""}},
    .told_apart = "Only where the torque crosses zero; depends on the amplitude.",
    .param_count = 5,
    .param =
        {
            {"gap_rad", "rad", "Total backlash.", 0.0, 0.0, 1.0, SIM_AMPLITUDE, 0.01},
            {"load_ratio", "", "Inertia of the load over the total, J_load / (J_rotor + J_load).", 0.5, 0.0, 0.999, SIM_SHARE,
             0.5},
            {"f_res_hz", "Hz", "Resonance in contact with both ends free, undamped; 0: stiff and without backlash.", 1000.0, 0.0,
             5000.0, SIM_QUANTITY, 60.0},
            {"damping_ratio", "", "Damping ratio of this resonance.", 0.1, 0.0, 2.0, SIM_QUANTITY, 0.05},
            {"load_friction_share", "", "Share of the viscous friction that acts on the load; the rest acts on the rotor.", 0.0,
             0.0, 1.0, SIM_DETAIL, 0.5},
        },
    .parts = parts,
};
