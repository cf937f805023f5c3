#include <math.h>

#include "sim_host/plant/effect.h"

static double angle_sensor(const double *p, const sim_model_t *m, double theta_m_rad)
{
    (void)m;
    return theta_m_rad + p[0] * sin(theta_m_rad + p[1]);
}

const sim_effect_t effect_encoder_eccentricity = {
    .name = "encoder_eccentricity",
    .acts_on = "angle_sensor",
    .doc = "Encoder disc off centre: measured angle = angle + A sin(angle + phase).",
    .signature = "First mechanical order in the measured speed that grows with the speed, also while coasting.",
    .confused_with = {"misalignment"},
    .shown_by = {{"staircase", "at high speed"}, {"coast_down", ""}},
    .told_apart = "In the coast-down, without current, amplitude over speed stays constant.",
    .param_count = 2,
    .param =
        {
            {"amplitude_rad", "rad", "Amplitude A, mechanical.", 0.0, -0.5, 0.5, SIM_AMPLITUDE, 0.002},
            {"phase_rad", "rad", "Phase.", 0.0, -100.0, 100.0, SIM_PHASE, 0.0},
        },
    .angle_sensor = angle_sensor,
};
