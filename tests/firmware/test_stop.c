/* firmware/app/stop.c: how a run ends; the shaft of the bench rests unless it is turned. */
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

static drive_params_t stopped_by(drive_stop_word_t how)
{
    drive_params_t p = bench_params();
    p.stop_action = (uint16_t)how;
    p.over_speed_rad_s = 100.0f; /* at which this motor shorted is no danger: 2.56 V over 0.37 ohm, and 10 A */
    p.profile_speed_rad_s = 1.0f;
    return p;
}

static void run(drive_stop_word_t how)
{
    const drive_params_t p = stopped_by(how);
    bench_run_with(&p);
    bench_command(DRIVE_MODE_SPEED, 5.0, 0.0, 0.0);
    bench_live(100U);
}

void test_stop_coast_is_off_in_the_next_pass(void)
{
    run(DRIVE_STOP_COAST);
    drive_stop(&drive);
    drive_background(&drive);
    TEST_ASSERT_EQUAL_INT(DRIVE_READY, drive.state);
    TEST_ASSERT_FALSE(bench.armed);
}

/* 20 ms at rest, then off; the command of before is there again */
void test_stop_ramp_holds_speed_zero_until_the_shaft_rests_and_keeps_the_command(void)
{
    run(DRIVE_STOP_RAMP);
    drive_stop(&drive);
    bench_live(150U);
    TEST_ASSERT_EQUAL_INT(DRIVE_RUN, drive.state);
    TEST_ASSERT_TRUE(bench.armed);
    TEST_ASSERT_EQUAL_FLOAT(0.0f, telemetry_read(&drive, SIGNAL_speed_ref_rad_s));
    bench_command(DRIVE_MODE_SPEED, 7.0, 0.0, 0.0); /* does not end the stop */
    bench_live(40U);
    TEST_ASSERT_EQUAL_INT(DRIVE_RUN, drive.state);
    TEST_ASSERT_EQUAL_FLOAT(0.0f, telemetry_read(&drive, SIGNAL_speed_ref_rad_s));
    bench_live(40U);
    TEST_ASSERT_EQUAL_INT(DRIVE_READY, drive.state);
    TEST_ASSERT_FALSE(bench.armed);
    TEST_ASSERT_EQUAL_FLOAT(7.0f, drive_newest_command(&drive)->speed_ref_rad_s);
    drive_background(&drive);
    ASSERT_NO_FAULT("and the memory check agrees");
    bench_live(100U);
    TEST_ASSERT_EQUAL_INT(DRIVE_READY, drive.state); /* the start of before is used up */
}

void test_stop_short_closes_the_lower_switches_alone(void)
{
    run(DRIVE_STOP_SHORT);
    drive_stop(&drive);
    bench_periods(1U);
    TEST_ASSERT_EQUAL_INT(DRIVE_SHORT, drive.state);
    TEST_ASSERT_TRUE(bench.armed);
    TEST_ASSERT_EQUAL_FLOAT(0.0f, bench.duty.a);
    TEST_ASSERT_EQUAL_FLOAT(0.0f, bench.duty.b);
    TEST_ASSERT_EQUAL_FLOAT(0.0f, bench.duty.c);
    bench_live(150U);
    TEST_ASSERT_EQUAL_INT(DRIVE_SHORT, drive.state);
    bench_live(80U);
    TEST_ASSERT_EQUAL_INT(DRIVE_READY, drive.state);
    TEST_ASSERT_FALSE(bench.armed);
    bench_periods(1U);
    TEST_ASSERT_EQUAL_FLOAT(0.5f, bench.duty.a);
    ASSERT_NO_FAULT("after a short");
}

void test_stop_a_second_time_is_off_at_once(void)
{
    const drive_stop_word_t how[] = {DRIVE_STOP_RAMP, DRIVE_STOP_SHORT};
    for (size_t k = 0; k < COUNT_OF(how); k++) {
        setUp();
        run(how[k]);
        drive_stop(&drive);
        bench_live(50U);
        TEST_ASSERT_TRUE(bench.armed);
        drive_stop(&drive);
        drive_background(&drive);
        TEST_ASSERT_EQUAL_INT(DRIVE_READY, drive.state);
        TEST_ASSERT_FALSE(bench.armed);
        TEST_ASSERT_EQUAL_FLOAT(5.0f, drive_newest_command(&drive)->speed_ref_rad_s);
    }
}

void test_stop_is_withdrawn_by_a_start(void)
{
    const drive_stop_word_t how[] = {DRIVE_STOP_RAMP, DRIVE_STOP_SHORT};
    for (size_t k = 0; k < COUNT_OF(how); k++) {
        setUp();
        run(how[k]);
        drive_stop(&drive);
        bench_live(50U);
        drive_start(&drive);
        bench_live(500U);
        TEST_ASSERT_EQUAL_INT(DRIVE_RUN, drive.state);
        TEST_ASSERT_TRUE(bench.armed);
        TEST_ASSERT_EQUAL_FLOAT(5.0f, telemetry_read(&drive, SIGNAL_speed_ref_rad_s));
        ASSERT_NO_FAULT("a stop that was withdrawn");
    }
}

/* A shaft that goes on turning: stop_s, and off. */
void test_stop_lasts_no_longer_than_it_may(void)
{
    const drive_stop_word_t how[] = {DRIVE_STOP_RAMP, DRIVE_STOP_SHORT};
    for (size_t k = 0; k < COUNT_OF(how); k++) {
        setUp();
        drive_params_t p = stopped_by(how[k]);
        p.stop_s = 0.1f;
        p.speed_source = DRIVE_SPEED_PLL;
        bench_run_with(&p);
        bench_command(DRIVE_MODE_SPEED, 50.0, 0.0, 0.0);
        bench_spin(50.0, 1.0);
        drive_stop(&drive);
        double theta = 1.0;
        for (int i = 0; i < 990; i++) {
            theta += 50.0 * 1e-4;
            bench_angle(theta);
            bench_live(1U);
        }
        TEST_ASSERT_TRUE_MESSAGE(bench.armed, at("how %d", (int)how[k]));
        for (int i = 0; i < 30; i++) {
            theta += 50.0 * 1e-4;
            bench_angle(theta);
            bench_live(1U);
            drive_background(&drive);
        }
        TEST_ASSERT_EQUAL_INT(DRIVE_READY, drive.state);
        TEST_ASSERT_FALSE(bench.armed);
    }
}

void test_stop_by_a_fault_is_at_once_in_every_way_and_the_command_is_that_of_before(void)
{
    const drive_stop_word_t how[] = {DRIVE_STOP_RAMP, DRIVE_STOP_SHORT};
    for (size_t k = 0; k < COUNT_OF(how); k++) {
        setUp();
        run(how[k]);
        drive_stop(&drive);
        bench_live(20U);
        bench.sample.ia_a = 25.0f;
        bench_period();
        bench.sample.ia_a = 0.0f;
        ASSERT_FAULT(FAULT_over_current, "while it stops");
        drive_background(&drive);
        TEST_ASSERT_EQUAL_FLOAT(5.0f, drive_newest_command(&drive)->speed_ref_rad_s);
        drive_clear_fault(&drive);
        drive_background(&drive);
        TEST_ASSERT_EQUAL_INT(DRIVE_READY, drive.state);
    }
}

void test_stop_of_an_alignment_is_at_once(void)
{
    bench_into(DRIVE_ALIGN);
    drive_stop_by(&drive, DRIVE_STOP_RAMP);
    drive_background(&drive);
    TEST_ASSERT_EQUAL_INT(DRIVE_READY, drive.state);
    TEST_ASSERT_FALSE(bench.armed);
}

/* Default motor at 650 rad/s: 2600 6.4e-3 = 16.6 V over 0.36 + j 0.52 ohm is 26 A, beyond 20 A even without the first swing. */
void test_stop_by_a_short_that_would_trip_is_refused_and_names_the_current(void)
{
    drive_params_t p = bench_params();
    TEST_ASSERT_TRUE(drive_short_a(&p) > 26.0f);
    p.stop_action = DRIVE_STOP_SHORT;
    drive_init(&drive, &p);
    TEST_ASSERT_EQUAL_INT(FAULT_configuration, drive.fault);
    TEST_ASSERT_EQUAL_UINT16(PARAM_stop_action, drive.fault_detail);
    p.stop_action = DRIVE_STOP_COAST;
    p.timeout_action = DRIVE_STOP_SHORT;
    drive_init(&drive, &p);
    TEST_ASSERT_EQUAL_UINT16(PARAM_timeout_action, drive.fault_detail);
    p = stopped_by(DRIVE_STOP_SHORT);
    TEST_ASSERT_TRUE(drive_short_a(&p) < 20.0f);
    drive_init(&drive, &p);
    TEST_ASSERT_EQUAL_INT(FAULT_none, drive.fault);
}
