/* The three ways to stop on the machine: how long they take, and what current flows. */
#include "tests/scenario/support/shaft.h"
#include "tests/support/numeric.h"

void setUp(void) { shaft_new(); }
void tearDown(void) {}

static double largest_a;

static void turning(double rad_s, drive_stop_word_t how)
{
    shaft.params.stop_action = (uint16_t)how;
    shaft.params.align_periods = 0U;
    shaft.params.offset_calibration_periods = 0U;
    shaft_power_up();
    drive_start(&shaft.drive);
    shaft_speed(rad_s);
    shaft_settle(1000);
    shaft_run(5000);
    TEST_ASSERT_DOUBLE_WITHIN(1.0, rad_s, shaft_rad_s());
    TEST_ASSERT_EQUAL_INT(DRIVE_RUN, shaft.drive.state);
    drive_stop(&shaft.drive);
}

/* Until the bridge is off; ms. */
static int until_off(int longest_ms)
{
    int ms = 0;
    largest_a = 0.0;
    do {
        for (int k = 0; k < 10; k++) {
            shaft_run(1);
            largest_a = fmax(largest_a, fabs((double)shaft.drive.ia_a));
            largest_a = fmax(largest_a, fabs((double)shaft.drive.ib_a));
        }
        ms++;
    } while (((shaft.drive.state == DRIVE_RUN) || (shaft.drive.state == DRIVE_SHORT)) && (ms < longest_ms));
    return ms;
}

/* 200 rad/s at 1000 rad/s^2: 200 ms, 20 ms at rest, and what the speed loop (45 rad/s) swings: 100 ms */
void test_stop_by_ramp_takes_the_time_of_the_ramp_and_the_current_of_the_inertia(void)
{
    turning(200.0, DRIVE_STOP_RAMP);
    shaft_run(1000);
    TEST_ASSERT_DOUBLE_WITHIN(10.0, 100.0, shaft_rad_s()); /* 1000 / 44.7 0.4 behind at most */
    const int ms = until_off(1000);
    TEST_ASSERT_TRUE_MESSAGE((ms >= 118) && (ms < 220), at("%d ms", ms));
    /* 7.06e-5 1000 / 0.0384 = 1.84 A and what it swings beyond */
    TEST_ASSERT_TRUE_MESSAGE(largest_a < 2.8, at("%g A", largest_a));
    TEST_ASSERT_DOUBLE_WITHIN(1.0, 0.0, shaft_rad_s());
    TEST_ASSERT_EQUAL_STRING("none", shaft_fault());
    shaft_run(100);
    TEST_ASSERT_EQUAL_INT(DRIVE_READY, shaft.drive.state);
}

/* Shorted at speed w the torque is 1.5 p (psi w_e)... / (R^2 + w_e^2 L^2) R: from 80 rad/s, where w_e L = 0.064 ohm is small beside
 * 0.36, the speed falls with J R / (1.5 p^2 psi^2) = 25.9 ms: to 100/256 rad/s, which counts as rest, in 139 ms and 20 ms more. */
void test_stop_by_short_brakes_into_the_winding_and_the_current_stays_bounded(void)
{
    shaft.params.over_speed_rad_s = 100.0f;
    turning(80.0, DRIVE_STOP_SHORT);
    const int ms = until_off(1000);
    TEST_ASSERT_TRUE_MESSAGE((ms > 120) && (ms < 190), at("%d ms", ms));
    /* 4 80 6.4e-3 / 0.366 ohm = 5.6 A; 10 % for what the short adds at once */
    TEST_ASSERT_TRUE_MESSAGE((largest_a > 4.0) && (largest_a < 6.2), at("%g A", largest_a));
    TEST_ASSERT_EQUAL_STRING("none", shaft_fault());
    shaft_run(100);
    TEST_ASSERT_EQUAL_INT(DRIVE_READY, shaft.drive.state);
    drive_start(&shaft.drive);
    shaft_run(3000);
    TEST_ASSERT_EQUAL_INT(DRIVE_RUN, shaft.drive.state);
    TEST_ASSERT_DOUBLE_WITHIN(1.0, 80.0, shaft_rad_s());
}

void test_stop_by_coasting_has_no_current_and_turns_on(void)
{
    turning(80.0, DRIVE_STOP_COAST);
    TEST_ASSERT_TRUE(until_off(10) <= 2);
    shaft_run(1500);
    TEST_ASSERT_TRUE(shaft_rad_s() > 40.0);
}
