/* firmware/app/index_check.c: the index pulse comes at the same count in every turn. */
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

static void run_with(double index_rad, double counts)
{
    drive_params_t p = bench_params();
    p.encoder_index_rad = (float)index_rad;
    p.encoder_counts = (float)counts;
    bench_start();
    bench_run_with(&p);
}

static void pulse(double at_rad)
{
    bench.edge.index_passes++;
    bench.edge.index_rad = (float)at_rad;
    bench_live(20U);
}

static double error_rad(void) { return (double)telemetry_read(&drive, SIGNAL_index_error_rad); }

/* 0.02 rad and four of 4000 counts are 0.02628 rad */
void test_index_check_trips_beyond_its_tolerance_on_either_side_of_the_first_pulse(void)
{
    const double first[] = {3.0, 0.01, TWO_PI - 0.01};
    for (size_t k = 0; k < COUNT_OF(first); k++) {
        for (double sign = -1.0; sign < 2.0; sign += 2.0) {
            run_with(0.02, 4000.0);
            pulse(first[k]);
            pulse(fmod(first[k] + sign * 0.0262 + TWO_PI, TWO_PI));
            ASSERT_NO_FAULT(at("%g rad", first[k]));
            TEST_ASSERT_DOUBLE_WITHIN(1e-5, sign * 0.0262, error_rad());
            pulse(fmod(first[k] + sign * 0.0300 + TWO_PI, TWO_PI)); /* 19.1 counts */
            ASSERT_FAULT(FAULT_encoder_index, at("%g rad", first[k]));
            TEST_ASSERT_EQUAL_UINT16(19U, drive_fault_detail(&drive));
        }
    }
}

void test_index_check_counts_that_are_lost_turn_by_turn_add_up(void)
{
    run_with(0.02, 4000.0);
    for (int turn = 0; turn < 100; turn++) {
        pulse(2.0 + 0.01 * (turn & 1)); /* edges of the pulse */
    }
    for (int turn = 1; turn <= 2; turn++) {
        pulse(2.0 - 0.011 * turn);
        ASSERT_NO_FAULT(at("%d turns", turn));
    }
    pulse(2.0 - 0.033);
    ASSERT_FAULT(FAULT_encoder_index, "three turns");
}

void test_index_check_is_silent_without_a_pulse_and_when_switched_off(void)
{
    run_with(0.02, 4000.0);
    bench.edge.index_rad = 2.0f; /* not passed */
    bench_live(100U);
    bench.edge.index_rad = 4.0f;
    bench_live(100U);
    ASSERT_NO_FAULT("no pulse");
    run_with(0.0, 4000.0);
    pulse(1.0);
    pulse(4.0);
    ASSERT_NO_FAULT("0: not judged");
    TEST_ASSERT_DOUBLE_WITHIN(1e-5, 3.0, error_rad()); /* but shown */
}

/* one of 16 counts is 0.39 rad */
void test_index_check_leaves_the_width_of_a_pulse_to_a_coarse_encoder(void)
{
    run_with(0.02, 16.0);
    pulse(1.0);
    pulse(1.0 + 1.57);
    ASSERT_NO_FAULT("four counts");
    pulse(1.0 + 1.97);
    ASSERT_FAULT(FAULT_encoder_index, "five counts");
    TEST_ASSERT_EQUAL_UINT16(5U, drive_fault_detail(&drive));
}

/* The pulse of before says nothing about a zero that is found after the fault. */
void test_index_check_begins_again_after_a_fault_that_voids_the_electrical_zero(void)
{
    run_with(0.02, 4000.0);
    pulse(1.0);
    pulse(2.0);
    ASSERT_FAULT(FAULT_encoder_index, "lost");
    drive_clear_fault(&drive);
    bench_live(20U);
    drive_start(&drive);
    bench_live(20U);
    TEST_ASSERT_EQUAL_INT(DRIVE_RUN, drive.state);
    pulse(5.0); /* counts were lost before the zero was found */
    ASSERT_NO_FAULT("the first");
    pulse(5.01);
    ASSERT_NO_FAULT("as the first");
    pulse(1.0);
    ASSERT_FAULT(FAULT_encoder_index, "lost again");
}

void test_index_check_angle_that_is_no_number_trips(void)
{
    run_with(0.02, 4000.0);
    pulse(1.0);
    pulse((double)NAN);
    ASSERT_FAULT(FAULT_encoder_index, "not a number");
    TEST_ASSERT_EQUAL_UINT16(UINT16_MAX, drive_fault_detail(&drive));
}
