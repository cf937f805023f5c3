#include <math.h>

#include "sim_host/plant/effect.h"

/* Numbers of the effect, in the order of .param. */
enum { RESISTANCE_OHM, FLUX_REL, TIME_S, UNTIL_S, RIPPLE_REL, RIPPLE_HZ, RIPPLE_RAD, SAG_REL, RATED_W, START_S, PARAMETERS };

#define TWO_PI 6.283185307179586
#define MOST_LOAD 2.0 /* of the rated power, as far as the sag goes on */

/* 0 at the start, towards 1; it stays as it was at the end of what was measured. */
static double warm(const double *p, double time_s)
{
    const double since = time_s + p[START_S];
    const double t = ((p[UNTIL_S] > 0.0) && (since > p[UNTIL_S])) ? p[UNTIL_S] : since;
    return 1.0 - exp(-t / p[TIME_S]);
}

static void flux(const double *p, const sim_model_t *m, double theta_e_rad, double time_s, sim_flux_t *h)
{
    (void)theta_e_rad;
    if (p[FLUX_REL] != 0.0) {
        h->q_wb -= p[FLUX_REL] * m->psi_wb * warm(p, time_s);
    }
}

static void phase_voltage(const double *p, const sim_bridge_t *bridge, double v_abc_v[3])
{
    const double r = (p[RESISTANCE_OHM] != 0.0) ? p[RESISTANCE_OHM] * warm(p, bridge->time_s) : 0.0;
    double       lost = 0.0;
    if (p[RIPPLE_REL] != 0.0) {
        lost += p[RIPPLE_REL] * sin(TWO_PI * p[RIPPLE_HZ] * (bridge->time_s + p[START_S]) + p[RIPPLE_RAD]);
    }
    if (p[SAG_REL] != 0.0) {
        double power_w = 0.0; /* what all phases have in common does no work: the currents add up to none */
        for (int k = 0; k < 3; k++) {
            power_w += v_abc_v[k] * bridge->begin_a[k];
        }
        const double load = power_w / p[RATED_W];
        lost += p[SAG_REL] * ((load > MOST_LOAD) ? MOST_LOAD : ((load < -MOST_LOAD) ? -MOST_LOAD : load));
    }
    for (int k = 0; k < 3; k++) {
        v_abc_v[k] -= lost * v_abc_v[k] + r * 0.5 * (bridge->begin_a[k] + bridge->end_a[k]);
    }
}

const sim_effect_t effect_empirical_voltage = {
    .name = "empirical_voltage",
    .acts_on = "voltage",
    .doc = "Voltage that a log shows and no effect explains, as `evenspin gap` writes it: a resistance or a flux that changes "
           "with time, and a supply that swings or sags. Beyond the time that was measured each stays as it was there.",
    .signature = "That of its terms.",
    .scenario_only = true,
    .param_count = PARAMETERS,
    .param =
        {
            {"resistance_ohm", "ohm", "Resistance that builds up with time.", 0.0, -1000.0, 1000.0, SIM_AMPLITUDE, 0.2},
            {"flux_rel", "", "Share of the flux that is lost with time.", 0.0, -0.9, 0.9, SIM_AMPLITUDE, 0.05},
            {"time_s", "s", "Time constant of both.", 1.0, 1e-3, 1e6, SIM_QUANTITY, 0.05},
            {"until_s", "s", "Time up to which it was measured; 0: no end.", 0.0, 0.0, 1e7, SIM_DETAIL, 0.0},
            {"ripple_rel", "", "Share by which the voltage swings.", 0.0, -0.5, 0.5, SIM_AMPLITUDE, 0.05},
            {"ripple_hz", "Hz", "Frequency of that.", 0.0, 0.0, 2000.0, SIM_QUANTITY, 100.0},
            {"ripple_rad", "rad", "Phase of that at the start.", 0.0, -100.0, 100.0, SIM_PHASE, 0.0},
            {"sag_rel", "", "Share of the voltage that is lost at rated_w.", 0.0, -0.5, 0.5, SIM_AMPLITUDE, 0.05},
            {"rated_w", "W", "Electrical power that sag_rel is for.", 1.0, 1e-3, 1e7, SIM_QUANTITY, 100.0},
            {"start_s", "s", "Time of the log at which a run starts.", 0.0, 0.0, 1e7, SIM_DETAIL, 0.0},
        },
    .flux = flux,
    .phase_voltage = phase_voltage,
};
