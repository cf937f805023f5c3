#include <math.h>

#include "sim_host/plant/effect.h"

/* Numbers of the effect, in the order of .param. */
enum {
    ODD_NM,
    ODD_EXPONENT,
    EVEN_NM,
    EVEN_EXPONENT,
    LIMIT_RAD_S,
    LINE_1, /* amplitude, order, phase, growth with the speed, turns over */
    LINE_2 = LINE_1 + 5,
    POSITION_NM = LINE_2 + 5,
    POSITION_RAD,
    WIDTH_RAD,
    SPRING_NM,
    SPRING_RAD,
    TRAVEL_RAD,
    TONE_NM,
    TONE_HZ,
    TONE_RAD,
    LOAD_NM,
    FRICTION_NM,
    VISCOUS_NM,
    TIME_S,
    UNTIL_S,
    START_S,
    PARAMETERS
};

#define SOFT 0.002 /* of the limit speed: friction that changes with time goes through zero within this */
#define LINES 2
#define PER_LINE 5
#define TWO_PI 6.283185307179586

/* Speed within what was measured, over its limit: beyond it the torque stays. */
static double bounded(double speed_rad_s, double limit_rad_s)
{
    const double x = speed_rad_s / limit_rad_s;
    return (x > 1.0) ? 1.0 : ((x < -1.0) ? -1.0 : x);
}

/* 0 at the start, towards 1; it stays as it was at the end of what was measured. */
static double warm(const double *p, double time_s)
{
    const double since = time_s + p[START_S];
    const double t = ((p[UNTIL_S] > 0.0) && (since > p[UNTIL_S])) ? p[UNTIL_S] : since;
    return 1.0 - exp(-t / p[TIME_S]);
}

static double lines_nm(const double *p, double theta_rad, double x)
{
    double sum = 0.0;
    for (int k = 0; k < LINES; k++) {
        const double *const line = &p[LINE_1 + PER_LINE * k];
        if (line[0] != 0.0) {
            const double size = (line[3] == 0.0) ? 1.0 : pow(fabs(x), line[3]);
            const double turned = ((line[4] != 0.0) && (x < 0.0)) ? -size : size;
            sum += line[0] * turned * sin(line[1] * theta_rad + line[2]);
        }
    }
    return sum;
}

static double position_nm(const double *p, double theta_rad)
{
    double sum = 0.0;
    if (p[POSITION_NM] != 0.0) {
        const double x = (theta_rad - p[POSITION_RAD]) / p[WIDTH_RAD];
        sum += p[POSITION_NM] * exp(-x * x);
    }
    if (p[SPRING_NM] != 0.0) {
        const double x = (theta_rad - p[SPRING_RAD]) / p[TRAVEL_RAD];
        sum += p[SPRING_NM] * ((x > 0.5) ? 0.5 : ((x < -0.5) ? -0.5 : x));
    }
    return sum;
}

static double torque_nm(const double *p, const sim_shaft_t *shaft)
{
    const double x = bounded(shaft->speed_rad_s, p[LIMIT_RAD_S]);
    double       sum = lines_nm(p, shaft->theta_m_rad, x) + position_nm(p, shaft->theta_m_rad);
    if (p[ODD_NM] != 0.0) {
        sum += copysign(p[ODD_NM] * pow(fabs(x), p[ODD_EXPONENT]), p[ODD_NM] * x);
    }
    if (p[EVEN_NM] != 0.0) {
        sum += p[EVEN_NM] * pow(fabs(x), p[EVEN_EXPONENT]);
    }
    if (p[TONE_NM] != 0.0) {
        sum += p[TONE_NM] * sin(TWO_PI * p[TONE_HZ] * (shaft->time_s + p[START_S]) + p[TONE_RAD]);
    }
    if ((p[LOAD_NM] != 0.0) || (p[FRICTION_NM] != 0.0) || (p[VISCOUS_NM] != 0.0)) {
        const double friction = p[FRICTION_NM] * tanh(shaft->speed_rad_s / (SOFT * p[LIMIT_RAD_S]));
        sum += warm(p, shaft->time_s) * (p[LOAD_NM] + friction + p[VISCOUS_NM] * x);
    }
    return -sum;
}

const sim_effect_t effect_empirical = {
    .name = "empirical",
    .acts_on = "torque",
    .doc =
        "Torque that a log shows and no effect explains, as `evenspin gap` writes it: a few terms over speed, angle, position "
        "and time, against positive rotation. Beyond the speed, travel and time that were measured each stays as it was there.",
    .signature = "That of its terms.",
    .scenario_only = true,
    .param_count = PARAMETERS,
    .param =
        {
            {"odd_nm", "N m", "Drag sign(w) abs(w / limit)^exponent at the limit speed.", 0.0, -10000.0, 10000.0, SIM_AMPLITUDE,
             0.05},
            {"odd_exponent", "", "Exponent of odd_nm.", 2.0, 0.1, 10.0, SIM_QUANTITY, 2.0},
            {"even_nm", "N m", "Torque abs(w / limit)^exponent at the limit speed.", 0.0, -10000.0, 10000.0, SIM_AMPLITUDE, 0.0},
            {"even_exponent", "", "Exponent of even_nm.", 2.0, 0.1, 10.0, SIM_QUANTITY, 2.0},
            {"limit_rad_s", "rad/s", "Speed up to which the terms were measured.", 1.0, 0.001, 100000.0, SIM_QUANTITY, 100.0},
            {"line_1_nm", "N m", "Amplitude of a line over the angle, at the limit speed where it grows.", 0.0, -10000.0, 10000.0,
             SIM_AMPLITUDE, 0.02},
            {"line_1_order", "1/turn", "Cycles per turn, whole or not.", 0.0, 0.0, 10000.0, SIM_ORDER, 3.47},
            {"line_1_phase_rad", "rad", "Phase.", 0.0, -100.0, 100.0, SIM_PHASE, 0.0},
            {"line_1_growth", "", "Power of the speed that the amplitude grows with.", 0.0, 0.0, 10.0, SIM_DETAIL, 0.0},
            {"line_1_turns_over", "", "1: with the sign of the speed.", 0.0, 0.0, 1.0, SIM_DETAIL, 0.0},
            {"line_2_nm", "N m", "Amplitude of a second line.", 0.0, -10000.0, 10000.0, SIM_AMPLITUDE, 0.0},
            {"line_2_order", "1/turn", "Cycles per turn of the second line.", 0.0, 0.0, 10000.0, SIM_ORDER, 6.94},
            {"line_2_phase_rad", "rad", "Phase of the second line.", 0.0, -100.0, 100.0, SIM_PHASE, 0.0},
            {"line_2_growth", "", "Power of the speed that the second amplitude grows with.", 0.0, 0.0, 10.0, SIM_DETAIL, 0.0},
            {"line_2_turns_over", "", "1: the second line has the sign of the speed.", 0.0, 0.0, 1.0, SIM_DETAIL, 0.0},
            {"position_nm", "N m", "Load at a position of the travel.", 0.0, -10000.0, 10000.0, SIM_AMPLITUDE, 0.0},
            {"position_rad", "rad", "Where, from the start of the encoder.", 0.0, -1e7, 1e7, SIM_QUANTITY, 50.0},
            {"width_rad", "rad", "exp(-x^2) falls to 1 / e this far away.", 1.0, 1e-3, 1e7, SIM_QUANTITY, 10.0},
            {"spring_nm", "N m", "Load that grows evenly by this over the travel.", 0.0, -10000.0, 10000.0, SIM_AMPLITUDE, 0.0},
            {"spring_rad", "rad", "Middle of the travel.", 0.0, -1e7, 1e7, SIM_QUANTITY, 0.0},
            {"travel_rad", "rad", "Length of the travel.", 1.0, 1e-3, 1e7, SIM_QUANTITY, 100.0},
            {"tone_nm", "N m", "Torque of a fixed frequency.", 0.0, -10000.0, 10000.0, SIM_AMPLITUDE, 0.0},
            {"tone_hz", "Hz", "Its frequency.", 0.0, 0.0, 2000.0, SIM_QUANTITY, 19.0},
            {"tone_rad", "rad", "Its phase at the start.", 0.0, -100.0, 100.0, SIM_PHASE, 0.0},
            {"load_nm", "N m", "Load that builds up with time.", 0.0, -10000.0, 10000.0, SIM_AMPLITUDE, 0.0},
            {"friction_nm", "N m", "Dry friction that builds up with time; may fall below what other effects have.", 0.0,
             -10000.0, 10000.0, SIM_AMPLITUDE, 0.0},
            {"viscous_nm", "N m", "Viscous friction at the limit speed that builds up with time.", 0.0, -10000.0, 10000.0,
             SIM_AMPLITUDE, 0.0},
            {"time_s", "s", "Time constant of what changes with time.", 1.0, 1e-3, 1e6, SIM_QUANTITY, 20.0},
            {"until_s", "s", "Time up to which it was measured; 0: no end.", 0.0, 0.0, 1e7, SIM_DETAIL, 0.0},
            {"start_s", "s", "Time of the log at which a run starts.", 0.0, 0.0, 1e7, SIM_DETAIL, 0.0},
        },
    .torque_nm = torque_nm,
};
