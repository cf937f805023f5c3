#include <math.h>

#include "sim_host/plant/effect.h"

/* Deep in saturation the winding is still a coil in air: the slope stays above 1 % of the nominal inductance. */
#define SLOPE_LEAST 0.01

static double linkage_wb(const double *p, double l_h, double i_a, double *slope_h)
{
    if (p[0] == 0.0) {
        *slope_h = l_h;
        return l_h * i_a;
    }
    const double end = sqrt(1.0 / SLOPE_LEAST - 1.0);
    const double x = i_a / p[0];
    if (fabs(x) > end) {
        *slope_h = SLOPE_LEAST * l_h;
        return l_h * (p[0] * copysign(atan(end), x) + SLOPE_LEAST * (i_a - p[0] * copysign(end, x)));
    }
    *slope_h = l_h / (1.0 + x * x);
    return l_h * p[0] * atan(x);
}

const sim_effect_t effect_inductance_saturation = {
    .name = "inductance_saturation",
    .acts_on = "inductance",
    .doc = "Differential inductance L / (1 + (i / i_sat)^2) of each axis with its own current. Its integral L i_sat atan(i / i_sat) is the flux linkage, "
           "which also makes the cross-coupling and the reluctance torque; the magnets' flux stays.",
    .signature = "Current steps rise faster at high current; d voltage -w Lq iq grows less than the load.",
    .param_count = 1,
    .param = {
        {"i_sat_a", "A", "Current at which the differential inductance has halved; 0: none.", 0.0, 0.0, 10000.0},
    },
    .linkage_wb = linkage_wb,
};
