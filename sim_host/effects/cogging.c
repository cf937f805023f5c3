#include <math.h>

#include "sim_host/plant/effect.h"

static double torque_nm(const double *p, const sim_shaft_t *shaft) { return -p[0] * sin(p[2] * shaft->theta_m_rad + p[1]); }

const sim_effect_t effect_cogging = {
    .name = "cogging",
    .acts_on = "torque",
    .doc = "Braking torque A sin(order theta_m + phase), independent of the current; as the load it is positive where it brakes "
           "positive rotation.",
    .signature = "Torque ripple at the slot order, constant size whatever the load; no trace in the back-EMF.",
    .confused_with = {"flux_harmonics", "dead_time"},
    .shown_by = {{"staircase", "slowly in both directions"}, {"coast_down", ""}},
    .told_apart = "Needs no current and does not show in the back-EMF.",
    .param_count = 3,
    .param =
        {
            {"amplitude_nm", "N m", "Amplitude A.", 0.0, -10000.0, 10000.0, SIM_AMPLITUDE, 0.02},
            {"phase_rad", "rad", "Phase.", 0.0, -100.0, 100.0, SIM_PHASE, 0.0},
            {"order", "1/turn", "Cycles per mechanical turn.", 0.0, 0.0, 10000.0, SIM_ORDER, 24.0},
        },
    .torque_nm = torque_nm,
};
