/* The dead time of the bridge near zero current, where it is not simply a sign: against steps of 5 ns through the same circuit. */
#include "tests/sim_host/support/machine.h"

#define L_H 2e-3
#define LINK_V 100.0
#define PERIOD_S 1e-4
#define DEAD_S 2e-6 /* 2 V on the average, which move 0.1 A in a period */
#define FINE 20000  /* steps of the circuit in a period */

typedef enum { HARD, SOFT, EDGES } kind_t;

static const double SOFT_A = 0.03;

void setUp(void)
{
    machine_defaults();
    model.resistance_ohm = 1e-4; /* the circuit below has none */
    model.ld_h = model.lq_h = L_H;
    model.dc_link_v = LINK_V;
    model.rotor_locked = 1.0;
    model.psi_wb = 0.1;
    machine_set("dead_time", "dead_time_s", DEAD_S);
}
void tearDown(void) {}

/* -1..1, over the band that one fine step can move. */
static double sign_of(double i_a)
{
    const double band_a = LINK_V / L_H * PERIOD_S / FINE;
    return fmax(-1.0, fmin(1.0, i_a / band_a));
}

/* Leg over the lower rail, link = 1. */
static double leg(kind_t kind, double duty, double i_a, double t_s)
{
    if (kind != EDGES) {
        return duty - DEAD_S / PERIOD_S * ((kind == SOFT) ? tanh(i_a / SOFT_A) : sign_of(i_a));
    }
    const double rise_s = 0.5 * (1.0 - duty) * PERIOD_S;
    const double fall_s = 0.5 * (1.0 + duty) * PERIOD_S;
    const bool   off = ((t_s > rise_s) && (t_s < rise_s + DEAD_S)) || ((t_s > fall_s) && (t_s < fall_s + DEAD_S));
    return off ? 0.5 - 0.5 * sign_of(i_a) : (((t_s > rise_s) && (t_s < fall_s)) ? 1.0 : 0.0);
}

static void fine_period(kind_t kind, const double duty[3], double i_a[3])
{
    const double h_s = PERIOD_S / FINE;
    for (int n = 0; n < FINE; n++) {
        double share[3];
        for (int k = 0; k < 3; k++) {
            share[k] = leg(kind, duty[k], i_a[k], (n + 0.5) * h_s);
        }
        const double star = (share[0] + share[1] + share[2]) / 3.0;
        for (int k = 0; k < 3; k++) {
            i_a[k] += h_s / L_H * LINK_V * (share[k] - star);
        }
    }
}

/* Largest difference of a phase current after one period, over what the full loss moves, for many currents and voltages. */
static double worst_error(kind_t kind, double most_a, double most_v)
{
    double worst = 0.0;
    for (int n = 0; n < 60; n++) { /* no two alike: golden angles */
        const double size_a = most_a * (n + 0.5) / 60.0;
        const double size_v = most_v * ((7 * n) % 60 + 0.5) / 60.0;
        machine_start();
        plant.x.id_a = size_a * cos(2.4 * n);
        plant.x.iq_a = size_a * sin(2.4 * n);
        double i_a[3];
        double duty[3];
        sim_plant_phase_currents(&plant, i_a);
        machine_duties(size_v * cos(1.7 * n), size_v * sin(1.7 * n), duty);
        sim_plant_period(&plant, duty, true);
        fine_period(kind, duty, i_a);
        double got_a[3];
        sim_plant_phase_currents(&plant, got_a);
        for (int k = 0; k < 3; k++) {
            worst = fmax(worst, fabs(got_a[k] - i_a[k]) / (DEAD_S * LINK_V / L_H));
        }
    }
    return worst;
}

/* Of what the full loss moves. Hard: the band of the fine steps, 0.25 mA of 100 mA, and no resistance: exact beyond.
 * Soft: tanh within 0.024 and eight steps a period. */
void test_dead_time_loss_follows_currents_through_zero_within_a_period(void)
{
    TEST_ASSERT_DOUBLE_WITHIN(0.01, 0.0, worst_error(HARD, 0.3, 6.0));
    TEST_ASSERT_DOUBLE_WITHIN(0.01, 0.0, worst_error(HARD, 0.05, 2.0));
}

void test_dead_time_loss_goes_softly_through_zero_when_told_so(void)
{
    machine_set("dead_time", "soft_a", SOFT_A);
    TEST_ASSERT_DOUBLE_WITHIN(0.04, 0.0, worst_error(SOFT, 0.3, 6.0));
    TEST_ASSERT_DOUBLE_WITHIN(0.04, 0.0, worst_error(SOFT, 0.05, 2.0));
    TEST_ASSERT_TRUE(worst_error(HARD, 0.05, 2.0) > 0.2); /* and is not the hard one */
}

void test_dead_time_at_edges_is_that_of_diodes_that_block(void)
{
    machine_set("dead_time", "by_edges", 1.0);
    TEST_ASSERT_DOUBLE_WITHIN(0.03, 0.0, worst_error(EDGES, 0.3, 30.0));
    TEST_ASSERT_DOUBLE_WITHIN(0.03, 0.0, worst_error(EDGES, 0.05, 6.0));
    TEST_ASSERT_TRUE(worst_error(HARD, 0.3, 30.0) > 0.3);
}

/* A rotor that holds 40 V against the 40 V on phase a, so that its current keeps its mean; and that turns by 0.04 rad, half of
 * it before and half after this. @return that current after a period. */
static double held_current_a(double i_a, double dead_s, double by_edges)
{
    model.rotor_locked = 0.0;
    model.inertia_kgm2 = 1e3;
    model.initial_speed_rad_s = 100.0;
    model.initial_angle_rad = (-0.5 * PI - 0.02) / 4.0;
    machine_set("dead_time", "dead_time_s", dead_s);
    machine_set("dead_time", "by_edges", by_edges);
    machine_start();
    plant.x.iq_a = i_a;
    machine_voltage(40.0, 0.0, 1);
    return plant.x.iq_a;
}

static double loss_at_edges_v(double i_a, double dead_s)
{
    return (held_current_a(i_a, 0.0, 0.0) - held_current_a(i_a, dead_s, 1.0)) * L_H / PERIOD_S;
}

/* 40 V on phase a: its pulses take 0.9 of the period, those of b and c 0.3. Where that of a begins, at 5 us, its current is
 * 40 V 5 us / 2 mH = 0.1 A below its mean, where it ends as much above; those of b and c by (33.3 V 30 us - 20 V 35 us) / 2 mH
 * = 0.15 A. Without a mean each flows backwards where its pulse begins, and forwards where it ends: no edge waits.
 * The same with 0.08 A on a and -0.04 A on b and c. Far from zero all three lose 2 V, 4/3 of it on the axis of a. */
void test_dead_time_at_edges_loses_nothing_while_the_ripple_turns_the_current(void)
{
    TEST_ASSERT_DOUBLE_WITHIN(0.02, 4.0 / 3.0 * 2.0, loss_at_edges_v(3.0, DEAD_S));
    TEST_ASSERT_DOUBLE_WITHIN(0.02, 0.0, loss_at_edges_v(0.0, DEAD_S));
    TEST_ASSERT_DOUBLE_WITHIN(0.001, 4.0 / 3.0 * 0.1, loss_at_edges_v(3.0, 0.05 * DEAD_S));
    TEST_ASSERT_DOUBLE_WITHIN(0.001, 0.0, loss_at_edges_v(0.08, 0.05 * DEAD_S)); /* no current ends in so short a time */
}

/* A mixture is one of voltages: half way between the two. */
void test_dead_time_by_edges_mixes_the_two_losses(void)
{
    model.substeps = 1.0;
    const double end_a[3] = {held_current_a(0.05, DEAD_S, 0.0), held_current_a(0.05, DEAD_S, 0.5),
                             held_current_a(0.05, DEAD_S, 1.0)};
    TEST_ASSERT_TRUE(fabs(end_a[2] - end_a[0]) > 0.01);
    TEST_ASSERT_DOUBLE_WITHIN(1e-9, 0.5 * (end_a[0] + end_a[2]), end_a[1]);
}
