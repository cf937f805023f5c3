/* firmware/app/motion_check.c: an angle that no motor can make, a torque that does not act, a voltage that falls with the speed. */
#include "firmware/app/internal.h"
#include "mock_hal_clock.h"
#include "mock_hal_encoder.h"
#include "mock_hal_inverter.h"
#include "mock_hal_sample.h"
#include "tests/firmware/support/bench.h"

void setUp(void) { bench_start(); }
void tearDown(void) {}

/* ---- the angle -------------------------------------------------------------------------------------------------------- */

#define STEP_RAD 0.02 /* a period at 200 rad/s */

static double shaft; /* what the encoder shows */

static void turn(uint32_t periods)
{
    for (uint32_t k = 0U; k < periods; k++) {
        shaft += STEP_RAD;
        bench_angle(shaft);
        bench_period();
    }
}

static void turning(const drive_params_t *p)
{
    bench_run_with(p);
    shaft = 1.0;
    turn(50U);
    ASSERT_NO_FAULT("turning");
}

static drive_params_t watchful(void)
{
    drive_params_t p = bench_params();
    p.encoder_jump_rad = 0.05f;
    return p;
}

static double angle_error(double expected)
{
    return fabs(remainder((double)drive.tracking.theta_m / 4294967296.0 * TWO_PI - expected, TWO_PI));
}

/* default: 0.05 rad and two of 4000 counts are 0.0531 rad */
void test_motion_check_angle_that_jumps_and_stays_is_lost_in_the_second_sample(void)
{
    const double jump[] = {0.0540, -0.0540, 0.1745, -0.1745, 1.0, -1.0, 3.14, -3.14};
    for (size_t k = 0; k < COUNT_OF(jump); k++) {
        const drive_params_t p = watchful();
        bench_start();
        turning(&p);
        shaft += jump[k];
        turn(1U);
        ASSERT_NO_FAULT(at("%g rad, one sample", jump[k]));

        turn(1U);
        ASSERT_FAULT(FAULT_encoder_lost, at("%g rad", jump[k]));
    }
}

void test_motion_check_angle_that_jumps_by_less_is_not_lost(void)
{
    const double jump[] = {0.0520, -0.0520};
    for (size_t k = 0; k < COUNT_OF(jump); k++) {
        const drive_params_t p = watchful();
        bench_start();
        turning(&p);
        shaft += jump[k];
        turn(50U);
        ASSERT_NO_FAULT(at("%g rad", jump[k]));
    }
}

void test_motion_check_sample_that_jumps_alone_is_bridged_with_the_angle_that_was_expected(void)
{
    const drive_params_t p = watchful();
    turning(&p);
    for (int k = 0; k < 10; k++) {
        shaft += 0.7;
        turn(1U);
        shaft -= 0.7;
        TEST_ASSERT_TRUE_MESSAGE(angle_error(shaft) < 1e-6, "goes on turning");
        turn(3U);
        TEST_ASSERT_TRUE_MESSAGE(angle_error(shaft) < 1e-6, "believed again");
    }
    ASSERT_NO_FAULT("one sample at a time");
}

void test_motion_check_encoder_has_as_many_periods_to_come_back_as_its_parameter_says(void)
{
    drive_params_t p = watchful();
    p.encoder_jump_periods = 4U;
    turning(&p);
    shaft += 0.7;
    turn(4U);
    shaft -= 0.7;
    turn(1U);
    ASSERT_NO_FAULT("back after 4");

    shaft += 0.7;
    turn(4U);
    ASSERT_NO_FAULT("away for 4: it had its whole time again");
    turn(1U);
    ASSERT_FAULT(FAULT_encoder_lost, "the 5th");
}

/* The limit grows with the width of a count, and half a turn is never judged. */
void test_motion_check_limit_allows_two_counts_of_a_coarse_encoder(void)
{
    drive_params_t p = watchful();
    p.encoder_counts = 16.0f; /* 0.393 rad each */
    turning(&p);
    shaft += 0.83; /* below 0.05 + 0.785 */
    turn(20U);
    ASSERT_NO_FAULT("two counts");
    shaft += 0.85;
    turn(2U);
    ASSERT_FAULT(FAULT_encoder_lost, "more than two");

    bench_start();
    p = watchful();
    p.encoder_jump_rad = 3.2f;
    turning(&p);
    shaft += 3.1;
    turn(20U);
    ASSERT_NO_FAULT("never judged");
}

void test_motion_check_angle_is_found_again_after_samples_that_are_missing(void)
{
    drive_params_t p = watchful();
    p.lost_sample_limit = 13U; /* one more than the gap below */
    turning(&p);
    for (int k = 0; k < 5; k++) {
        shaft += 12.0 * STEP_RAD; /* twelve periods of which nobody saw anything */
        bench.sample.seq += 12U;
        turn(20U);
        ASSERT_NO_FAULT("a gap in the numbers");
        shaft += STEP_RAD;
        bench.sample_status = HAL_STALE;
        bench.seq_by_itself = false;
        bench_period();
        bench.seq_by_itself = true;
        bench.sample_status = HAL_OK;
        turn(20U);
        ASSERT_NO_FAULT("a sample that was not new");
    }
    shaft += 0.2;
    turn(2U);
    ASSERT_FAULT(FAULT_encoder_lost, "it is watched again");
}

void test_motion_check_lost_encoder_is_followed_from_where_it_is_and_watched_after_a_clear(void)
{
    drive_params_t p = watchful();
    turning(&p);
    shaft += 1.0;
    turn(10U);
    ASSERT_FAULT(FAULT_encoder_lost, "the first time");
    TEST_ASSERT_TRUE(angle_error(shaft) < 1e-6);
    drive_clear_fault(&drive);
    drive_background(&drive);
    turn(20U);
    ASSERT_NO_FAULT("well again");
    shaft += 1.0;
    turn(2U);
    ASSERT_FAULT(FAULT_encoder_lost, "the second time");
}

void test_motion_check_first_samples_may_be_anywhere_at_any_speed(void)
{
    const drive_params_t p = watchful();
    drive_init(&drive, &p);
    for (int k = 0; k < 100; k++) {
        bench_angle(2.0 + 0.9 * k); /* 9000 rad/s */
        bench_period();
        TEST_ASSERT_NOT_EQUAL_INT_MESSAGE(FAULT_encoder_lost, drive.fault, at("sample %d", k));
    }
}

/* ---- torque and voltage: one call a speed sample, 1 kHz ------------------------------------------------------------------ */

/* The default motor: 0.36 ohm, 0.2 mH, 4 pole pairs of 6.4 mWb, in a frame that is off by `zero_error` rad. */
static double zero_error;
static bool   reached; /* the speed that is asked for; else that is far beyond, along the torque */
static bool   rests;   /* what is asked for is to stand */

static void at_point(double speed_rad_s, double iq_ref_a, double iq_a, double vq_v)
{
    const double asked = rests ? 0.0 : (reached ? speed_rad_s : copysign(600.0, iq_ref_a));
    drive.motion.asked = num_from_float((float)asked * drive.scale.inv_speed);
    drive.speed.meas = num_from_float((float)speed_rad_s * drive.scale.inv_speed);
    drive.current.ref.q = num_from_float((float)iq_ref_a * drive.scale.inv_current);
    drive.current.torque = drive.current.ref.q;
    drive.current.meas.q = num_from_float((float)iq_a * drive.scale.inv_current);
    drive.current.meas.d = (num_t)0;
    drive.current.volt.q = num_from_float((float)vq_v * drive.scale.inv_voltage);
    drive.current.volt.d =
        num_from_float((float)((0.0256 * sin(zero_error) - 0.8e-3 * iq_a) * speed_rad_s) * drive.scale.inv_voltage);
    drive.sample.vdc_v = (float)BENCH_VDC;
    drive.tracking.theta_m += (angle_t)(int32_t)(speed_rad_s * 1e-3 / TWO_PI * 4294967296.0);
    drive_check_motion(&drive);
}

static void with_checks(double deviation_s, uint16_t zero_check, drive_mode_t mode)
{
    drive_params_t p = bench_params();
    p.speed_deviation_s = (float)deviation_s;
    p.zero_check = zero_check;
    bench_start();
    bench_run_with(&p);
    bench_command(mode, 100.0, 0.0, 0.0);
    zero_error = 0.0;
    reached = false;
    rests = false;
}

/* Samples at iq_ref with a speed that changes evenly; how many until a fault, 0: none. */
static int samples_to_fault(double from_rad_s, double per_sample, double iq_ref_a, int most)
{
    for (int k = 0; k < most; k++) {
        const double w = from_rad_s + per_sample * k;
        at_point(w, iq_ref_a, iq_ref_a, 0.36 * iq_ref_a + 0.0256 * cos(zero_error) * w);
        if (drive.fault != FAULT_none) {
            return k + 1;
        }
    }
    return 0;
}

/* 650 / 256 = 2.54 rad/s and 1/32 of the speed in the 50 samples after the first one are a loss: 2.7 are, 2.5 are not. */
void test_motion_check_speed_that_runs_from_the_torque_at_the_limit_trips_after_its_time(void)
{
    const drive_mode_t mode[] = {DRIVE_MODE_SPEED, DRIVE_MODE_POSITION};
    for (size_t m = 0; m < COUNT_OF(mode); m++) {
        for (double sign = -1.0; sign < 2.0; sign += 2.0) {
            with_checks(0.05, 0U, mode[m]);
            TEST_ASSERT_EQUAL_INT(0, samples_to_fault(0.0, sign * -2.5 / 50.0, sign * 10.0, 90));
            at_point(0.0, 0.0, 0.0, 0.0); /* another stretch */
            const int k = samples_to_fault(0.0, sign * -2.7 / 50.0, sign * 10.0, 200);
            TEST_ASSERT_TRUE_MESSAGE((k >= 50) && (k <= 52), at("%d samples", k));
            ASSERT_FAULT(FAULT_speed_deviation, at("mode %d, sign %g", (int)mode[m], sign));
        }
    }
}

void test_motion_check_speed_that_comes_nearer_or_stands_or_swings_does_not_trip(void)
{
    with_checks(0.05, 0U, DRIVE_MODE_SPEED);
    TEST_ASSERT_EQUAL_INT_MESSAGE(0, samples_to_fault(-500.0, 0.01, 10.0, 20000),
                                  "a heavy load brakes for 50 s"); /* 10 rad/s^2 */
    TEST_ASSERT_EQUAL_INT_MESSAGE(0, samples_to_fault(-80.0, 0.0156, 10.0, 10000),
                                  "1.56 rad/s in 100 samples, of 1.27, where the voltage says nothing");
    at_point(0.0, 0.0, 0.0, 0.0); /* another stretch */
    TEST_ASSERT_EQUAL_INT_MESSAGE(0, samples_to_fault(0.0, 0.0, 10.0, 2000), "stands: that is a stall");
    TEST_ASSERT_EQUAL_INT_MESSAGE(0, samples_to_fault(50.0, 0.0, -10.0, 1) + samples_to_fault(100.0, 0.0, 10.0, 2000),
                                  "balance at the limit, with a back-EMF that shows it");
    for (double rad_s = 0.5; rad_s < 40.0; rad_s *= 1.5) {
        at_point(80.0, 0.0, 0.0, 0.0); /* another stretch */
        for (int k = 0; k < 4000; k++) {
            const double w = 200.0 + rad_s * sin(0.12 * k); /* 19 Hz, falls for 26 ms */
            at_point(w, 10.0, 10.0, 3.6 + 0.0256 * w);
        }
        ASSERT_NO_FAULT(at("swings by %g rad/s", rad_s));
    }
    at_point(80.0, 0.0, 0.0, 0.0);
    for (int k = 0; k < 75; k++) { /* 6 rad/s lost in 25 samples, back in 50: after 50 it is 3 below, and gaining */
        at_point((k < 25) ? (80.0 - 0.24 * k) : (74.0 + 0.12 * (k - 25)), 10.0, 10.0, 3.6);
    }
    ASSERT_NO_FAULT("recovers");
    TEST_ASSERT_EQUAL_INT_MESSAGE(0, samples_to_fault(0.0, -1.0, 8.9, 500), "below 0.9 of the limit");
}

void test_motion_check_speed_that_stays_turned_against_the_torque_trips(void)
{
    with_checks(0.05, 0U, DRIVE_MODE_SPEED);
    zero_error = 3.14159265;
    const int k = samples_to_fault(-450.0, 0.0, 10.0, 500);
    ASSERT_FAULT(FAULT_speed_deviation, "at the voltage limit, backwards");
    TEST_ASSERT_TRUE_MESSAGE((k >= 100) && (k <= 102), at("%d samples", k));
}

void test_motion_check_torque_is_not_judged_when_switched_off_in_current_mode_or_not_running(void)
{
    with_checks(0.0, 0U, DRIVE_MODE_SPEED);
    TEST_ASSERT_EQUAL_INT(0, samples_to_fault(0.0, -1.0, 10.0, 500));
    with_checks(0.05, 0U, DRIVE_MODE_CURRENT);
    TEST_ASSERT_EQUAL_INT(0, samples_to_fault(0.0, -1.0, 10.0, 500));
    with_checks(0.05, 1U, DRIVE_MODE_SPEED);
    drive.state = DRIVE_READY;
    TEST_ASSERT_EQUAL_INT(0, samples_to_fault(0.0, -1.0, 10.0, 500));
}

/* A zero that is off by a quarter turn leaves no torque: friction slows the shaft down, or the little that is left drives it, or a
 * ripple swings it. 2.54 rad/s is the margin; half of it has to be gained in twice 50 samples. */
void test_motion_check_speed_that_comes_no_nearer_at_the_limit_trips_after_twice_its_time(void)
{
    const double error[] = {1.5708, -1.5708, 1.5708, 1.5708, 1.5708, 0.0};
    const double speed[] = {20.0, 20.0, -20.0, 300.0, 20.0, 60.0};
    const double gain[] = {-0.006, -0.006, 0.0, 0.01, 0.011, 0.0}; /* rad/s in a sample */
    for (size_t k = 0; k < COUNT_OF(error); k++) {
        for (double sign = -1.0; sign < 2.0; sign += 2.0) {
            with_checks(0.05, 0U, ((k % 2U) == 0U) ? DRIVE_MODE_SPEED : DRIVE_MODE_POSITION);
            zero_error = error[k];
            const int n = samples_to_fault(sign * speed[k], sign * gain[k], sign * 10.0, 500);
            ASSERT_FAULT(FAULT_speed_deviation, at("%g rad/s, sign %g", speed[k], sign));
            TEST_ASSERT_TRUE_MESSAGE((n >= 50) && (n <= 103), at("%g rad/s: %d samples", speed[k], n));
        }
    }
    with_checks(0.05, 0U, DRIVE_MODE_SPEED);
    zero_error = 1.5708;
    for (int k = 0; k < 300; k++) {
        at_point(3.0 * sin(0.06 * k), 10.0, 10.0, 3.6); /* 10 Hz, offset of a current sensor */
    }
    ASSERT_FAULT(FAULT_speed_deviation, "swings about standstill");
}

/* What is asked for has been reached: nothing more has to come nearer. */
void test_motion_check_drive_that_holds_its_speed_at_the_limit_does_not_trip(void)
{
    for (double w = 0.0; w < 61.0; w += 20.0) {
        with_checks(0.05, 0U, DRIVE_MODE_SPEED);
        drive.set[0].setup.motion.stall_samples = 80U;
        drive.set[0].setup.motion.stall_travel = num_from_float(74.0f * drive.scale.inv_speed);
        reached = true;
        for (int k = 0; k < 1000; k++) {
            at_point(w, 9.6, 9.6, 3.456 + 0.0256 * w);
        }
        ASSERT_NO_FAULT(at("%g rad/s", w));
    }
}

/* 24 V / sqrt(3) = 13.86 V. At the voltage limit on the q axis the back-EMF is what stands against the torque. */
void test_motion_check_drive_that_lacks_voltage_does_not_trip(void)
{
    with_checks(0.05, 0U, DRIVE_MODE_SPEED);
    for (int k = 0; k < 500; k++) {
        at_point(500.0 - 0.2 * k, 10.0, 3.0, 13.5);
    }
    ASSERT_NO_FAULT("too fast for the dc link");
    for (int k = 0; k < 120; k++) {
        at_point(400.0 - 0.2 * k, 10.0, 10.0, -9.0);
    }
    ASSERT_FAULT(FAULT_speed_deviation, "the same with the voltage of a wrong zero");
}

/* With 16 counts a turn, what is measured between two of them is a guess: 5 rad/s take 79 ms for one. */
void test_motion_check_speed_of_a_coarse_encoder_is_judged_over_three_counts(void)
{
    with_checks(0.05, 0U, DRIVE_MODE_SPEED);
    drive.set[0].setup.motion.travel = UINT32_C(0x30000000); /* 3/16 of a turn */
    int k = samples_to_fault(-5.0, 0.0, 10.0, 500);
    TEST_ASSERT_TRUE_MESSAGE((k >= 235) && (k <= 238), at("%d samples", k)); /* 1.178 rad / 5 rad/s */
    with_checks(0.05, 0U, DRIVE_MODE_SPEED);
    k = samples_to_fault(-5.0, 0.0, 10.0, 500);
    TEST_ASSERT_TRUE_MESSAGE((k >= 100) && (k <= 102), at("%d samples", k));
}

/* Sixteen counts for each of four electrical turns are enough, fewer are not. */
void test_motion_check_zero_is_not_judged_by_a_coarse_encoder(void)
{
    drive_params_t p = bench_params();
    drive_setup_t  s;
    p.zero_check = 1U;
    p.encoder_counts = 64.0f;
    TEST_ASSERT_EQUAL_UINT16(PARAM_COUNT, drive_make_setup(&p, &s));
    TEST_ASSERT_TRUE(s.motion.zero);
    p.encoder_counts = 63.0f;
    TEST_ASSERT_EQUAL_UINT16(PARAM_COUNT, drive_make_setup(&p, &s));
    TEST_ASSERT_FALSE(s.motion.zero);
}

/* vq = 0.36 i + 0.0256 w cos(error) of the default motor; three verdicts, each after 4 % of 24 V: 37.5 rad/s. */
static int volts_to_fault(double error_rad, double from_rad_s, double per_sample, double iq_a, int most)
{
    zero_error = error_rad;
    for (int k = 0; k < most; k++) {
        const double w = from_rad_s + per_sample * k;
        at_point(w, iq_a, iq_a, 0.36 * iq_a + 0.0256 * cos(error_rad) * w);
        if (drive.fault != FAULT_none) {
            return k + 1;
        }
    }
    return 0;
}

void test_motion_check_voltage_that_falls_with_the_speed_is_a_wrong_zero_in_every_mode(void)
{
    const drive_mode_t mode[] = {DRIVE_MODE_CURRENT, DRIVE_MODE_SPEED, DRIVE_MODE_POSITION};
    for (size_t m = 0; m < COUNT_OF(mode); m++) {
        for (double sign = -1.0; sign < 2.0; sign += 2.0) {
            with_checks(0.0, 1U, mode[m]);
            const int k = volts_to_fault(3.14159265, 0.0, sign * 5.0, 5.0, 200);
            ASSERT_FAULT(FAULT_electrical_zero, at("mode %d, sign %g", (int)mode[m], sign));
            TEST_ASSERT_TRUE_MESSAGE((k >= 24) && (k <= 30), at("%d samples", k)); /* 3 x 37.5 / 5 and what rounding up costs */
        }
    }
}

void test_motion_check_voltage_that_rises_with_the_speed_is_a_right_zero(void)
{
    const double error[] = {0.0, 0.5, 1.0, 1.4, -1.4};
    for (size_t k = 0; k < COUNT_OF(error); k++) {
        with_checks(0.0, 1U, DRIVE_MODE_CURRENT);
        TEST_ASSERT_EQUAL_INT(0, volts_to_fault(error[k], 0.0, 5.0, 5.0, 80));
        TEST_ASSERT_EQUAL_INT(0, volts_to_fault(error[k], 400.0, -5.0, 5.0, 160));
        TEST_ASSERT_EQUAL_INT(0, volts_to_fault(error[k], -400.0, 5.0, -5.0, 80));
    }
    with_checks(0.0, 0U, DRIVE_MODE_CURRENT);
    TEST_ASSERT_EQUAL_INT_MESSAGE(0, volts_to_fault(3.14159265, 0.0, 5.0, 5.0, 200), "switched off");
}

/* Another current, all the voltage there is, or two verdicts only: no fault. */
void test_motion_check_zero_is_not_judged_by_what_says_nothing(void)
{
    with_checks(0.0, 1U, DRIVE_MODE_CURRENT);
    for (int k = 0; k < 400; k++) {
        at_point(1.0 * k, 10.0 - 0.025 * k, 10.0 - 0.025 * k, 4.0 - 0.02 * k); /* 0.5 A more every 20 rad/s */
    }
    ASSERT_NO_FAULT("the current changes");
    with_checks(0.0, 1U, DRIVE_MODE_CURRENT);
    for (int k = 0; k < 100; k++) {
        at_point(5.0 * k, 5.0, 5.0, ((k % 2) == 0) ? 13.8 : 13.0);
    }
    ASSERT_NO_FAULT("at the voltage limit");
    with_checks(0.0, 1U, DRIVE_MODE_CURRENT);
    for (int k = 0; k < 50; k++) {
        TEST_ASSERT_EQUAL_INT(0, volts_to_fault(3.14159265, 0.0, 5.0, 5.0, 18)); /* 85 rad/s: two */
        at_point(0.0, 0.0, 0.0, 0.0);
        TEST_ASSERT_EQUAL_INT(0, volts_to_fault(0.0, 0.0, 5.0, 5.0, 18)); /* and then right ones */
        at_point(0.0, 0.0, 0.0, 0.0);
    }
}

/* The current of a load that overhauls the drive is at its limit, and vq shows that the torque has the right sign. */
void test_motion_check_right_zero_excuses_an_overhauled_drive(void)
{
    with_checks(0.05, 1U, DRIVE_MODE_SPEED);
    TEST_ASSERT_EQUAL_INT(0, volts_to_fault(0.0, 100.0, -2.0, 10.0, 300)); /* 37.5 rad/s in 19 samples */
    TEST_ASSERT_TRUE(volts_to_fault(0.0, -400.0, -0.4, 10.0, 300) > 0);    /* 20 rad/s in 50 samples, of 2.5 + 12.5 and 37.5 */
    ASSERT_FAULT(FAULT_speed_deviation, "too slow for a verdict");
}

/* ---- stall of a shaft that is to rest, and of one under a torque that is asked for --------------------------------------------- */

static void with_stall(drive_mode_t mode, float torque_a, float torque_s)
{
    drive_params_t p = bench_params();
    p.stall_s = 0.05f;
    p.stall_torque_a = torque_a;
    p.stall_torque_s = torque_s;
    bench_start();
    bench_run_with(&p);
    bench_command(mode, (mode == DRIVE_MODE_TORQUE) ? 20.0 : 0.0, 0.0, 0.0);
    zero_error = 0.0;
    reached = false;
    rests = true;
}

/* A speed sample, and a pass of the main loop. */
static void push_at(double speed_rad_s, double iq_a)
{
    drive.sample.seq += 10U;
    at_point(speed_rad_s, iq_a, iq_a, 0.36 * iq_a);
    drive_attend_stall(&drive);
}

static int samples_at(double speed_rad_s, double iq_a, int most)
{
    for (int k = 1; k <= most; k++) {
        push_at(speed_rad_s, iq_a);
        if (drive.state == DRIVE_FAULT) {
            return k;
        }
    }
    return 0;
}

/* Margin 650 / 256 = 2.54 rad/s. A motion is 1/256 turn, 0.02454 rad: 12.3 samples at 2 rad/s, of which twice 50 samples are
 * longer than three: it trips at the end of the next motion. */
void test_motion_check_load_that_turns_a_resting_shaft_slowly_against_the_torque_is_a_stall(void)
{
    for (double sign = -1.0; sign < 2.0; sign += 2.0) {
        with_stall(DRIVE_MODE_SPEED, 0.0f, 1.0f);
        int k = samples_at(-2.0 * sign, 10.0 * sign, 500);
        ASSERT_FAULT(FAULT_stall, "2 rad/s");
        TEST_ASSERT_TRUE_MESSAGE((k >= 100) && (k <= 113), at("2 rad/s: %d samples", k));

        with_stall(DRIVE_MODE_SPEED, 0.0f, 1.0f);
        k = samples_at(-0.5 * sign, 10.0 * sign, 500);
        ASSERT_FAULT(FAULT_stall, "0.5 rad/s");
        TEST_ASSERT_TRUE_MESSAGE((k >= 147) && (k <= 155), at("0.5 rad/s: %d samples", k));
    }
}

void test_motion_check_resting_shaft_that_is_held_stopped_or_turned_by_the_drive_is_no_stall(void)
{
    with_stall(DRIVE_MODE_SPEED, 0.0f, 1.0f);
    TEST_ASSERT_EQUAL_INT_MESSAGE(0, samples_at(0.0, 10.0, 5000), "held");
    TEST_ASSERT_EQUAL_INT_MESSAGE(0, samples_at(1.0, 10.0, 5000), "along the torque");
    TEST_ASSERT_EQUAL_INT_MESSAGE(0, samples_at(-1.0, 8.9, 5000), "below the limit");
    for (int k = 0; k < 20; k++) { /* gives way, and is brought back */
        TEST_ASSERT_EQUAL_INT_MESSAGE(0, samples_at(-1.0, 10.0, 60), "swings");
        TEST_ASSERT_EQUAL_INT_MESSAGE(0, samples_at(1.0, 10.0, 60), "swings");
    }
    rests = false;
    TEST_ASSERT_EQUAL_INT_MESSAGE(0, samples_at(-1.0, 10.0, 5000), "one that is to turn: speed_deviation, off here");
    with_stall(DRIVE_MODE_SPEED, 0.0f, 1.0f);
    for (int k = 0; k < 200; k++) { /* stops at 30 rad/s^2, 83 samples within the margin */
        push_at(fmin(0.0, -3.0 + 0.03 * k), 10.0);
    }
    ASSERT_NO_FAULT("stops");
}

void test_motion_check_torque_that_does_not_turn_the_shaft_is_a_stall_where_it_is_asked_for(void)
{
    static const drive_mode_t MODE[] = {DRIVE_MODE_CURRENT, DRIVE_MODE_TORQUE};
    for (size_t m = 0; m < COUNT_OF(MODE); m++) {
        for (double sign = -1.0; sign < 2.0; sign += 2.0) {
            with_stall(MODE[m], 4.0f, 0.3f);
            TEST_ASSERT_EQUAL_INT_MESSAGE(0, samples_at(0.0, 3.9 * sign, 2000), "less than 4 A");
            const int k = samples_at(0.0, 4.0 * sign, 2000);
            ASSERT_FAULT(FAULT_stall, "4 A");
            TEST_ASSERT_TRUE_MESSAGE((k >= 300) && (k <= 302), at("%d samples", k));

            with_stall(MODE[m], 4.0f, 0.3f);
            TEST_ASSERT_EQUAL_INT_MESSAGE(0, samples_at(0.2 * sign, 8.0, 2000), "turns, in either direction");
            with_stall(MODE[m], 0.0f, 0.3f);
            TEST_ASSERT_EQUAL_INT_MESSAGE(0, samples_at(0.0, 10.0 * sign, 20000), "not asked for");
        }
    }
    with_stall(DRIVE_MODE_TORQUE, 4.0f, 0.3f);
    bench_command(DRIVE_MODE_TORQUE, 0.0, 0.0, 0.0);
    TEST_ASSERT_EQUAL_INT_MESSAGE(0, samples_at(0.0, 10.0, 20000), "a limit of the speed that lets nothing turn");
    with_stall(DRIVE_MODE_SPEED, 4.0f, 0.3f);
    TEST_ASSERT_EQUAL_INT_MESSAGE(0, samples_at(0.0, 8.0, 20000), "speed mode has its own limit");
}

void test_motion_check_stall_torque_beyond_the_limit_is_refused(void)
{
    drive_params_t p = bench_params();
    p.stall_torque_a = 10.0f;
    drive_init(&drive, &p);
    ASSERT_NO_FAULT("as much as iq_limit_a");
    p.stall_torque_a = 10.1f;
    drive_init(&drive, &p);
    TEST_ASSERT_EQUAL_UINT16(PARAM_stall_torque_a, drive.fault_detail);
}
