#include <math.h>

#include "sim_host/plant/effect.h"

#define PHASES 3
#define SWEEPS 8        /* over the phases, which their star point ties together; each leaves a third of the error at most */
#define SETTLED 1e-9    /* of the link voltage: no further sweep */
#define NEAR 1.34       /* of what all legs at a rail may move a current: from so near it may come to zero */
#define CHANGES_MOST 24 /* of what conducts, within a step: 12 by the gates, the rest by currents that end */
#define SOFT_LEAST 0.1  /* of what the loss moves in a step: a softer sign than this differs from a hard one */
#define SOFT_PARTS 4    /* of a step with a soft sign */

enum { DEAD_TIME_S, SOFT_A, BY_EDGES };

/* ---- straight lines ---------------------------------------------------------------------------------------------- */

/* The legs over one step, in shares of the link voltage, and the currents, straight lines while nothing changes.
 * Average inverter: a leg is `loss` below its duty with current out of it, above it with current into it.
 * Edges: pulses in the middle of the period; while both switches are off a diode puts current out of the leg on the lower
 * rail, current into it on the upper one. The whole dead time of an edge belongs to the step that the edge is in.
 * Without current a leg floats between the two: a current that cannot leave zero stays there instead of chattering. */
typedef struct {
    bool   edges;
    double from_s, until_s; /* with the dead time of the last edge */
    double amps;            /* per second and share of the link voltage */
    double duty[PHASES], mean[PHASES] /* over the star point */, slope_a_per_s[PHASES], begin_a[PHASES];
    double loss;
    double rise_s[PHASES], fall_s[PHASES];           /* as commanded */
    double rise_dead_s[PHASES], fall_dead_s[PHASES]; /* 0: an edge of another step */
} legs_t;

static bool is_within(const sim_bridge_t *bridge, double t_s)
{
    return (t_s > 0.0) && (t_s * bridge->pwm_hz < 1.0) && (t_s >= bridge->from_s) && (t_s < bridge->from_s + bridge->length_s);
}

static legs_t make_legs(double dead_time_s, const sim_bridge_t *bridge, const double v_abc_v[PHASES], bool edges)
{
    const double half_s = 0.5 / bridge->pwm_hz;
    const double star_v = (v_abc_v[0] + v_abc_v[1] + v_abc_v[2]) / PHASES;
    legs_t       x = {.edges = edges,
                      .from_s = bridge->from_s,
                      .until_s = bridge->from_s + bridge->length_s + (edges ? dead_time_s : 0.0),
                      .amps = bridge->inverse_h * bridge->dc_link_v,
                      .loss = dead_time_s * bridge->pwm_hz};
    for (int k = 0; k < PHASES; k++) {
        x.duty[k] = v_abc_v[k] / bridge->dc_link_v;
        x.mean[k] = (v_abc_v[k] - star_v) / bridge->dc_link_v;
        x.begin_a[k] = bridge->begin_a[k];
        x.slope_a_per_s[k] = (bridge->end_a[k] - bridge->begin_a[k]) / bridge->length_s;
        x.rise_s[k] = half_s * (1.0 - x.duty[k]);
        x.fall_s[k] = half_s * (1.0 + x.duty[k]);
        x.rise_dead_s[k] = is_within(bridge, x.rise_s[k]) ? dead_time_s : 0.0;
        x.fall_dead_s[k] = is_within(bridge, x.fall_s[k]) ? dead_time_s : 0.0;
    }
    return x;
}

/* Commanded time on the upper rail. */
static double commanded_s(const legs_t *x, int k, double from_s, double until_s)
{
    if (!x->edges) {
        return x->duty[k] * (until_s - from_s);
    }
    const double from = (x->rise_s[k] > from_s) ? x->rise_s[k] : from_s;
    const double until = (x->fall_s[k] < until_s) ? x->fall_s[k] : until_s;
    return (until > from) ? until - from : 0.0;
}

/* Current of phase @p k at @p t_s without any loss in this step: mean and ripple. */
static double current_a(const legs_t *x, int k, double t_s)
{
    const double others_s = commanded_s(x, (k + 1) % PHASES, 0.0, t_s) + commanded_s(x, (k + 2) % PHASES, 0.0, t_s);
    const double ripple_s = (2.0 * commanded_s(x, k, 0.0, t_s) - others_s) / 3.0 - x->mean[k] * t_s;
    return x->begin_a[k] + x->slope_a_per_s[k] * (t_s - x->from_s) + x->amps * ripple_s;
}

/* Between which voltages the current chooses. */
static void leg_range(const legs_t *x, int k, double t_s, double *low, double *high)
{
    if (!x->edges) {
        *low = x->duty[k] - x->loss;
        *high = x->duty[k] + x->loss;
        return;
    }
    const bool on = (t_s >= x->rise_s[k] + x->rise_dead_s[k]) && (t_s < x->fall_s[k]);
    const bool off = (t_s < x->rise_s[k]) || (t_s >= x->fall_s[k] + x->fall_dead_s[k]);
    *low = on ? 1.0 : 0.0;
    *high = off ? 0.0 : 1.0;
}

static double sooner(double t_s, double until_s, double from_s) { return ((t_s > from_s) && (t_s < until_s)) ? t_s : until_s; }

static double next_edge_s(const legs_t *x, double t_s)
{
    double next_s = x->until_s;
    for (int k = 0; x->edges && (k < PHASES); k++) {
        next_s = sooner(x->rise_s[k], next_s, t_s);
        next_s = sooner(x->rise_s[k] + x->rise_dead_s[k], next_s, t_s);
        next_s = sooner(x->fall_s[k], next_s, t_s);
        next_s = sooner(x->fall_s[k] + x->fall_dead_s[k], next_s, t_s);
    }
    return next_s;
}

/* Voltages of the legs; one without current takes that which keeps it so, if it can. */
static void leg_voltages(const double low[PHASES], const double high[PHASES], const double i_a[PHASES], const double back[PHASES],
                         double share[PHASES])
{
    bool floats = false;
    for (int k = 0; k < PHASES; k++) {
        share[k] = (i_a[k] > 0.0) ? low[k] : ((i_a[k] < 0.0) ? high[k] : 0.5 * (low[k] + high[k]));
        floats = floats || ((i_a[k] == 0.0) && (low[k] < high[k]));
    }
    for (int n = 0; floats && (n < SWEEPS); n++) {
        floats = false;
        for (int k = 0; k < PHASES; k++) {
            if (i_a[k] == 0.0) { /* wanted: share - mean of all three = back */
                const double wanted = 1.5 * back[k] + 0.5 * (share[(k + 1) % PHASES] + share[(k + 2) % PHASES]);
                const double can = (wanted < low[k]) ? low[k] : ((wanted > high[k]) ? high[k] : wanted);
                floats = floats || (fabs(can - share[k]) > SETTLED);
                share[k] = can;
            }
        }
    }
}

/* The step from one change of what conducts to the next. @p gained_s: by which the legs are longer on the upper rail than commanded. */
static void follow_lines(const legs_t *x, double gained_s[PHASES])
{
    double t_s = x->from_s;
    double i_a[PHASES];
    double back[PHASES]; /* what a winding holds against its voltage */
    for (int k = 0; k < PHASES; k++) {
        i_a[k] = current_a(x, k, t_s);
        back[k] = x->mean[k] - x->slope_a_per_s[k] / x->amps;
        gained_s[k] = -commanded_s(x, k, t_s, x->until_s);
    }
    for (int n = 0; (n < CHANGES_MOST) && (t_s < x->until_s); n++) {
        double low[PHASES];
        double high[PHASES];
        double share[PHASES];
        double slope[PHASES];
        for (int k = 0; k < PHASES; k++) {
            leg_range(x, k, t_s, &low[k], &high[k]);
        }
        leg_voltages(low, high, i_a, back, share);
        const double star = (share[0] + share[1] + share[2]) / PHASES;
        double       next_s = next_edge_s(x, t_s);
        int          ends = -1;
        for (int k = 0; k < PHASES; k++) {
            slope[k] = x->amps * (share[k] - star - back[k]);
            if ((low[k] < high[k]) && (i_a[k] * slope[k] < 0.0) && (t_s - i_a[k] / slope[k] < next_s)) {
                next_s = t_s - i_a[k] / slope[k];
                ends = k;
            }
        }
        for (int k = 0; k < PHASES; k++) {
            const bool floats = (i_a[k] == 0.0) && (share[k] > low[k]) && (share[k] < high[k]);
            i_a[k] = ((k == ends) || floats) ? 0.0 : i_a[k] + slope[k] * (next_s - t_s);
            gained_s[k] += share[k] * (next_s - t_s);
        }
        t_s = next_s;
    }
}

/* ---- average over the period ------------------------------------------------------------------------------------- */

/* The hyperbolic tangent within 0.024, and 1 beyond 3; and its slope. */
static double soft_sign(double x, double *slope)
{
    if (fabs(x) >= 3.0) {
        *slope = 0.0;
        return copysign(1.0, x);
    }
    const double x2 = x * x;
    const double part = 1.0 / (3.0 + x2);
    *slope = (9.0 - x2) * (9.0 - x2) * part * part / 9.0;
    return x * (27.0 + x2) * part / 9.0;
}

/* Linearly implicit steps: each takes the soft sign halfway to its end, along the line that it has at its start. */
static void soft_loss(const legs_t *x, double soft_a, double gained_s[PHASES])
{
    const double part_s = (x->until_s - x->from_s) / SOFT_PARTS;
    const double loss_a = x->loss * x->amps * part_s;
    double       i_a[PHASES] = {x->begin_a[0], x->begin_a[1], x->begin_a[2]};
    for (int n = 0; n < SOFT_PARTS; n++) {
        double fixed[PHASES]; /* current at the end = (fixed + mean) * share, the mean of all losses being such that */
        double share[PHASES]; /* the currents have no sum */
        double sum = 0.0;
        double shares = 0.0;
        for (int k = 0; k < PHASES; k++) {
            double       slope;
            const double sign = soft_sign(i_a[k] / soft_a, &slope);
            const double steep = 0.5 * loss_a * slope / soft_a;
            share[k] = 1.0 / (1.0 + steep);
            fixed[k] = i_a[k] * (1.0 + steep) + x->slope_a_per_s[k] * part_s - loss_a * sign;
            sum += fixed[k] * share[k];
            shares += share[k];
        }
        const double mean_a = -sum / shares;
        for (int k = 0; k < PHASES; k++) {
            const double end_a = (fixed[k] + mean_a) * share[k];
            gained_s[k] -= (i_a[k] + x->slope_a_per_s[k] * part_s - end_a) / x->amps; /* less the mean, which no current sees */
            i_a[k] = end_a;
        }
    }
}

static void average_gain(const double *p, const sim_bridge_t *bridge, const double v_abc_v[PHASES], double gained_s[PHASES])
{
    const double loss_s = p[DEAD_TIME_S] * bridge->pwm_hz * bridge->length_s;
    const double reach_a = loss_s * bridge->inverse_h * bridge->dc_link_v;
    const double near_a = NEAR * reach_a + 3.0 * p[SOFT_A];
    bool         near = false;
    for (int k = 0; k < PHASES; k++) {
        const double begin_a = bridge->begin_a[k];
        const double end_a = bridge->end_a[k];
        gained_s[k] = -copysign(loss_s, end_a);
        near = near || (fabs(end_a) < near_a) || (fabs(begin_a) < near_a) || (end_a * begin_a < 0.0);
    }
    if (!near) {
        return;
    }
    const legs_t x = make_legs(p[DEAD_TIME_S], bridge, v_abc_v, false);
    if (p[SOFT_A] > SOFT_LEAST * reach_a) {
        gained_s[0] = gained_s[1] = gained_s[2] = 0.0;
        soft_loss(&x, p[SOFT_A], gained_s);
    } else {
        follow_lines(&x, gained_s);
    }
}

/* ---- edge by edge ------------------------------------------------------------------------------------------------ */

/* Each edge waits or not by the current that flows at this very moment, ripple and all: while the ripple is larger than
 * the mean current both edges of a pulse wait, or neither, and nothing is lost. */
static void edge_gain(const double *p, const sim_bridge_t *bridge, const double v_abc_v[PHASES], double gained_s[PHASES])
{
    const legs_t x = make_legs(p[DEAD_TIME_S], bridge, v_abc_v, true);
    const double near_a = NEAR * x.amps * p[DEAD_TIME_S];
    bool         near = false;
    for (int k = 0; k < PHASES; k++) {
        gained_s[k] = 0.0;
        if (x.rise_dead_s[k] > 0.0) {
            const double i_a = current_a(&x, k, x.rise_s[k]);
            gained_s[k] -= (i_a > 0.0) ? x.rise_dead_s[k] : 0.0;
            near = near || (fabs(i_a) < near_a);
        }
        if (x.fall_dead_s[k] > 0.0) {
            const double i_a = current_a(&x, k, x.fall_s[k]);
            gained_s[k] += (i_a < 0.0) ? x.fall_dead_s[k] : 0.0;
            near = near || (fabs(i_a) < near_a);
        }
    }
    if (near) {
        follow_lines(&x, gained_s);
    }
}

static void phase_voltage(const double *p, const sim_bridge_t *bridge, double v_abc_v[3])
{
    double average_s[PHASES] = {0.0, 0.0, 0.0};
    double edges_s[PHASES] = {0.0, 0.0, 0.0};
    if (!(p[DEAD_TIME_S] > 0.0) || !(bridge->dc_link_v > 0.0)) {
        return;
    }
    if (p[BY_EDGES] < 1.0) {
        average_gain(p, bridge, v_abc_v, average_s);
    }
    if (p[BY_EDGES] > 0.0) {
        edge_gain(p, bridge, v_abc_v, edges_s);
    }
    for (int k = 0; k < PHASES; k++) {
        v_abc_v[k] += (average_s[k] + p[BY_EDGES] * (edges_s[k] - average_s[k])) / bridge->length_s * bridge->dc_link_v;
    }
}

const sim_effect_t effect_dead_time = {
    .name = "dead_time",
    .acts_on = "inverter",
    .doc = "Dead time of the bridge: average volt-second loss that opposes each phase current. By edges it is the loss at each "
           "edge, as the current "
           "of that moment has it, ripple and all: none while the ripple is larger than the current.",
    .signature = "Voltage offset that follows the signs of the phase currents, sixth electrical order at low speed, step at zero "
                 "in the voltage-current curve.",
    .confused_with = {"winding_resistance", "flux_harmonics"},
    .shown_by = {{"standstill_steps", "small and large, low speed under load"}},
    .told_apart = "The offset saturates with current where a resistance grows; its 6e is constant over speed.",
    .param_count = 3,
    .param =
        {
            {"dead_time_s", "s", "Dead time per edge pair.", 0.0, 0.0, 2e-05, SIM_AMPLITUDE, 1e-6},
            {"soft_a", "A", "The average loss goes with tanh(i / soft_a); 0: with the sign of i.", 0.0, 0.0, 1000.0, SIM_DETAIL,
             0.05},
            {"by_edges", "", "0: average loss over the period; 1: at each edge; between: a mixture.", 0.0, 0.0, 1.0, SIM_DETAIL,
             0.0},
        },
    .phase_voltage = phase_voltage,
};
