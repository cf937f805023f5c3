#include <math.h>

#include "sim_host/plant/effect.h"

static double torque_nm(const double *p, const sim_shaft_t *shaft)
{
    return -p[0] * (sin(shaft->theta_m_rad + p[1]) + p[2] * sin(2.0 * shaft->theta_m_rad + p[3]));
}

const sim_effect_t effect_misalignment = {
    .name = "misalignment",
    .acts_on = "torque",
    .doc = "Braking torque of first and second mechanical order from a coupling out of line: A sin(theta + phase) + A second_rel "
           "sin(2 theta + phase2).",
    .signature = "First (and second) mechanical order in the torque; speed ripple falls with speed, the q current answers.",
    .confused_with = {"encoder_eccentricity", "current_offset"},
    .shown_by = {{"staircase", "at low and high speed"}},
    .told_apart = "A ripple of the true torque: iq answers and speed amplitude goes as 1/w.",
    .param_count = 4,
    .param =
        {
            {"amplitude_nm", "N m", "Amplitude A of the first order.", 0.0, -10000.0, 10000.0, SIM_AMPLITUDE, 0.02},
            {"phase_rad", "rad", "Phase of the first order.", 0.0, -100.0, 100.0, SIM_PHASE, 0.0},
            {"second_rel", "", "Second order relative to the first.", 0.0, -1e6, 1e6, SIM_AMPLITUDE, 0.3, SIM_OPTIONAL},
            {"phase2_rad", "rad", "Phase of the second order.", 0.0, -100.0, 100.0, SIM_PHASE, 0.0, SIM_OPTIONAL},
        },
    .torque_nm = torque_nm,
};
