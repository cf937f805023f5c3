#include "sim_host/referee/bridge.h"

#include <math.h>
#include <stddef.h>

enum { PHASES = 3, MOST_EVENTS = 1 + (4 * PHASES), STEPS_PER_DEAD_TIME = 40 };

static void to_phases(referee_vector_t v, double phase[PHASES])
{
    phase[0] = v.x;
    phase[1] = -0.5 * v.x + (0.5 * REFEREE_SQRT_3 * v.y);
    phase[2] = -0.5 * v.x - (0.5 * REFEREE_SQRT_3 * v.y);
}

static referee_vector_t from_phases(const double phase[PHASES])
{
    return (referee_vector_t){(2.0 * phase[0] - phase[1] - phase[2]) / 3.0, (phase[1] - phase[2]) / REFEREE_SQRT_3};
}

static double clamp(double x, double low, double high) { return (x < low) ? low : ((x > high) ? high : x); }

/* -1..1: the direction of the current, linear within what @p volt changes in one step of @p h_s. */
static double direction(double i_a, double volt_v, double h_s, double l_h)
{
    const double band_a = 1.5 * volt_v * h_s / l_h;
    return (band_a > 0.0) ? clamp(i_a / band_a, -1.0, 1.0) : 0.0;
}

static double dead_time(const referee_machine_t *machine)
{
    return machine->p->dead_time_dead_time_s + machine->p->bridge_residual_dead_time_s;
}

static int steps_in(double length_s, double longest_s) { return 1 + (int)((length_s / longest_s) - 1e-9); }

void referee_bridge_average(referee_machine_t *machine, referee_vector_t wanted_v, double link_v, double load_torque_nm,
                            double t_s, double length_s)
{
    const referee_parameters_t *const p = machine->p;
    const int                         steps = steps_in(length_s, p->run_step_s);
    const double                      h_s = length_s / steps;
    const double                      loss_v = dead_time(machine) * p->bridge_pwm_hz * link_v;
    const double                      soft_a = p->dead_time_soft_a;
    const double                      l_h = machine->l_mean_h;
    const double                      scale = link_v / p->bridge_dc_link_v; /* duties are made with the nominal link */
    for (int n = 0; n < steps; n++) {
        referee_vector_t v = {wanted_v.x * scale, wanted_v.y * scale};
        if (loss_v > 0.0) {
            double phase[PHASES];
            to_phases(machine->i_a, phase);
            for (int k = 0; k < PHASES; k++) {
                const double soft = (soft_a > 0.0) ? tanh(phase[k] / soft_a) : direction(phase[k], loss_v, h_s, l_h);
                phase[k] = -loss_v * soft;
            }
            const referee_vector_t loss = from_phases(phase);
            v.x += loss.x;
            v.y += loss.y;
        }
        referee_machine_step(machine, h_s, v, load_torque_nm, t_s + (n * h_s));
    }
}

/* The pulses of one period: on and off times per phase, and all events sorted. */
typedef struct {
    double on_s[PHASES], off_s[PHASES]; /* commands; equal when the phase does not switch on */
    bool   always_high[PHASES], always_low[PHASES];
    double event_s[MOST_EVENTS];
    int    events;
} pulses_t;

static void add_event(pulses_t *pulses, double t_s, double period_s)
{
    if (t_s <= 0.0 || t_s >= period_s) {
        return;
    }
    int k = pulses->events++;
    while (k > 0 && pulses->event_s[k - 1] > t_s) {
        pulses->event_s[k] = pulses->event_s[k - 1];
        k--;
    }
    pulses->event_s[k] = t_s;
}

static pulses_t make_pulses(referee_vector_t wanted_v, double link_v, double dead_s, double period_s)
{
    double wanted[PHASES];
    to_phases(wanted_v, wanted);
    const double high = fmax(wanted[0], fmax(wanted[1], wanted[2]));
    const double low = fmin(wanted[0], fmin(wanted[1], wanted[2]));
    pulses_t     pulses = {.events = 0};
    for (int k = 0; k < PHASES; k++) {
        const double duty = clamp(0.5 + ((wanted[k] - (0.5 * (high + low))) / link_v), 0.0, 1.0);
        pulses.on_s[k] = 0.5 * (1.0 - duty) * period_s;
        pulses.off_s[k] = 0.5 * (1.0 + duty) * period_s;
        pulses.always_high[k] = duty >= 1.0;
        pulses.always_low[k] = duty <= 0.0;
        if (!pulses.always_high[k] && !pulses.always_low[k]) {
            add_event(&pulses, pulses.on_s[k], period_s);
            add_event(&pulses, pulses.on_s[k] + dead_s, period_s);
            add_event(&pulses, pulses.off_s[k], period_s);
            add_event(&pulses, pulses.off_s[k] + dead_s, period_s);
        }
    }
    add_event(&pulses, 0.5 * period_s, period_s);
    return pulses;
}

/* Voltage of a leg over the lower rail at @p t_s. */
static double leg_voltage(const pulses_t *pulses, int k, double t_s, double dead_s, double link_v, double toward)
{
    if (pulses->always_high[k]) {
        return link_v;
    }
    if (pulses->always_low[k] || t_s < pulses->on_s[k]) {
        return 0.0;
    }
    const double diode_v = 0.5 * link_v * (1.0 - toward); /* out of the leg: the lower diode */
    /* A pulse shorter than the dead time never turns the upper switch on. */
    if (t_s < pulses->off_s[k]) {
        return (t_s < pulses->on_s[k] + dead_s) ? diode_v : link_v;
    }
    return (t_s < pulses->off_s[k] + dead_s) ? diode_v : 0.0;
}

/* Are both switches of a leg off with so little current that it may come to zero and stop there? That wants fine steps. */
static bool any_leg_may_block(const pulses_t *pulses, const referee_machine_t *machine, double t_s, double dead_s, double link_v)
{
    const double far_a = 1.5 * link_v * dead_s / machine->l_mean_h;
    double       current[PHASES];
    to_phases(machine->i_a, current);
    for (int k = 0; k < PHASES; k++) {
        const bool rises = t_s >= pulses->on_s[k] && t_s < pulses->on_s[k] + dead_s;
        const bool falls = t_s >= pulses->off_s[k] && t_s < pulses->off_s[k] + dead_s;
        if ((rises || falls) && fabs(current[k]) < far_a) {
            return true;
        }
    }
    return false;
}

static void edge_by_edge(referee_machine_t *machine, referee_vector_t wanted_v, double link_v, double load_torque_nm, double t_s)
{
    const referee_parameters_t *const p = machine->p;
    const double                      period_s = 1.0 / p->bridge_pwm_hz;
    const double                      dead_s = dead_time(machine);
    const pulses_t                    pulses = make_pulses(wanted_v, p->bridge_dc_link_v, dead_s, period_s);
    double                            from_s = 0.0;
    for (int n = 0; n <= pulses.events; n++) {
        const double until_s = (n < pulses.events) ? pulses.event_s[n] : period_s;
        const double length_s = until_s - from_s;
        if (length_s <= 0.0) {
            continue;
        }
        const double inside_s = 0.5 * (from_s + until_s);
        const bool   fine = any_leg_may_block(&pulses, machine, inside_s, dead_s, link_v);
        const int    steps = steps_in(length_s, fine ? fmin(p->run_step_s, dead_s / STEPS_PER_DEAD_TIME) : p->run_step_s);
        const double h_s = length_s / steps;
        for (int m = 0; m < steps; m++) {
            double current[PHASES];
            double leg[PHASES];
            to_phases(machine->i_a, current);
            for (int k = 0; k < PHASES; k++) {
                const double toward = direction(current[k], link_v, h_s, machine->l_mean_h);
                leg[k] = leg_voltage(&pulses, k, inside_s, dead_s, link_v, toward);
            }
            referee_machine_step(machine, h_s, from_phases(leg), load_torque_nm, t_s + from_s + (m * h_s));
        }
        from_s = until_s;
    }
}

void referee_bridge_period(referee_machine_t *machine, referee_vector_t wanted_v, double link_v, double load_torque_nm,
                           double t_s)
{
    if (machine->p->bridge_edges != 0.0) {
        edge_by_edge(machine, wanted_v, link_v, load_torque_nm, t_s);
    } else {
        referee_bridge_average(machine, wanted_v, link_v, load_torque_nm, t_s, 1.0 / machine->p->bridge_pwm_hz);
    }
}
