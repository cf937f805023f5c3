#include <math.h>

#include "sim_host/plant/effect.h"

#define LINES 6

static double torque_nm(const double *p, const sim_shaft_t *shaft)
{
    double sum = 0.0;
    for (int k = 0; k < LINES; k++) {
        const double *const line = &p[3 * k];
        if (line[1] != 0.0) {
            sum -= line[1] * sin(line[0] * shaft->theta_m_rad + line[2]);
        }
    }
    return sum;
}

const sim_effect_t effect_torque_ripple = {
    .name = "torque_ripple",
    .acts_on = "torque",
    .doc = "Braking torque of up to six lines A sin(order theta_m + phase), for scenarios with a whole spectrum.",
    .signature = "Lines at whole mechanical orders in torque and speed.",
    .scenario_only = true,
    .param_count = 3 * LINES,
    .param =
        {
            {"order_1", "1/turn", "Cycles per mechanical turn of line 1.", 0.0, 0.0, 10000.0, SIM_ORDER, 6.0},
            {"amplitude_1_nm", "N m", "Amplitude of line 1.", 0.0, -10000.0, 10000.0, SIM_AMPLITUDE, 0.01},
            {"phase_1_rad", "rad", "Phase of line 1.", 0.0, -100.0, 100.0, SIM_PHASE, 0.0},
            {"order_2", "1/turn", "Cycles per mechanical turn of line 2.", 0.0, 0.0, 10000.0, SIM_ORDER, 12.0},
            {"amplitude_2_nm", "N m", "Amplitude of line 2.", 0.0, -10000.0, 10000.0, SIM_AMPLITUDE, 0.01},
            {"phase_2_rad", "rad", "Phase of line 2.", 0.0, -100.0, 100.0, SIM_PHASE, 0.0},
            {"order_3", "1/turn", "Cycles per mechanical turn of line 3.", 0.0, 0.0, 10000.0, SIM_ORDER, 18.0},
            {"amplitude_3_nm", "N m", "Amplitude of line 3.", 0.0, -10000.0, 10000.0, SIM_AMPLITUDE, 0.01},
            {"phase_3_rad", "rad", "Phase of line 3.", 0.0, -100.0, 100.0, SIM_PHASE, 0.0},
            {"order_4", "1/turn", "Cycles per mechanical turn of line 4.", 0.0, 0.0, 10000.0, SIM_ORDER, 24.0},
            {"amplitude_4_nm", "N m", "Amplitude of line 4.", 0.0, -10000.0, 10000.0, SIM_AMPLITUDE, 0.01},
            {"phase_4_rad", "rad", "Phase of line 4.", 0.0, -100.0, 100.0, SIM_PHASE, 0.0},
            {"order_5", "1/turn", "Cycles per mechanical turn of line 5.", 0.0, 0.0, 10000.0, SIM_ORDER, 30.0},
            {"amplitude_5_nm", "N m", "Amplitude of line 5.", 0.0, -10000.0, 10000.0, SIM_AMPLITUDE, 0.01},
            {"phase_5_rad", "rad", "Phase of line 5.", 0.0, -100.0, 100.0, SIM_PHASE, 0.0},
            {"order_6", "1/turn", "Cycles per mechanical turn of line 6.", 0.0, 0.0, 10000.0, SIM_ORDER, 36.0},
            {"amplitude_6_nm", "N m", "Amplitude of line 6.", 0.0, -10000.0, 10000.0, SIM_AMPLITUDE, 0.01},
            {"phase_6_rad", "rad", "Phase of line 6.", 0.0, -100.0, 100.0, SIM_PHASE, 0.0},
        },
    .torque_nm = torque_nm,
};
