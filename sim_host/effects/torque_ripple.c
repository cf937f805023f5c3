#include <math.h>

#include "sim_host/plant/effect.h"

#define LINES 6
#define FAR_RAD 1e9 /* times an order of 10000: a double still counts its half turns one by one */

/* Half a turn, rad, in two parts: a whole number below 2^24 times the first is exact. */
static const double HALF_TURN = 0x1.921fb54p+1, HALF_TURN_REST = 0x1.10b4611a62633p-29, PER_HALF_TURN = 0.31830988618379067;
static const double TO_WHOLE = 0x1.8p52; /* added and taken away again: rounds to a whole number */

/** Sines of all angles, rad, in place: what is beyond whole half turns, a quarter turn at most, by the Taylor series, of
 *  which the first term left out is below 3e-16. Within 1e-15 of sin(), from 5e7 rad on within the last bit of the angle.
 *  Side by side they take half the time of six calls. */
static void sines(double x[LINES])
{
    for (int k = 0; k < LINES; k++) {
        const double whole = (x[k] * PER_HALF_TURN + TO_WHOLE) - TO_WHOLE;
        const double odd = whole - 2.0 * ((0.5 * whole + TO_WHOLE) - TO_WHOLE); /* -1, 0 or 1 */
        const double r = (x[k] - whole * HALF_TURN) - whole * HALF_TURN_REST;
        const double q = r * r;
        double       y = -1.0 / 121645100408832000.0; /* 1 / 19! */
        y = y * q + 1.0 / 355687428096000.0;
        y = y * q - 1.0 / 1307674368000.0;
        y = y * q + 1.0 / 6227020800.0;
        y = y * q - 1.0 / 39916800.0;
        y = y * q + 1.0 / 362880.0;
        y = y * q - 1.0 / 5040.0;
        y = y * q + 1.0 / 120.0;
        y = y * q - 1.0 / 6.0;
        x[k] = (1.0 - 2.0 * odd * odd) * (r + r * (q * y));
    }
}

static double torque_nm(const double *p, const sim_shaft_t *shaft)
{
    double sine[LINES];
    for (int k = 0; k < LINES; k++) {
        sine[k] = p[3 * k] * shaft->theta_m_rad + p[3 * k + 2];
    }
    if (fabs(shaft->theta_m_rad) < FAR_RAD) {
        sines(sine);
    } else {
        for (int k = 0; k < LINES; k++) {
            sine[k] = sin(sine[k]);
        }
    }
    double sum = 0.0;
    for (int k = 0; k < LINES; k++) {
        sum -= p[3 * k + 1] * sine[k];
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
