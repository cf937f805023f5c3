#include <math.h>

#include "sim_host/plant/effect.h"

#define SWEEPS 3 /* over the phases, which their star point ties together; each leaves a third of the error at most */
#define FAR 2.0  /* a current that the loss cannot bring near zero even with the star point against it */

static double within_one(double x) { return (x > 1.0) ? 1.0 : ((x < -1.0) ? -1.0 : x); }

/* The loss opposes the current that would be there at the end of the step, and takes it to zero at most: there it
 * stays while the rest of the voltage is smaller than the loss, as behind blocking diodes, instead of chattering. */
static void phase_voltage(const double *p, const sim_bridge_t *bridge, double v_abc_v[3])
{
    const double loss_v = p[0] * bridge->pwm_hz * bridge->dc_link_v;
    const double loss_a = loss_v * bridge->reach_a_per_v;
    if (!(loss_a > 0.0)) {
        return;
    }
    double steps[3]; /* to zero */
    double direction[3];
    bool   near = false;
    for (int k = 0; k < 3; k++) {
        steps[k] = bridge->end_a[k] / loss_a;
        direction[k] = within_one(steps[k]);
        near = near || (fabs(steps[k]) < FAR);
    }
    for (int n = 0; near && (n < SWEEPS); n++) {
        for (int k = 0; k < 3; k++) { /* wanted: steps[k] = direction[k] - mean of all three */
            const double others = direction[(k + 1) % 3] + direction[(k + 2) % 3];
            direction[k] = within_one(1.5 * steps[k] + 0.5 * others);
        }
    }
    for (int k = 0; k < 3; k++) {
        v_abc_v[k] -= loss_v * direction[k];
    }
}

const sim_effect_t effect_dead_time = {
    .name = "dead_time",
    .acts_on = "inverter",
    .doc = "Dead time of the bridge: average volt-second loss that opposes each phase current.",
    .signature = "Voltage offset that follows the signs of the phase currents, sixth electrical order at low speed, step at zero in the voltage-current curve.",
    .param_count = 1,
    .param = {
        {"dead_time_s", "s", "Dead time per edge pair.", 0.0, 0.0, 2e-05},
    },
    .phase_voltage = phase_voltage,
};
