#include "sim_host/plant/dc_link.h"

#include <math.h>

#define LEAST_V 0.1 /* an empty capacitor feeds no bridge */
#define PIECES 4    /* of a period: the voltage passes that of the source once, twice with rounding */

void sim_dc_link_start(sim_dc_link_t *link, double volt_v, double capacity_f, double supply_ohm)
{
    link->on = capacity_f > 0.0;
    link->volt_v = volt_v;
    link->capacity_f = capacity_f;
    link->supply_ohm = supply_ohm;
    link->taken_ws = 0.0;
}

/* Time after which @p v has come to @p to on its way to @p rest, or by the constant @p slope; @p longest when it does not. */
static double time_to(double v, double to, double rest, double tau, double slope, double longest)
{
    const double left = (tau > 0.0) ? ((to - rest) / (v - rest)) : 0.0;
    double       t = longest;
    if (tau > 0.0) {
        t = ((left > 0.0) && (left < 1.0)) ? -tau * log(left) : longest;
    } else if (slope != 0.0) {
        t = (to - v) / slope;
    } else {
        /* it stays */
    }
    return ((t > 0.0) && (t < longest)) ? t : longest;
}

/* (1) over a time at a constant current of the bridge. */
static double after(const sim_dc_link_t *link, double source_v, double bridge_a, double brake_s, double time_s)
{
    double v = link->volt_v;
    double left = time_s;
    for (int n = 0; (n < PIECES) && (left > 0.0); n++) {
        const bool   feeds = (v < source_v) || ((v == source_v) && ((bridge_a + brake_s * v) > 0.0));
        const double g = brake_s + (feeds ? 1.0 / link->supply_ohm : 0.0);
        const double a = (feeds ? source_v / link->supply_ohm : 0.0) - bridge_a;
        const double tau = (g > 0.0) ? link->capacity_f / g : 0.0;
        const double rest = (g > 0.0) ? a / g : 0.0;
        const double slope = a / link->capacity_f;
        const double t = (v != source_v) ? time_to(v, source_v, rest, tau, slope, left) : left;
        if (t < left) {
            v = source_v;
        } else {
            v = (tau > 0.0) ? rest + (v - rest) * exp(-t / tau) : v + slope * t;
        }
        left -= t;
    }
    return (v > LEAST_V) ? v : LEAST_V;
}

void sim_dc_link_period(sim_dc_link_t *link, double source_v, double brake_s, double period_s)
{
    const double power_w = link->taken_ws / period_s;
    const double first_v = after(link, source_v, power_w / link->volt_v, brake_s, period_s);
    link->volt_v = after(link, source_v, 2.0 * power_w / (link->volt_v + first_v), brake_s, period_s);
    link->taken_ws = 0.0;
}
