/* firmware/app/restart.c: starts after a trip, no more than a number of them within a time. */
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

#define SECOND 10000U /* periods */

static void run_with(uint16_t limit, float window_s)
{
    drive_params_t p = bench_params();
    p.restart_limit = limit;
    p.restart_window_s = window_s;
    bench_start();
    bench_run_with(&p);
}

static void trip_and_clear(void)
{
    bench.sample.vdc_v = 100.0f;
    bench_period();
    ASSERT_FAULT(FAULT_over_voltage, "trips");
    bench.sample.vdc_v = (float)BENCH_VDC;
    drive_clear_fault(&drive);
    drive_background(&drive);
    ASSERT_NO_FAULT("cleared");
}

static void start(void)
{
    drive_start(&drive);
    drive_background(&drive);
    bench_period();
}

static double wait_s(void) { return (double)telemetry_read(&drive, SIGNAL_restart_wait_s); }

/* Three within 4 s, at 0.0, 1.0 and 2.0 s; the fourth at 3.0 s waits until the first is 4 s ago. */
void test_restart_beyond_its_number_is_refused_until_the_oldest_has_left_the_window(void)
{
    run_with(3U, 4.0f);
    for (int k = 0; k < 3; k++) {
        trip_and_clear();
        TEST_ASSERT_EQUAL_DOUBLE(0.0, wait_s());
        start();
        TEST_ASSERT_EQUAL_INT_MESSAGE(DRIVE_RUN, drive.state, at("start %d", k + 1));
        bench_live(SECOND - 2U);
    }
    trip_and_clear();
    TEST_ASSERT_DOUBLE_WITHIN(0.002, 1.0, wait_s());
    const uint32_t arms = bench.arms;
    start();
    ASSERT_FAULT(FAULT_restart_lockout, "the fourth");
    TEST_ASSERT_EQUAL_UINT16(1U, drive_fault_detail(&drive));
    TEST_ASSERT_EQUAL_UINT32(arms, bench.arms);

    drive_clear_fault(&drive); /* not the way round it, and a refused start does not count */
    drive_background(&drive);
    bench_live(SECOND - 200U);
    start();
    ASSERT_FAULT(FAULT_restart_lockout, "a bit too early");
    drive_clear_fault(&drive);
    drive_background(&drive);
    bench_live(300U);
    TEST_ASSERT_EQUAL_DOUBLE(0.0, wait_s());
    start();
    TEST_ASSERT_EQUAL_INT(DRIVE_RUN, drive.state);
    trip_and_clear();
    start();
    ASSERT_FAULT(FAULT_restart_lockout, "the start at 1.0 s was less than 4 s ago");
    TEST_ASSERT_EQUAL_UINT16(1U, drive_fault_detail(&drive));
}

void test_restart_says_whole_seconds_and_never_too_few(void)
{
    run_with(1U, 60.0f);
    trip_and_clear();
    start();
    bench_live(SECOND / 2U);
    trip_and_clear();
    TEST_ASSERT_DOUBLE_WITHIN(0.01, 59.5, wait_s());
    start();
    ASSERT_FAULT(FAULT_restart_lockout, "half a second later");
    TEST_ASSERT_EQUAL_UINT16(60U, drive_fault_detail(&drive));
}

void test_restart_counts_neither_starts_without_a_trip_nor_clears_without_a_start(void)
{
    run_with(1U, 60.0f);
    for (int k = 0; k < 10; k++) {
        drive_stop(&drive);
        drive_background(&drive);
        start();
        TEST_ASSERT_EQUAL_INT(DRIVE_RUN, drive.state);
    }
    for (int k = 0; k < 10; k++) {
        trip_and_clear();
    }
    start();
    TEST_ASSERT_EQUAL_INT_MESSAGE(DRIVE_RUN, drive.state, "the first after a trip");
    drive_stop(&drive);
    drive_background(&drive);
    start();
    TEST_ASSERT_EQUAL_INT_MESSAGE(DRIVE_RUN, drive.state, "nothing has tripped since");
    trip_and_clear();
    start();
    ASSERT_FAULT(FAULT_restart_lockout, "the second");
}

/* One start, although it aligns first. */
void test_restart_with_an_alignment_counts_once(void)
{
    drive_params_t p = bench_params();
    p.restart_limit = 2U;
    p.align_periods = BENCH_ALIGN_PERIODS;
    drive_init(&drive, &p);
    drive_background(&drive);
    bench_rotor(4.0, 0.5);
    bench_align();
    TEST_ASSERT_EQUAL_INT(DRIVE_RUN, drive.state);
    for (int k = 0; k < 2; k++) {
        bench.sample_status = HAL_SENSOR_FAULT;
        bench_period();
        bench.sample_status = HAL_OK;
        ASSERT_FAULT(FAULT_encoder_error, "voids the electrical zero");
        drive_clear_fault(&drive);
        drive_background(&drive);
        bench_align();
        TEST_ASSERT_EQUAL_INT_MESSAGE(DRIVE_RUN, drive.state, at("start %d", k + 1));
    }
}

void test_restart_limit_of_zero_counts_nothing_and_the_largest_is_counted(void)
{
    run_with(0U, 3600.0f);
    for (int k = 0; k < 50; k++) {
        trip_and_clear();
        start();
        TEST_ASSERT_EQUAL_INT(DRIVE_RUN, drive.state);
    }
    run_with((uint16_t)DRIVE_RESTARTS, 20.0f);
    for (unsigned k = 0U; k < DRIVE_RESTARTS; k++) { /* at 0.0, 1.0 .. 7.0 s */
        trip_and_clear();
        start();
        bench_live(SECOND - 2U);
        TEST_ASSERT_EQUAL_INT(DRIVE_RUN, drive.state);
    }
    trip_and_clear();
    drive_params_t p = *drive.params;
    p.restart_limit = 3U; /* the newest three count, since 5.0 s */
    uint16_t culprit = 0U;
    TEST_ASSERT_TRUE(drive_tune(&drive, &p, &culprit));
    bench_live(20U);
    start();
    ASSERT_FAULT(FAULT_restart_lockout, "of eight");
    TEST_ASSERT_EQUAL_UINT16(17U, drive_fault_detail(&drive));
}
