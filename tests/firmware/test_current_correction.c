/* firmware/app/current_correction.c and its share of current_isr.c: which currents the drive calculates with, which it trips by, and when
 * it learns. That what it learns is right: tests/control/motor/test_current_error.c, and tools/tests/test_current_correction.py. */
#include "firmware/app/internal.h"
#include "firmware/app/telemetry.h"
#include "mock_hal_clock.h"
#include "mock_hal_encoder.h"
#include "mock_hal_inverter.h"
#include "mock_hal_limits.h"
#include "mock_hal_sample.h"
#include "tests/firmware/support/bench.h"

void setUp(void) { bench_start(); }
void tearDown(void) {}

static drive_params_t with_errors(drive_correction_word_t word, uint16_t sensors)
{
    drive_params_t p = bench_params();
    p.current_correction = (uint16_t)word;
    p.current_sensors = sensors;
    p.current_offset_a_a = 0.2f;
    p.current_offset_b_a = -0.1f;
    p.current_gain_a = 1.1f;
    p.current_gain_b = 0.9f;
    if (sensors == 1U) {
        p.current_offset_c_a = 0.05f;
        p.current_gain_c = 0.95f;
    }
    return p;
}

static void show(double a, double b, double c)
{
    bench.sample.ia_a = (float)a;
    bench.sample.ib_a = (float)b;
    bench.sample.ic_a = (float)c;
}

/* What the loops see, in A: a vector at electrical angle 0. */
static void assert_seen(double a, double b, double c, const char *text)
{
    TEST_ASSERT_DOUBLE_WITHIN_MESSAGE(2e-6, a, (double)drive.ia_a, text);
    TEST_ASSERT_DOUBLE_WITHIN_MESSAGE(2e-6, b, (double)drive.ib_a, text);
    TEST_ASSERT_DOUBLE_WITHIN_MESSAGE(2e-6, c, (double)drive.ic_a, text);
    TEST_ASSERT_DOUBLE_WITHIN_MESSAGE(5e-6, (2.0 * a - b - c) / 3.0, (double)telemetry_read(&drive, SIGNAL_id_a), text);
    TEST_ASSERT_DOUBLE_WITHIN_MESSAGE(5e-6, (b - c) / SQRT3, (double)telemetry_read(&drive, SIGNAL_iq_a), text);
}

void test_current_correction_off_leaves_the_currents_whatever_the_offsets_say(void)
{
    const drive_params_t p = with_errors(DRIVE_CORRECTION_OFF, 1U);
    bench_run_with(&p);
    show(1.0, 2.0, -2.9);
    bench_period();
    assert_seen(1.0, 2.0, -2.9, "off");
    TEST_ASSERT_EQUAL_FLOAT(0.0f, telemetry_read(&drive, SIGNAL_current_offset_a_a));
    TEST_ASSERT_EQUAL_FLOAT(1.0f, telemetry_read(&drive, SIGNAL_current_gain_b));
}

void test_current_correction_takes_off_what_the_parameters_say(void)
{
    drive_params_t p = with_errors(DRIVE_CORRECTION_FIXED, 0U);
    bench_run_with(&p);
    show(1.3, 1.7, -3.0);
    bench_period();
    assert_seen(1.0, 2.0, -3.0, "two sensors: the third follows from the others");

    bench_start();
    p = with_errors(DRIVE_CORRECTION_FIXED, 1U);
    bench_run_with(&p);
    show(1.3, 1.7, -2.8);
    bench_period();
    assert_seen(1.0, 2.0, -3.0, "three sensors");
    TEST_ASSERT_EQUAL_FLOAT(0.2f, telemetry_read(&drive, SIGNAL_current_offset_a_a));
    TEST_ASSERT_FLOAT_WITHIN(1e-6f, 0.95f, telemetry_read(&drive, SIGNAL_current_gain_c));
}

/* A wrong correction must not make the trip blind. */
void test_current_correction_does_not_move_the_trip(void)
{
    const drive_params_t p = with_errors(DRIVE_CORRECTION_FIXED, 0U);
    bench_run_with(&p);
    show(19.9, -18.0, -1.9); /* phase b: 18 A would be 19.9 A */
    bench_period();
    TEST_ASSERT_EQUAL_INT(DRIVE_RUN, drive.state);
    show(3.0, -19.9, 16.9); /* 22 A */
    bench_period();
    TEST_ASSERT_EQUAL_INT(DRIVE_RUN, drive.state);
    show(20.1, -10.0, -10.1); /* 18.1 A */
    bench_period();
    TEST_ASSERT_EQUAL_INT(FAULT_over_current, drive.fault);
}

void test_current_correction_changes_at_rest_only_and_acts_with_the_next_run(void)
{
    drive_params_t p = bench_params();
    bench_run_with(&p);
    uint16_t culprit = 0U;
    p = with_errors(DRIVE_CORRECTION_FIXED, 0U);
    TEST_ASSERT_FALSE(drive_tune(&drive, &p, &culprit));
    TEST_ASSERT_EQUAL_UINT16(PARAM_current_correction, culprit);
    drive_stop(&drive);
    bench_live(20U);
    TEST_ASSERT_TRUE(drive_tune(&drive, &p, &culprit));
    bench_live(20U);
    drive_start(&drive);
    bench_live(20U);
    TEST_ASSERT_EQUAL_INT(DRIVE_RUN, drive.state);
    show(1.3, 1.7, -3.0);
    bench_period();
    assert_seen(1.0, 2.0, -3.0, "after a change at rest");
}

void test_current_correction_refuses_what_cannot_act(void)
{
    const struct {
        uint16_t param;
        float    value;
        uint16_t culprit;
    } row[] = {
        {PARAM_current_offset_a_a, 1.01f, PARAM_current_offset_a_a}, {PARAM_current_offset_b_a, -1.01f, PARAM_current_offset_b_a},
        {PARAM_current_gain_a, 1.21f, PARAM_current_gain_a},         {PARAM_current_gain_c, 0.79f, PARAM_current_gain_c},
        {PARAM_current_gain_c, 0.99f, PARAM_current_sensors},        {PARAM_current_offset_c_a, 0.01f, PARAM_current_sensors},
        {PARAM_motor_resistance_ohm, 0.0f, PARAM_current_correction}};
    for (size_t k = 0; k < COUNT_OF(row); k++) {
        drive_params_t p = with_errors(DRIVE_CORRECTION_LEARNED, 0U);
        TEST_ASSERT_EQUAL_UINT16(PARAM_COUNT, drive_make_setup(&p, &drive.set[0].setup));
        TEST_ASSERT_TRUE(params_set(&p, row[k].param, row[k].value));
        TEST_ASSERT_EQUAL_UINT16_MESSAGE(row[k].culprit, drive_make_setup(&p, &drive.set[0].setup), at("row %u", (unsigned)k));
    }
}

/* ---- learning ------------------------------------------------------------------------------------------------------------- */

/* The shaft turns with 25 turns a second, 100 samples an electrical turn; phase a shows 0.3 A too much. */
static void turn(uint32_t periods)
{
    static double theta;
    for (uint32_t k = 0U; k < periods; k++) {
        theta += TWO_PI / 400.0;
        bench_angle(theta);
        bench_currents(0.0, 3.0, 4.0 * theta);
        bench.sample.ia_a += 0.3f;
        bench.sample.ic_a -= 0.3f;
        bench_live(1U);
        if ((k % 10U) == 9U) {
            drive_background(&drive);
        }
    }
}

void test_current_correction_learns_an_offset_while_it_runs_and_keeps_it_over_a_stop(void)
{
    drive_params_t p = bench_params();
    p.current_correction = (uint16_t)DRIVE_CORRECTION_LEARNED;
    bench_run_with(&p);
    bench_command(DRIVE_MODE_CURRENT, 0.0, 0.0, 3.0);
    turn(1000U);
    const float learned = telemetry_read(&drive, SIGNAL_current_offset_a_a);
    TEST_ASSERT_TRUE_MESSAGE(learned > 0.05f, at("%g A", (double)learned));
    TEST_ASSERT_EQUAL_FLOAT((float)CTL_CURRENT_ERROR_LEARNS, telemetry_read(&drive, SIGNAL_current_learning));
    drive_stop(&drive);
    turn(1000U);
    TEST_ASSERT_EQUAL_INT(DRIVE_READY, drive.state);
    TEST_ASSERT_EQUAL_FLOAT(learned, telemetry_read(&drive, SIGNAL_current_offset_a_a));
    drive_start(&drive);
    turn(60U);
    TEST_ASSERT_EQUAL_INT(DRIVE_RUN, drive.state);
    TEST_ASSERT_EQUAL_FLOAT(learned, telemetry_read(&drive, SIGNAL_current_offset_a_a));
}

void test_current_correction_does_not_learn_when_it_is_fixed_or_a_sample_is_missing_in_every_turn(void)
{
    for (int lost = 0; lost < 2; lost++) {
        bench_start();
        drive_params_t p = bench_params();
        p.current_correction = (uint16_t)((lost != 0) ? DRIVE_CORRECTION_LEARNED : DRIVE_CORRECTION_FIXED);
        bench_run_with(&p);
        bench_command(DRIVE_MODE_CURRENT, 0.0, 0.0, 3.0);
        for (int k = 0; k < 20; k++) {
            turn(70U);
            bench.sample.seq += (lost != 0) ? 1U : 0U;
        }
        TEST_ASSERT_EQUAL_INT(DRIVE_RUN, drive.state);
        TEST_ASSERT_EQUAL_FLOAT(0.0f, telemetry_read(&drive, SIGNAL_current_offset_a_a));
    }
}
