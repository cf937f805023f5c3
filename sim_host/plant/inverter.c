/* One PWM period of the bridge: its voltage with the gates on, its diodes with the gates off. */
#include <math.h>
#include <stddef.h>

#include "sim_host/plant/step.h"

#define PIECES_MAX 8 /* zero crossings of speed and currents within one step, and some to spare */

SIM_NOINLINE static void distort(const sim_plant_t *s, double from_s, double h, double v[3])
{
    double inv_d = s->inv_ld;
    double inv_q = s->inv_lq;
    if (s->saturation != NULL) {
        const sim_linkage_t f = sim_linkage(s, &s->x);
        inv_d = f.inv_d;
        inv_q = f.inv_q;
    }
    sim_bridge_t bridge = {.pwm_hz = s->model.pwm_hz,
                           .dc_link_v = s->link_v,
                           .time_s = s->time_s + from_s,
                           .from_s = from_s,
                           .length_s = h,
                           .inverse_h = 0.5 * (inv_d + inv_q)};
    double       ab[2];
    sim_to_alpha_beta(v, ab);
    const sim_step_t  step = sim_step_begin(s, ab);
    const sim_still_t now = sim_stator_view(s, &step);
    sim_to_phases(now.i[0], now.i[1], bridge.begin_a);
    sim_to_phases(now.i[0] + h * now.slope[0], now.i[1] + h * now.slope[1], bridge.end_a);
    for (int k = 0; k < s->voltage_count; k++) {
        s->voltage[k]->effect->phase_voltage(s->voltage[k]->p, &bridge, v);
    }
}

/** Voltage over the next @p h, @p from_s after the start of the period. */
static void bridge_voltage(const sim_plant_t *s, const double duty[3], double from_s, double h, double ab[2])
{
    double v[3] = {duty[0] * s->link_v, duty[1] * s->link_v, duty[2] * s->link_v};
    if (s->voltage_count > 0) {
        distort(s, from_s, h, v);
    }
    sim_to_alpha_beta(v, ab);
}

static void still_currents(const sim_plant_t *s, double ab[2])
{
    ab[0] = s->x.id_a * s->cosine_e - s->x.iq_a * s->sine_e;
    ab[1] = s->x.id_a * s->sine_e + s->x.iq_a * s->cosine_e;
}

SIM_NOINLINE static double piece_from_link(sim_plant_t *s, const double v_ab[2], double h, bool last, double t0_s)
{
    double before[2];
    double now[2];
    still_currents(s, before);
    const double done = sim_step_piece(s, v_ab, h, last, t0_s);
    still_currents(s, now);
    s->link.taken_ws += 1.5 * done * 0.5 * (v_ab[0] * (before[0] + now[0]) + v_ab[1] * (before[1] + now[1]));
    return done;
}

/** sim_step_piece, and what it takes from a dc link that is not stiff. */
static inline double step_piece(sim_plant_t *s, const double v_ab[2], double h, bool last, double t0_s)
{
    return s->link.on ? piece_from_link(s, v_ab, h, last, t0_s) : sim_step_piece(s, v_ab, h, last, t0_s);
}

static void set_phase_currents(sim_plant_t *s, const double i_abc[3])
{
    double ab[2];
    sim_to_alpha_beta(i_abc, ab);
    s->x.id_a = ab[0] * s->cosine_e + ab[1] * s->sine_e;
    s->x.iq_a = ab[1] * s->cosine_e - ab[0] * s->sine_e;
}

/* Back-EMF in the middle of the next h. */
static void back_emf(const sim_plant_t *s, double h, double ab[2])
{
    const double we = s->model.pole_pairs * s->x.speed_rad_s;
    const double angle = s->model.pole_pairs * s->x.theta_m_rad + 0.5 * h * we;
    ab[0] = -we * s->model.psi_wb * sin(angle);
    ab[1] = we * s->model.psi_wb * cos(angle);
}

static double emf_of_phase(const double e[2], int k)
{
    return (k == 0) ? e[0] : 0.5 * (-e[0] + ((k == 1) ? SIM_SQRT3 : -SIM_SQRT3) * e[1]);
}

/** Behind a rectifier the diodes of the bridge do not only end currents, they begin them, too: where the motor's own voltage is larger
 *  than the dc link. A phase that begins gets a current of @p none in the direction that it will have. @return phases that conduct. */
SIM_NOINLINE static int begin_rectifying(const sim_plant_t *s, double h, double none, double i[3])
{
    double e[2];
    double of[3];
    int    high = 0;
    int    low = 0;
    int    conducting = 0;
    back_emf(s, h, e);
    for (int k = 0; k < 3; k++) {
        of[k] = emf_of_phase(e, k);
        high = (of[k] > of[high]) ? k : high;
        low = (of[k] < of[low]) ? k : low;
    }
    if ((i[0] == 0.0) && (i[1] == 0.0) && (i[2] == 0.0) && ((of[high] - of[low]) > s->link_v)) {
        i[high] = -none; /* out of the motor, into the upper rail */
        i[low] = none;
    }
    for (int k = 0; k < 3; k++) {
        conducting += (i[k] != 0.0) ? 1 : 0;
    }
    for (int k = 0; (k < 3) && (conducting == 2);
         k++) { /* two are on different rails: the third floats at 1.5 of its own voltage */
        if ((i[k] == 0.0) && (1.5 * fabs(of[k]) > 0.5 * s->link_v)) {
            i[k] = (of[k] > 0.0) ? -none : none;
        }
    }
    return conducting;
}

/** Gates off: the diode of a phase with current puts it on the rail that opposes this current; a phase without floats. */
static void diode_voltage(const sim_plant_t *s, const double i[3], double h, double ab[2])
{
    double e[2];
    double v[3];
    double conducting = 0.0;
    back_emf(s, h, e);
    for (int k = 0; k < 3; k++) {
        v[k] = (i[k] > 0.0) ? -0.5 * s->link_v : ((i[k] < 0.0) ? 0.5 * s->link_v : 0.0);
        conducting += v[k];
    }
    for (int k = 0; k < 3; k++) {
        if (i[k] == 0.0) {
            v[k] = 0.5 * conducting + 1.5 * emf_of_phase(e, k); /* gives v - mean(v) = emf: its current stays zero */
        }
    }
    sim_to_alpha_beta(v, ab);
}

/** Advance by at most h with the gates off; ends early where the current of a phase passes zero, which then blocks.
 *  (A back-EMF above a dc link that is stiff is not rectified.) @return time done. */
static double freewheel(sim_plant_t *s, double h, bool last, double t0_s)
{
    const double none = 1e-9 * (1.0 + s->model.rated_current_a);
    double       i[3];
    double       ab[2];
    sim_plant_phase_currents(s, i);
    int conducting = 0;
    for (int k = 0; k < 3; k++) {
        i[k] = (fabs(i[k]) > none) ? i[k] : 0.0;
        conducting += (i[k] != 0.0) ? 1 : 0;
    }
    if (s->link.on) {
        conducting = begin_rectifying(s, h, none, i);
    }
    if (conducting < 2) {
        s->x.id_a = 0.0;
        s->x.iq_a = 0.0;
        back_emf(s, h, ab); /* the terminals follow it, and no diode conducts */
        const double done = sim_step_piece(s, ab, h, last, t0_s);
        s->x.id_a = 0.0;
        s->x.iq_a = 0.0;
        return done;
    }
    diode_voltage(s, i, h, ab);

    /* when does the first of them arrive at zero? */
    const double     c = s->cosine_e;
    const double     n = s->sine_e;
    const sim_step_t step = {
        .vd_v = ab[0] * c + ab[1] * n, .vq_v = ab[1] * c - ab[0] * n, .theta0_rad = s->x.theta_m_rad, .stuck = true};
    const sim_still_t still = sim_stator_view(s, &step);
    const double      alpha = still.slope[0];
    const double      beta = still.slope[1];
    const double      di[3] = {alpha, 0.5 * (-alpha + SIM_SQRT3 * beta), 0.5 * (-alpha - SIM_SQRT3 * beta)};
    double            until = h;
    int               first = -1;
    for (int k = 0; k < 3; k++) {
        if ((i[k] * di[k] < 0.0) && (-i[k] / di[k] < until)) {
            until = -i[k] / di[k];
            first = k;
        }
    }
    const double done = step_piece(s, ab, last ? h : until, last, t0_s);

    double after[3];
    sim_plant_phase_currents(s, after);
    int blocked = 0;
    for (int k = 0; k < 3; k++) {
        if ((i[k] == 0.0) || (after[k] * i[k] <= 0.0) || ((k == first) && !last)) {
            after[k] = 0.0;
            blocked++;
        }
    }
    if (blocked > 1) {
        after[0] = after[1] = after[2] = 0.0;
    } else if (blocked == 1) { /* what flows in through one of the others leaves through the last */
        const int    k = (after[0] == 0.0) ? 0 : ((after[1] == 0.0) ? 1 : 2);
        const double through = 0.5 * (after[(k + 1) % 3] - after[(k + 2) % 3]);
        after[(k + 1) % 3] = through;
        after[(k + 2) % 3] = -through;
    }
    set_phase_currents(s, after);
    return done;
}

/* With saturation the slopes of the linkages, and with them R/L, go with the current: steps for the largest to come. */
SIM_NOINLINE static int steps_in(const sim_plant_t *s, double length_s)
{
    const double part = length_s / s->period_s;
    double       need = s->substeps * part;
    if ((s->saturation != NULL) && (s->model.substeps == 0.0)) {
        const double      volt_s = s->link_v / SIM_SQRT3 * length_s;
        const sim_state_t then = {.id_a = fabs(s->x.id_a) + volt_s * s->inv_ld, .iq_a = fabs(s->x.iq_a) + volt_s * s->inv_lq};
        const double      inv_d = 1.0 / sim_slope(s, s->model.ld_h, then.id_a, then.iq_a);
        const double      inv_q = 1.0 / sim_slope(s, s->model.lq_h, then.iq_a, then.id_a);
        const double      decay = s->model.resistance_ohm * ((inv_d > inv_q) ? inv_d : inv_q) * length_s / 0.4;
        need = (decay > need) ? decay : need;
    }
    need = ceil(need);
    return (need < 1.0) ? 1 : ((need > 1000.0) ? 1000 : (int)need);
}

static void open_circuit(sim_plant_t *s, int k)
{
    double i[3];
    sim_plant_phase_currents(s, i);
    const double through = 0.5 * (i[(k + 1) % 3] - i[(k + 2) % 3]);
    i[k] = 0.0;
    i[(k + 1) % 3] = through;
    i[(k + 2) % 3] = -through;
    set_phase_currents(s, i);
}

/** Part of a period with phase k of the motor open: its terminal is where its current stays zero. */
SIM_NOINLINE static void stretch_open(sim_plant_t *s, const double duty[3], int k, double from_s, double length_s, int steps)
{
    const double h = length_s / steps;
    for (int n = 0; n < steps; n++) {
        double v[3] = {duty[0] * s->link_v, duty[1] * s->link_v, duty[2] * s->link_v};
        double e[2];
        double ab[2];
        open_circuit(s, k);
        back_emf(s, h, e);
        v[k] = 0.5 * (v[(k + 1) % 3] + v[(k + 2) % 3]) + 1.5 * emf_of_phase(e, k);
        sim_to_alpha_beta(v, ab);
        double left = h;
        for (int m = 0; (m < PIECES_MAX) && (left > 1e-12 * h); m++) {
            left -= step_piece(s, ab, left, m == PIECES_MAX - 1, from_s + n * h + (h - left));
        }
    }
    open_circuit(s, k);
}

/** Part of a period with constant duties. */
static inline void stretch(sim_plant_t *s, const double duty[3], bool armed, double from_s, double length_s, int steps)
{
    const double h = length_s / steps;
    double       ab[2] = {0.0, 0.0};

    if (armed && (s->outside.open_phase != 0)) {
        stretch_open(s, duty, s->outside.open_phase - 1, from_s, length_s, steps);
        return;
    }
    for (int k = 0; k < steps; k++) {
        if (armed && ((k == 0) || (s->voltage_count > 0))) {
            bridge_voltage(s, duty, from_s - s->time_s + k * h, h, ab);
        }
        double left = h;
        for (int n = 0; (n < PIECES_MAX) && (left > 1e-12 * h); n++) {
            const double t0_s = from_s + k * h + (h - left);
            left -= armed ? step_piece(s, ab, left, n == PIECES_MAX - 1, t0_s) : freewheel(s, left, n >= PIECES_MAX / 2, t0_s);
        }
    }
}

SIM_NOINLINE static void period_with_parts(sim_plant_t *s, const double duty[3], bool armed)
{
    const double change_s = s->delay.part * s->period_s;
    const double rest_s = s->period_s - change_s;
    sim_delay_push(&s->delay, duty);
    if (change_s > 0.0) {
        stretch(s, sim_delay_first(&s->delay), armed, s->time_s, change_s, steps_in(s, change_s));
    }
    stretch(s, sim_delay_second(&s->delay), armed, s->time_s + change_s, rest_s, steps_in(s, rest_s));
}

void sim_plant_period(sim_plant_t *s, const double duty[3], bool armed)
{
    s->link_v = sim_plant_dc_link_v(s);
    if ((s->parts.delay_periods > 0.0) || (s->saturation != NULL)) {
        period_with_parts(s, duty, armed);
    } else {
        stretch(s, duty, armed, s->time_s, s->period_s, s->substeps);
    }
    s->time_s += s->period_s;
    if (s->link.on) {
        sim_plant_end_link_period(s);
    }
    s->vdc_filtered_v += s->vdc_gain * (sim_plant_dc_link_v(s) - s->vdc_filtered_v);
}
