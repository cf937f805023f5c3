#include <math.h>

#include "sim_host/plant/effect.h"

/* Deep in saturation the winding is still a coil in air: the slope stays above 1 % of the nominal inductance. */
#define SLOPE_LEAST 0.01

enum { I_SAT_A, BY_AMPLITUDE, BY_SLOPE };

/* L / (1 + x^2), and the linkage that has this slope. */
static double own_slope_h(double l_h, double x)
{
    const double end = sqrt(1.0 / SLOPE_LEAST - 1.0);
    return (fabs(x) > end) ? SLOPE_LEAST * l_h : l_h / (1.0 + x * x);
}
static double integral_wb(double i_sat_a, double l_h, double i_a, double x)
{
    const double end = sqrt(1.0 / SLOPE_LEAST - 1.0);
    if (fabs(x) > end) {
        return l_h * (i_sat_a * copysign(atan(end), x) + SLOPE_LEAST * (i_a - i_sat_a * copysign(end, x)));
    }
    return l_h * i_sat_a * atan(x);
}

/* With the current of both axes. */
static double both_slope_h(double l_h, double x, double y)
{
    const double soft = 1.0 / (1.0 + x * x + y * y);
    return l_h * ((soft > SLOPE_LEAST) ? soft : SLOPE_LEAST);
}

static double slope_h(const double *p, double l_h, double i_a, double other_a)
{
    if (p[I_SAT_A] == 0.0) {
        return l_h;
    }
    const double x = i_a / p[I_SAT_A];
    const double own_h = own_slope_h(l_h, x);
    return own_h + p[BY_AMPLITUDE] * (both_slope_h(l_h, x, other_a / p[I_SAT_A]) - own_h);
}

static double linkage_wb(const double *p, double l_h, double i_a, double other_a, double *out_slope_h)
{
    if (p[I_SAT_A] == 0.0) {
        *out_slope_h = l_h;
        return l_h * i_a;
    }
    const double x = i_a / p[I_SAT_A];
    const double own_h = own_slope_h(l_h, x);
    const double both_h = both_slope_h(l_h, x, other_a / p[I_SAT_A]);
    double       own_wb = integral_wb(p[I_SAT_A], l_h, i_a, x);
    own_wb += p[BY_SLOPE] * (own_h * i_a - own_wb);
    *out_slope_h = own_h + p[BY_AMPLITUDE] * (both_h - own_h);
    return own_wb + p[BY_AMPLITUDE] * (both_h * i_a - own_wb);
}

const sim_effect_t effect_inductance_saturation = {
    .name = "inductance_saturation",
    .acts_on = "inductance",
    .doc = "Differential inductance L / (1 + (i / i_sat)^2) of each axis with its own current. Its integral L i_sat atan(i / "
           "i_sat) is the flux linkage, "
           "which also makes the cross-coupling and the reluctance torque; the magnets' flux stays. By amplitude the current of "
           "both axes together, "
           "sqrt(id^2 + iq^2), lowers both inductances, and the lowered ones make the cross-coupling and the reluctance torque, "
           "too; by slope "
           "those of each axis do.",
    .signature = "Current steps rise faster at high current; d voltage -w Lq iq grows less than the load.",
    .confused_with = {"current_filter", "current_loop_delay"},
    .shown_by = {{"standstill_steps", "at rated current and above"}},
    .told_apart = "Depends on the amplitude of the step.",
    .param_count = 3,
    .param =
        {
            {"i_sat_a", "A", "Current at which the differential inductance has halved; 0: none.", 0.0, 0.0, 10000.0,
             SIM_AMPLITUDE, 8.0},
            {"by_amplitude", "", "0: each axis saturates with its own current; 1: both with the amplitude; between: a mixture.",
             0.0, 0.0, 1.0, SIM_DETAIL, 0.0},
            {"by_slope", "",
             "0: an axis' linkage is the integral of its inductance; 1: the inductance at its current times that; between: a "
             "mixture.",
             0.0, 0.0, 1.0, SIM_DETAIL, 0.0},
        },
    .linkage_wb = linkage_wb,
    .slope_h = slope_h,
};
