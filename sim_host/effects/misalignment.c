#include <math.h>

#include "sim_host/plant/effect.h"

static double torque_nm(const double *p, const sim_shaft_t *shaft)
{
    return -p[0] * (sin(shaft->theta_m_rad + p[1]) + p[2] * sin(2.0 * shaft->theta_m_rad + p[3]));
}

const sim_effect_t effect_misalignment = {
    .name = "misalignment",
    .acts_on = "torque",
    .doc = "Braking torque of first and second mechanical order from a coupling out of line: A sin(theta + phase) + A second_rel sin(2 theta + phase2).",
    .signature = "First (and second) mechanical order in the torque; speed ripple falls with speed, the q current answers.",
    .param_count = 4,
    .param = {
        {"amplitude_nm", "N m", "Amplitude A of the first order.", 0.0, -10000.0, 10000.0},
        {"phase_rad", "rad", "Phase of the first order.", 0.0, -100.0, 100.0},
        {"second_rel", "", "Second order relative to the first.", 0.0, -1e6, 1e6},
        {"phase2_rad", "rad", "Phase of the second order.", 0.0, -100.0, 100.0},
    },
    .torque_nm = torque_nm,
};
