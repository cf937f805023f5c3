/* The referee as Python calls it. */
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <unity.h>

#include "sim_host/referee/referee.h"
#include "tests/sim_host/referee/support/defaults.h"

enum { PERIODS = 10000, SIGNALS = 32 };

static referee_parameters_t   p;
static double                 speed_ref[PERIODS], none[PERIODS], load[PERIODS], mode[PERIODS];
static double                 log_rows[PERIODS * SIGNALS];
static const referee_inputs_t INPUTS = {speed_ref, none, none, load, mode};

static size_t column(const char *name)
{
    for (size_t k = 0; k < referee_signal_count(); k++) {
        if (strcmp(referee_signal_name(k), name) == 0) {
            return k;
        }
    }
    TEST_FAIL_MESSAGE(name);
    return 0;
}

static double last(const char *name, size_t rows) { return log_rows[((rows - 1U) * referee_signal_count()) + column(name)]; }

void setUp(void)
{
    p = plain_motor();
    p.motor_viscous_nms = 1e-3;
    p.drive_current_kp_v_per_a = 12.0;
    p.drive_current_ki_v_per_as = 2500.0;
    p.drive_speed_kp_a_per_rad_s = 0.16;
    p.drive_speed_ki_a_per_rad = 2.4;
    for (int k = 0; k < PERIODS; k++) {
        speed_ref[k] = 30.0;
        none[k] = 0.0;
        load[k] = (k < PERIODS / 2) ? 0.0 : 0.9;
        mode[k] = 0.0;
    }
}

void tearDown(void) {}

void test_referee_run_reaches_the_speed_with_the_current_that_the_torque_needs(void)
{
    TEST_ASSERT_EQUAL_INT(0, referee_run((const double *)&p, &INPUTS, PERIODS, 5U, log_rows));

    const size_t rows = PERIODS / 5;
    TEST_ASSERT_DOUBLE_WITHIN(0.05, 30.0, last("true_speed_rad_s", rows));
    /* (0.9 + 1e-3 * 30) / (1.5 * 3 * 0.1); v_q = p w psi + R i_q, L i_q w in d */
    TEST_ASSERT_DOUBLE_WITHIN(0.02, 0.93 / 0.45, last("iq_a", rows));
    TEST_ASSERT_DOUBLE_WITHIN(0.1, (90.0 * 0.1) + (0.93 / 0.45), last("vq_v", rows));
    TEST_ASSERT_DOUBLE_WITHIN(0.05, -90.0 * 5e-3 * 0.93 / 0.45, last("vd_v", rows));
}

void test_referee_run_is_the_same_for_the_same_seed_and_another_for_another(void)
{
    static double again[PERIODS * SIGNALS];
    p.sensor_current_noise_a = 0.01;
    const size_t bytes = 100U * referee_signal_count() * sizeof(double);
    referee_run((const double *)&p, &INPUTS, 100U, 1U, log_rows);
    referee_run((const double *)&p, &INPUTS, 100U, 1U, again);
    TEST_ASSERT_EQUAL_INT(0, memcmp(log_rows, again, bytes));
    p.run_seed = 2.0;
    referee_run((const double *)&p, &INPUTS, 100U, 1U, again);
    TEST_ASSERT_NOT_EQUAL_INT(0, memcmp(log_rows, again, bytes));
}

void test_referee_run_extra_delay_shifts_the_answer(void)
{
    for (int k = 0; k < PERIODS; k++) {
        mode[k] = 1.0;
    }
    static double id_ref[PERIODS];
    for (int k = 0; k < PERIODS; k++) {
        id_ref[k] = 2.0;
    }
    const referee_inputs_t step = {speed_ref, id_ref, none, none, mode};
    p.motor_locked = 1.0;
    const size_t id = column("id_a");
    for (int extra = 0; extra < 3; extra++) { /* asked for in 0, acts from 1 + extra, is sampled in 2 + extra */
        p.current_loop_delay_extra_periods = extra;
        referee_run((const double *)&p, &step, 10U, 1U, log_rows);
        TEST_ASSERT_EQUAL_DOUBLE(0.0, log_rows[((size_t)(1 + extra) * referee_signal_count()) + id]);
        TEST_ASSERT_DOUBLE_WITHIN(0.01, 0.475, log_rows[((size_t)(2 + extra) * referee_signal_count()) + id]);
    }
    p.current_loop_delay_extra_periods = 0.5; /* half of a period */
    referee_run((const double *)&p, &step, 10U, 1U, log_rows);
    TEST_ASSERT_DOUBLE_WITHIN(0.01, 0.239, log_rows[(2U * referee_signal_count()) + id]);
}

void test_referee_run_integrator_holds_at_the_limit(void)
{
    p.drive_iq_limit_a = 1.0;
    for (int k = 0; k < PERIODS; k++) {
        load[k] = 0.0;
    }
    referee_run((const double *)&p, &INPUTS, PERIODS, 5U, log_rows);

    double highest = 0.0;
    for (size_t row = 0; row < PERIODS / 5; row++) {
        const double speed = log_rows[(row * referee_signal_count()) + column("true_speed_rad_s")];
        highest = (speed > highest) ? speed : highest;
    }
    TEST_ASSERT_TRUE(highest > 29.0);
    TEST_ASSERT_TRUE(highest < 33.0); /* 50 and more with an integrator that runs on */
}

void test_referee_run_current_mode_clears_the_speed_integrator(void)
{
    mode[9000] = 1.0; /* loaded, settled: the integrator holds 2 A */
    referee_run((const double *)&p, &INPUTS, 9012U, 1U, log_rows);

    const size_t iq = column("iq_ref_a");
    TEST_ASSERT_DOUBLE_WITHIN(0.1, 0.93 / 0.45, log_rows[(8999U * referee_signal_count()) + iq]);
    TEST_ASSERT_DOUBLE_WITHIN(0.0, 0.0, log_rows[(9000U * referee_signal_count()) + iq]);
    TEST_ASSERT_DOUBLE_WITHIN(0.3, 0.0, log_rows[(9010U * referee_signal_count()) + iq]);
}

void test_referee_run_supply_ripple_moves_the_current_and_hides_from_the_slow_sensor(void)
{
    for (int k = 0; k < PERIODS; k++) {
        none[k] = 2.0;
        mode[k] = 1.0;
    }
    p.motor_locked = 1.0;
    p.drive_current_kp_v_per_a = 0.5; /* weak: it leaves what it should suppress */
    p.drive_current_ki_v_per_as = 100.0;
    p.supply_ripple_amplitude_rel = 0.1;
    referee_run((const double *)&p, &INPUTS, PERIODS, 1U, log_rows);

    double s = 0.0;
    double c = 0.0;
    for (size_t k = 5000; k < PERIODS; k++) {
        const double *const row = &log_rows[k * referee_signal_count()];
        s += row[column("id_a")] * sin(2.0 * 3.14159265358979 * 100.0 * (double)k * 1e-4) / 2500.0;
        c += row[column("id_a")] * cos(2.0 * 3.14159265358979 * 100.0 * (double)k * 1e-4) / 2500.0;
        TEST_ASSERT_DOUBLE_WITHIN(0.5, 100.0, row[column("vdc_v")]);
    }
    /* 0.2 V over 1 ohm + 5 mH at 100 Hz, and the controller's 0.5 + 100 / s: |1.5 + j (3.14 - 0.16)| = 3.34 ohm */
    TEST_ASSERT_DOUBLE_WITHIN(0.005, 0.2 / 3.34, hypot(s, c));
}

void test_referee_run_dips_and_bursts_come_at_their_rate(void)
{
    p.supply_dips_depth_rel = 0.3;
    p.supply_dips_rate_hz = 20.0;
    p.supply_dips_length_s = 0.002;
    p.sensor_vdc_filter_s = 1e-4; /* to see them */
    p.torque_bursts_amplitude_nm = 0.5;
    p.torque_bursts_rate_hz = 20.0;
    p.torque_bursts_length_s = 0.002;
    for (int k = 0; k < PERIODS; k++) {
        mode[k] = 1.0;
        load[k] = 0.0;
    }
    referee_run((const double *)&p, &INPUTS, PERIODS, 1U, log_rows);

    int    dips = 0;
    int    bursts = 0;
    double last_v = 100.0;
    double last_w = 0.0;
    double last_step = 0.0;
    for (size_t k = 0; k < PERIODS; k++) {
        const double *const row = &log_rows[k * referee_signal_count()];
        dips += row[column("vdc_v")] < 85.0 && last_v >= 85.0;
        const double step = fabs(row[column("true_speed_rad_s")] - last_w);
        bursts += step > 0.02 && last_step <= 0.02; /* 0.25 N m over 1e-3 kg m2 for 0.1 ms */
        last_v = row[column("vdc_v")];
        last_w = row[column("true_speed_rad_s")];
        last_step = step;
    }
    TEST_ASSERT_INT_WITHIN(12, 20, dips); /* Poisson: 2.7 standard deviations */
    TEST_ASSERT_INT_WITHIN(12, 20, bursts);
}

void test_referee_run_refuses_what_makes_no_sense_and_says_which(void)
{
    p.motor_inertia_kgm2 = 0.0;
    int bad = referee_run((const double *)&p, &INPUTS, 10U, 1U, log_rows);
    TEST_ASSERT_EQUAL_STRING("motor.inertia_kgm2", referee_parameter_name((size_t)bad - 1U));
    p.motor_inertia_kgm2 = 1e-3;
    p.cogging_order = (double)NAN;
    bad = referee_run((const double *)&p, &INPUTS, 10U, 1U, log_rows);
    TEST_ASSERT_EQUAL_STRING("cogging.order", referee_parameter_name((size_t)bad - 1U));
    p.cogging_order = 0.0;
    p.current_loop_delay_extra_periods = 6.5;
    bad = referee_run((const double *)&p, &INPUTS, 10U, 1U, log_rows);
    TEST_ASSERT_EQUAL_STRING("current_loop_delay.extra_periods", referee_parameter_name((size_t)bad - 1U));
    p.current_loop_delay_extra_periods = 0.0;
    p.backlash_load_ratio = 1.0; /* of the total: nothing would be left for the rotor */
    bad = referee_run((const double *)&p, &INPUTS, 10U, 1U, log_rows);
    TEST_ASSERT_EQUAL_STRING("backlash.load_ratio", referee_parameter_name((size_t)bad - 1U));
    TEST_ASSERT_EQUAL_INT(-1, referee_run(NULL, &INPUTS, 10U, 1U, log_rows));
    TEST_ASSERT_EQUAL_INT(-1, referee_run((const double *)&p, &INPUTS, 10U, 0U, log_rows));
}

void test_referee_names_end(void)
{
    TEST_ASSERT_NULL(referee_parameter_name(referee_parameter_count()));
    TEST_ASSERT_NULL(referee_signal_name(referee_signal_count()));
    TEST_ASSERT_TRUE(referee_signal_count() <= SIGNALS);
}
