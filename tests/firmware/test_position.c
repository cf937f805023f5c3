/* firmware/app/position.c: profile, cascade, limits, homing, and the ways into position mode and out of it. */
#include "firmware/app/telemetry.h"
#include "mock_hal_clock.h"
#include "mock_hal_encoder.h"
#include "mock_hal_inverter.h"
#include "mock_hal_limits.h"
#include "mock_hal_sample.h"
#include "tests/firmware/support/bench.h"

#define TS 1e-3
#define KPP 10.0
#define KVP 1.5
/* an angle of up to 2 pi as a float, and the turn it is in */
#define RAD_TOLERANCE 2e-6

/* ---- a shaft -------------------------------------------------------------------------------------------------------------- */

static struct {
    double theta, speed; /* rad over all turns, rad/s */
    double per_amp;      /* rad/s^2 per A of reference; 0: held */
    bool   ideal;        /* follows its command at once */
    double index;        /* where the index pulse is, modulo a turn; NaN: nowhere */
} shaft;

static double signal(uint16_t s) { return (double)telemetry_read(&drive, s); }
static double iq_ref(void) { return signal(SIGNAL_iq_ref_a); }
static double position(void) { return signal(SIGNAL_position_rad); }
static double command_now(void) { return signal(SIGNAL_position_ref_rad); }
static double following(void) { return signal(SIGNAL_position_error_rad); }

void setUp(void)
{
    bench_start();
    (void)memset(&shaft, 0, sizeof shaft);
    shaft.index = NAN;
}
void tearDown(void) {}

static void see(double theta)
{
    const double from = floor((shaft.theta - shaft.index) / TWO_PI);
    const double to = floor((theta - shaft.index) / TWO_PI);
    if (!isnan(shaft.index) && (from != to)) {
        bench.edge.index_passes++;
        bench.edge.index_rad = (float)(drive.setup->tracking.encoder_reversed ? TWO_PI - shaft.index : shaft.index);
    }
    shaft.theta = theta;
    bench_angle(drive.setup->tracking.encoder_reversed ? -theta : theta);
}

/* One sample of the position loop: ten periods, the shaft moves before the first. */
static void sample(void)
{
    if (shaft.ideal && drive.position.active) {
        see(shaft.theta + command_now() - position());
    } else {
        shaft.speed += shaft.per_amp * iq_ref() * TS;
        see(shaft.theta + shaft.speed * TS);
    }
    bench_live(10U);
}

static void samples(int count)
{
    for (int k = 0; k < count; k++) {
        sample();
    }
}

static drive_params_t params(void)
{
    drive_params_t p = bench_params();
    p.speed_inline = 1U;
    p.position_kp_per_s = (float)KPP;
    p.position_kv_a_per_rad_s = (float)KVP;
    p.following_error_rad = 100.0f;
    p.profile_accel_rad_s2 = 0.0f;
    return p;
}

static void go_to(double rad)
{
    const double          turns = trunc(rad / TWO_PI);
    const drive_command_t c = {
        .mode = DRIVE_MODE_POSITION, .target_turns = (int32_t)turns, .target_rad = (float)(rad - turns * TWO_PI)};
    TEST_ASSERT_TRUE(drive_command(&drive, &c));
}

static void run_with(const drive_params_t *p, double target)
{
    bench_run_with(p);
    go_to(target);
}

static void change(const drive_params_t *p)
{
    uint16_t culprit = 0U;
    TEST_ASSERT_TRUE(drive_tune(&drive, p, &culprit));
    bench_live(10U);
}

/* What may not change while the bridge is on: stop, change, go on. */
static void change_at_rest(const drive_params_t *p)
{
    drive_stop(&drive);
    drive_background(&drive);
    change(p);
    drive_start(&drive);
    drive_background(&drive);
    TEST_ASSERT_EQUAL_INT(DRIVE_RUN, drive.state);
}

/* ---- the cascade ------------------------------------------------------------------------------------------------------------ */

/* 111.3 rad/s^2 per A is the machine of Yeh and Liu */
void test_position_steady_lag_is_speed_over_gain_in_both_directions(void)
{
    const double speeds[] = {1.0471976, 1.5707963, 2.0943951};
    for (size_t k = 0; k < COUNT_OF(speeds); k++) {
        for (int sign = -1; sign <= 1; sign += 2) {
            setUp();
            drive_params_t p = params();
            p.profile_speed_rad_s = (float)speeds[k];
            shaft.per_amp = 0.868 / 0.0078;
            run_with(&p, 100.0 * sign);
            samples(3000);
            double mean = 0.0;
            for (int n = 0; n < 100; n++) {
                sample();
                mean += 0.01 * following();
            }
            TEST_ASSERT_DOUBLE_WITHIN_MESSAGE(0.01 * speeds[k] / KPP, sign * speeds[k] / KPP, mean,
                                              at("%g rad/s", speeds[k] * sign));
            TEST_ASSERT_DOUBLE_WITHIN(1e-3 * speeds[k], sign * speeds[k], signal(SIGNAL_velocity_ref_rad_s));
        }
    }
}

void test_position_speed_feed_forward_takes_the_lag_away(void)
{
    drive_params_t p = params();
    p.position_velocity_ff = 1U;
    shaft.per_amp = 0.868 / 0.0078;
    run_with(&p, 100.0);
    samples(3000);
    double mean = 0.0;
    for (int n = 0; n < 100; n++) {
        sample();
        mean += 0.01 * following();
    }
    /* a sample between the command and what is measured of it */
    TEST_ASSERT_DOUBLE_WITHIN(1.2e-3, 0.0, mean);
}

void test_position_first_torque_is_that_of_a_hand_calculation(void)
{
    const drive_params_t p = params();
    run_with(&p, 1.0);
    for (int k = 1; k <= 5; k++) {
        sample(); /* held: the command goes ahead by 1.0471976e-3 rad per sample */
        const double wanted = KPP * 1.0471976e-3 * k;
        const double integral = KVP * TS / 0.05 * KPP * 1.0471976e-3 * (0.5 * k * (k - 1.0));
        TEST_ASSERT_DOUBLE_WITHIN(1e-5, KVP * wanted + integral, iq_ref());
    }
}

void test_position_comes_to_rest_on_its_target_over_many_turns_both_ways(void)
{
    const double   targets[] = {0.5, -0.5, 20.0, -33.0, 6.2831855, -6.2831855, -1e-9, 1e-9, 0.0};
    drive_params_t p = params();
    p.profile_speed_rad_s = 50.0f;
    p.profile_accel_rad_s2 = 500.0f;
    p.position_velocity_ff = 1U;
    shaft.per_amp = 0.868 / 0.0078;
    bench_run_with(&p);
    for (size_t k = 0; k < COUNT_OF(targets); k++) {
        go_to(targets[k]);
        samples(3000);
        TEST_ASSERT_DOUBLE_WITHIN_MESSAGE(5e-6, targets[k], command_now(), at("target %g", targets[k]));
        TEST_ASSERT_DOUBLE_WITHIN_MESSAGE(1e-4, targets[k], shaft.theta, at("target %g", targets[k]));
        ASSERT_NO_FAULT("at its target");
    }
}

void test_position_target_is_the_same_place_however_it_is_split(void)
{
    const drive_command_t splits[] = {{.target_turns = 1, .target_rad = 0.25f},
                                      {.target_turns = 2, .target_rad = -6.0331853f},
                                      {.target_turns = 0, .target_rad = 6.5331853f}};
    drive_params_t        p = params();
    p.profile_speed_rad_s = 500.0f;
    for (size_t k = 0; k < COUNT_OF(splits); k++) {
        setUp();
        shaft.ideal = true;
        run_with(&p, 0.0);
        drive_command_t c = splits[k];
        c.mode = DRIVE_MODE_POSITION;
        TEST_ASSERT_TRUE(drive_command(&drive, &c));
        samples(200);
        TEST_ASSERT_DOUBLE_WITHIN_MESSAGE(3e-6, TWO_PI + 0.25, command_now(), at("split %u", (unsigned)k));
    }
}

void test_position_tiny_negative_target_is_not_a_turn_away(void)
{
    const float tiny[] = {-0.0f, -1e-20f, -1e-9f, -2e-8f};
    for (size_t k = 0; k < COUNT_OF(tiny); k++) {
        setUp();
        shaft.ideal = true;
        const drive_params_t p = params();
        run_with(&p, 0.0);
        const drive_command_t c = {.mode = DRIVE_MODE_POSITION, .target_rad = tiny[k]};
        TEST_ASSERT_TRUE(drive_command(&drive, &c));
        samples(300);
        TEST_ASSERT_DOUBLE_WITHIN_MESSAGE(RAD_TOLERANCE, 0.0, command_now(), at("%g", (double)tiny[k]));
    }
}

void test_position_command_that_is_not_a_number_is_refused(void)
{
    const float          bad[] = {NAN, INFINITY, -INFINITY};
    const drive_params_t p = params();
    run_with(&p, 0.0);
    for (size_t k = 0; k < COUNT_OF(bad); k++) {
        const drive_command_t c = {.mode = DRIVE_MODE_POSITION, .target_rad = bad[k]};
        TEST_ASSERT_FALSE(drive_command(&drive, &c));
    }
    samples(10);
    TEST_ASSERT_DOUBLE_WITHIN(RAD_TOLERANCE, 0.0, command_now());
}

void test_position_torque_is_held_back_by_its_samples(void)
{
    double plain[40];
    for (uint16_t delay = 0U; delay <= 7U; delay++) {
        setUp();
        drive_params_t p = params();
        p.torque_delay_samples = delay;
        run_with(&p, 1.0);
        for (int k = 0; k < 40; k++) {
            sample();
            if (delay == 0U) {
                plain[k] = iq_ref();
            }
            TEST_ASSERT_DOUBLE_WITHIN_MESSAGE(1e-9, (k >= delay) ? plain[k - delay] : 0.0, iq_ref(),
                                              at("delay %u, sample %d", delay, k));
        }
    }
}

void test_position_torque_stays_within_the_current_limit(void)
{
    drive_params_t p = params();
    p.profile_speed_rad_s = 100.0f;
    p.iq_limit_a = 2.0f;
    run_with(&p, 50.0);
    for (int k = 0; k < 300; k++) {
        sample();
        TEST_ASSERT_TRUE(fabs(iq_ref()) <= 2.0 + 1e-6);
    }
    TEST_ASSERT_DOUBLE_WITHIN(1e-5, 2.0, iq_ref());
}

/* ---- following error ----------------------------------------------------------------------------------------------------------- */

/* the shaft is held, the command leaves at 1 mrad per sample: at sample 101 it is more than 0.1005 rad away */
void test_position_following_error_trips_after_its_samples_and_not_before(void)
{
    const uint16_t counts[] = {1U, 20U, 200U};
    for (size_t k = 0; k < COUNT_OF(counts); k++) {
        for (int sign = -1; sign <= 1; sign += 2) {
            setUp();
            drive_params_t p = params();
            p.profile_speed_rad_s = 1.0f;
            p.following_error_rad = 0.1005f;
            p.following_error_samples = counts[k];
            run_with(&p, 10.0 * sign);
            samples(100 + (int)counts[k]);
            ASSERT_NO_FAULT("not yet");
            samples(1);
            ASSERT_FAULT(FAULT_following_error, at("after %u samples", counts[k]));
        }
    }
}

void test_position_following_error_that_goes_away_in_time_is_forgotten(void)
{
    drive_params_t p = params();
    p.profile_speed_rad_s = 1.0f;
    p.following_error_rad = 0.1005f;
    p.following_error_samples = 20U;
    run_with(&p, 100.0);
    for (int round = 0; round < 5; round++) {
        samples(110);
        shaft.theta = command_now(); /* slips to where it should be */
    }
    ASSERT_NO_FAULT("never 20 samples in a row");
}

/* ---- soft limits ------------------------------------------------------------------------------------------------------------------ */

void test_position_target_is_cut_to_the_soft_limits(void)
{
    drive_params_t p = params();
    p.position_min_turn = -0.25f;
    p.position_max_turn = 1.5f;
    p.profile_speed_rad_s = 20.0f;
    shaft.ideal = true;
    run_with(&p, 1000.0);
    samples(1500);
    TEST_ASSERT_DOUBLE_WITHIN(RAD_TOLERANCE, 1.5 * TWO_PI, command_now());
    const drive_command_t far = {.mode = DRIVE_MODE_POSITION, .target_turns = INT32_MIN, .target_rad = -6.0f};
    TEST_ASSERT_TRUE(drive_command(&drive, &far));
    samples(1500);
    TEST_ASSERT_DOUBLE_WITHIN(RAD_TOLERANCE, -0.25 * TWO_PI, command_now());
    ASSERT_NO_FAULT("within the limits");
}

void test_position_beyond_a_soft_limit_trips_with_a_hundredth_of_a_turn_to_spare(void)
{
    for (int sign = -1; sign <= 1; sign += 2) {
        setUp();
        drive_params_t p = params();
        p.position_min_turn = -0.5f;
        p.position_max_turn = 0.5f;
        shaft.ideal = true;
        run_with(&p, 0.0);
        samples(10);
        shaft.ideal = false;
        for (double turns = 0.0; turns <= 0.509; turns += 0.001) {
            see(sign * turns * TWO_PI);
            bench_live(10U);
        }
        ASSERT_NO_FAULT("within the margin");
        see(sign * 0.512 * TWO_PI);
        bench_live(10U);
        ASSERT_FAULT(FAULT_position_limit, at("sign %d", sign));
    }
}

/* ---- homing ----------------------------------------------------------------------------------------------------------------------- */

static void home_from(double start, double index, double speed, bool reversed, double target)
{
    setUp();
    drive_params_t p = params();
    p.homing_speed_rad_s = (float)speed;
    p.encoder_reversed = reversed ? 1U : 0U;
    shaft.ideal = true;
    shaft.theta = start;
    bench_angle(reversed ? -start : start);
    bench_run_with(&p);
    go_to(start);
    samples(5);
    shaft.index = index;
    go_to(target);
    drive_home(&drive);
}

static void assert_homes(double start, double index, double speed, bool reversed)
{
    const char *text = at("from %g to the index at %g with %g rad/s%s", start, index, speed, reversed ? ", reversed" : "");
    home_from(start, index, speed, reversed, 0.25);
    for (int k = 0; (k < 9000) && (signal(SIGNAL_homed) == 0.0); k++) {
        sample();
        if (signal(SIGNAL_homed) == 0.0) {
            TEST_ASSERT_DOUBLE_WITHIN_MESSAGE(2e-3 * fabs(speed), speed, signal(SIGNAL_velocity_ref_rad_s), text);
        }
    }
    ASSERT_NO_FAULT(text);
    TEST_ASSERT_EQUAL_DOUBLE(1.0, signal(SIGNAL_homed));
    /* the index is position 0: the shaft is where its position says */
    const double turns = floor((shaft.theta - index) / TWO_PI + 0.5);
    TEST_ASSERT_DOUBLE_WITHIN_MESSAGE(0.02, shaft.theta - index - turns * TWO_PI, position(), text);
    TEST_ASSERT_DOUBLE_WITHIN_MESSAGE(3.0 * fabs(speed) * TS + RAD_TOLERANCE, position(), command_now(),
                                      text); /* the command did not jump */
    samples(1500);
    TEST_ASSERT_DOUBLE_WITHIN_MESSAGE(1e-5, 0.25, position(), text);
    TEST_ASSERT_DOUBLE_WITHIN_MESSAGE(1e-5, 0.25, shaft.theta - index - turns * TWO_PI, text);
    ASSERT_NO_FAULT(text);
}

void test_position_homing_finds_the_index_in_both_directions_and_makes_it_zero(void)
{
    const double indices[] = {0.5, 3.0, 6.2};
    for (size_t k = 0; k < COUNT_OF(indices); k++) {
        for (int reversed = 0; reversed < 2; reversed++) {
            assert_homes(2.0, indices[k], 1.0, reversed != 0);
            assert_homes(2.0, indices[k], -1.0, reversed != 0);
        }
    }
}

void test_position_homing_with_an_index_already_known_needs_no_motion(void)
{
    home_from(2.0, NAN, 1.0, false, 0.0);
    bench.edge.index_passes = 1U;
    bench.edge.index_rad = 1.5f;
    sample();

    TEST_ASSERT_EQUAL_DOUBLE(1.0, signal(SIGNAL_homed));
    TEST_ASSERT_DOUBLE_WITHIN(5e-3, 0.5, position());
}

void test_position_homing_without_an_index_trips_within_a_turn_and_a_half(void)
{
    for (int sign = -1; sign <= 1; sign += 2) {
        home_from(2.0, NAN, 5.0 * sign, false, 2.0);
        samples((int)(1.24 * TWO_PI / 5.0 / TS));
        ASSERT_NO_FAULT("still searching");
        samples((int)(0.1 * TWO_PI / 5.0 / TS));
        ASSERT_FAULT(FAULT_homing, at("sign %d", sign));
        TEST_ASSERT_EQUAL_DOUBLE(0.0, signal(SIGNAL_homed));
    }
}

void test_position_homing_is_not_stopped_by_the_soft_limits(void)
{
    home_from(0.5, 3.0, 1.0, false, 0.5);
    drive_params_t p = *drive.params;
    p.position_min_turn = -0.1f;
    p.position_max_turn = 0.1f;
    change_at_rest(&p);
    samples(3000);
    ASSERT_NO_FAULT("homed");
    TEST_ASSERT_EQUAL_DOUBLE(1.0, signal(SIGNAL_homed));
}

void test_position_after_a_homing_that_failed_the_profile_has_its_own_speed_again(void)
{
    home_from(2.0, NAN, 5.0, false, 2.0);
    samples(3000);
    ASSERT_FAULT(FAULT_homing, "no index");
    drive_clear_fault(&drive);
    drive_background(&drive);
    drive_start(&drive);
    bench_live(40U);
    TEST_ASSERT_EQUAL_INT(DRIVE_RUN, drive.state);
    shaft.ideal = false;
    shaft.speed = 0.0;
    go_to(100.0);
    samples(20);
    TEST_ASSERT_DOUBLE_WITHIN(1e-3, 1.0471976, signal(SIGNAL_velocity_ref_rad_s));
}

/* ---- in and out of position mode ----------------------------------------------------------------------------------------------------- */

static void spin(double speed, int count)
{
    for (int k = 0; k < count; k++) {
        see(shaft.theta + speed * TS);
        bench_live(10U);
    }
}

void test_position_is_counted_in_every_mode(void)
{
    const drive_params_t p = params();
    shaft.ideal = true;
    run_with(&p, 0.0);
    samples(10);
    shaft.ideal = false;
    const drive_mode_t modes[] = {DRIVE_MODE_SPEED, DRIVE_MODE_CURRENT};
    for (size_t k = 0; k < COUNT_OF(modes); k++) {
        bench_command(modes[k], 0.0, 0.0, 0.0);
        spin(20.0, 1000); /* 3.2 turns */
        spin(0.0, 50);
        go_to(shaft.theta);
        spin(0.0, 1);
        TEST_ASSERT_DOUBLE_WITHIN(5e-6, shaft.theta, position());
        TEST_ASSERT_DOUBLE_WITHIN(5e-6, shaft.theta, command_now());
    }
}

void test_position_mode_begins_where_the_shaft_is_without_a_jump(void)
{
    const drive_params_t p = params();
    bench_run_with(&p);
    bench_command(DRIVE_MODE_SPEED, 20.0, 0.0, 0.0);
    spin(20.0, 1003);
    go_to(0.0);
    spin(20.0, 1);
    /* command: where it is, and no more than a step of the profile; torque: the speed error and what the lag asks for */
    TEST_ASSERT_DOUBLE_WITHIN(1.1e-3 * 1.0471976 + 5e-6, position(), command_now());
    TEST_ASSERT_DOUBLE_WITHIN(1.1e-3 * 1.0471976 + 5e-6, 0.0, following());
    for (int k = 0; k < 3; k++) {
        /* 20 rad/s are 10 A at most: 1.5 A s/rad, limited; the measured speed is 20, not half a turn per sample */
        TEST_ASSERT_DOUBLE_WITHIN(0.02, 20.0, (double)num_to_float(drive.position.speed) * (double)drive.scale.speed_rad_s);
        spin(20.0, 1);
    }
}

void test_position_speed_mode_goes_on_with_the_torque_of_position_mode(void)
{
    drive_params_t p = params();
    p.speed_source = DRIVE_SPEED_PLL;
    bench_run_with(&p);
    bench_command(DRIVE_MODE_SPEED, 30.0, 0.0, 0.0);
    samples(60); /* held: the integral part winds up to some ampere */
    TEST_ASSERT_TRUE(iq_ref() > 3.0);
    go_to(0.05);
    samples(300);
    const double torque = iq_ref();
    bench_command(DRIVE_MODE_SPEED, 0.0, 0.0, 0.0);
    samples(1);

    TEST_ASSERT_DOUBLE_WITHIN(0.02 * fabs(torque) + 1e-3, torque, iq_ref());
}

void test_position_restart_begins_where_the_shaft_is(void)
{
    drive_params_t p = params();
    drive_init(&drive, &p);
    drive_background(&drive);
    drive_start(&drive);
    drive_background(&drive);
    go_to(1.0);
    samples(500);
    drive_stop(&drive);
    bench_live(20U);
    spin(-30.0, 100);
    drive_start(&drive);
    bench_live(10U);
    spin(0.0, 2);
    TEST_ASSERT_DOUBLE_WITHIN(5e-6, shaft.theta, position());
    TEST_ASSERT_DOUBLE_WITHIN(3e-3, shaft.theta, command_now());
}

/* ---- changed on the way ---------------------------------------------------------------------------------------------------------------- */

void test_position_smoothing_changed_on_the_way_still_ends_on_the_target(void)
{
    const uint16_t lengths[] = {64U, 3U, 1U, 20U};
    drive_params_t p = params();
    p.profile_smooth_samples = 20U;
    p.profile_accel_rad_s2 = 20.0f;
    p.profile_speed_rad_s = 10.0f;
    shaft.ideal = true;
    run_with(&p, 30.0);
    double last = command_now();
    for (size_t k = 0; k < COUNT_OF(lengths); k++) {
        for (int n = 0; n < 203; n++) {
            sample();
            TEST_ASSERT_TRUE_MESSAGE(fabs(command_now() - last) <= 10.0 * TS * 1.001 + 5e-6, at("length %u", lengths[k]));
            last = command_now();
        }
        p.profile_smooth_samples = lengths[k];
        shaft.ideal = false;
        change(&p);
        shaft.ideal = true;
        last = command_now();
    }
    samples(6000);
    TEST_ASSERT_DOUBLE_WITHIN(3e-6, 30.0, command_now());
    TEST_ASSERT_DOUBLE_WITHIN(1e-6, 0.0, signal(SIGNAL_velocity_ref_rad_s));
}

void test_position_gain_changed_while_running_acts(void)
{
    drive_params_t p = params();
    p.position_ti_s = 100.0f;
    p.profile_speed_rad_s = 10.0f;
    run_with(&p, 0.01);
    samples(50);
    const double before = iq_ref();
    p.position_kp_per_s = (float)(2.0 * KPP);
    change(&p);
    samples(1);
    TEST_ASSERT_DOUBLE_WITHIN(0.01 * before, 2.0 * before, iq_ref());
}

/* ---- methods ----------------------------------------------------------------------------------------------------------------------------- */

/* Expected by hand: ro has the whole memory, silc goes with no observer, two learners of the torque are one too many. */
static uint16_t refused_beside(uint16_t observer, uint16_t position_method)
{
    if ((position_method == DRIVE_POSITION_SILC) ? (observer != DRIVE_OBSERVER_NONE)
                                                 : ((observer == DRIVE_OBSERVER_RO) && (position_method == DRIVE_POSITION_SRC))) {
        return PARAM_position_method;
    }
    return ((observer >= DRIVE_OBSERVER_RO) && (position_method == DRIVE_POSITION_RDC)) ? PARAM_rdc_learn_gain : PARAM_COUNT;
}

void test_position_every_method_runs_with_and_without_an_observer_or_is_refused(void)
{
    for (uint16_t observer = 0U; observer < 4U; observer++) {
        for (uint16_t position_method = 0U; position_method < 4U; position_method++) {
            for (uint16_t beside = 0U; beside < 2U; beside++) {
                setUp();
                drive_params_t p = params();
                p.method = ((beside == 0U) && (observer > 0U)) ? (uint16_t)(DRIVE_METHOD_DOB + observer - 1U) : DRIVE_METHOD_PI;
                p.disturbance_observer = (beside == 0U) ? 0U : observer;
                p.position_method = position_method;
                p.rdc_learn_gain = 0.3f;
                const uint16_t    culprit = refused_beside(observer, position_method);
                const char *const what = at("observer %u, position method %u", observer, position_method);
                drive_init(&drive, &p);
                drive_start(&drive);
                bench_live(30U);
                if (culprit != (uint16_t)PARAM_COUNT) {
                    samples(20); /* the interrupts go on, with blocks that were never built */
                    ASSERT_FAULT(FAULT_configuration, what);
                    TEST_ASSERT_EQUAL_STRING(params_info(culprit)->name, params_info(drive.fault_detail)->name);
                } else {
                    TEST_ASSERT_EQUAL_INT_MESSAGE(DRIVE_RUN, drive.state, what);
                    go_to(1.0);
                    samples(100);
                    TEST_ASSERT_TRUE(iq_ref() > 0.0);
                    TEST_ASSERT_TRUE(fabs(iq_ref()) <= 10.0 + 1e-5);
                }
            }
        }
    }
}

void test_position_mode_beside_repetitive_control_is_refused_and_so_is_the_other_order(void)
{
    for (uint16_t method = DRIVE_METHOD_CRC; method <= DRIVE_METHOD_FAL_FORC; method++) {
        setUp();
        drive_params_t p = params();
        p.method = method;
        bench_run_with(&p);
        const drive_command_t c = {.mode = DRIVE_MODE_POSITION, .target_rad = 1.0f};
        float                 limit = 0.0f;
        TEST_ASSERT_EQUAL_UINT16(DRIVE_COMMAND_MODE, drive_command_refuses(&drive, &c, &limit));
        TEST_ASSERT_EQUAL_FLOAT((float)DRIVE_MODE_SPEED, limit);
        TEST_ASSERT_FALSE(drive_command(&drive, &c));
        TEST_ASSERT_NOT_EQUAL(DRIVE_MODE_POSITION, drive.command[drive.command_at & 1U].mode);

        p.method = DRIVE_METHOD_PI;
        change_at_rest(&p);
        go_to(1.0);
        drive_stop(&drive);
        drive_background(&drive);
        p.method = method;
        uint16_t culprit = 0U;
        TEST_ASSERT_FALSE(drive_tune(&drive, &p, &culprit));
        TEST_ASSERT_EQUAL_STRING("method", params_info(culprit)->name);
    }
}

/* 20 rad/s at 10 kHz: 3142 samples a turn. In speed mode it is the reference that counts. */
void test_position_repetitive_observer_has_its_period_from_the_motion(void)
{
    drive_params_t p = params();
    p.disturbance_observer = DRIVE_OBSERVER_RO;
    p.profile_speed_rad_s = 20.0f;
    shaft.ideal = true;
    run_with(&p, 1000.0);
    samples(20);
    TEST_ASSERT_UINT_WITHIN(1U, 3142U, drive.observer.observer.state.turn_samples);
    bench_command(DRIVE_MODE_SPEED, 10.0, 0.0, 0.0);
    bench_live(20U);
    TEST_ASSERT_UINT_WITHIN(1U, 6283U, drive.observer.observer.state.turn_samples);
}

/* Without torque delay and with three samples of it: the part that an observer is not to see comes with the torque it is part of. */
void test_position_rdc_says_which_part_of_its_torque_compensates_friction_and_lines(void)
{
    for (uint16_t late = 0U; late < 4U; late += 3U) {
        setUp();
        drive_params_t p = params();
        p.torque_delay_samples = late;
        p.position_method = DRIVE_POSITION_RDC;
        p.rdc_viscous_nms = 0.002f; /* the observer knows viscous friction itself, */
        p.rdc_inertia_kgm2 = 1e-3f; /* and inertia */
        p.rdc_coulomb_nm = 0.0384f;
        p.rdc_static_nm = 0.0384f;
        p.rdc_line1_cycles = 4.0f;
        p.rdc_line1_nm = 0.01f;
        p.rdc_line1_rad = 1.5707963f;
        p.profile_speed_rad_s = 2.0f;
        p.position_kp_per_s = 0.0f;
        p.position_kv_a_per_rad_s = 0.0f;
        const double per_nm = 1.0 / (1.5 * (double)p.pole_pairs * (double)p.motor_psi_wb);
        run_with(&p, 100.0);
        for (int k = 1; k < 100; k++) {
            sample();
            const double known = (k <= (int)late) ? 0.0 : (0.0384 + 0.01 * cos(4.0 * 2.0 * TS * (k - (int)late))) * per_nm;
            TEST_ASSERT_DOUBLE_WITHIN_MESSAGE(2e-5, known, (double)num_to_float(drive.speed.fed) * (double)drive.scale.current_a,
                                              at("sample %d, %u late", k, late));
        }
        bench_command(DRIVE_MODE_SPEED, 0.0, 0.0, 0.0);
        sample();
        TEST_ASSERT_EQUAL_DOUBLE(0.0, (double)num_to_float(drive.speed.fed));
    }
}

void test_position_method_can_be_changed_at_rest(void)
{
    drive_params_t p = params();
    p.profile_speed_rad_s = 5.0f;
    shaft.per_amp = 50.0;
    run_with(&p, 50.0);
    const uint16_t order[] = {1U, 2U, 3U, 2U, 1U, 0U, 3U, 0U};
    for (size_t k = 0; k < COUNT_OF(order); k++) {
        p.position_method = order[k];
        p.position_cells = (uint16_t)(720U - 100U * (k % 3U));
        change_at_rest(&p);
        samples(300);
        ASSERT_NO_FAULT("running");
    }
    TEST_ASSERT_DOUBLE_WITHIN(0.5, 5.0, shaft.speed);
}

void test_position_silc_learns_the_speed_that_is_missing(void)
{
    drive_params_t p = params();
    p.position_method = DRIVE_POSITION_SILC;
    p.ilc_lead = 0U;
    p.ilc_gain = 0.5f;
    p.profile_speed_rad_s = 20.0f;
    run_with(&p, 1000.0);
    see(0.0);
    samples(1);
    spin(19.0, 330); /* a turn, 1 rad/s too slow */
    const uint16_t cells = drive.position.ilc.state.grid.cells;
    TEST_ASSERT_EQUAL_UINT16(720U, cells);
    double mean = 0.0;
    for (uint16_t i = 100U; i < 600U; i++) {
        mean += (double)num_to_float(drive.position.ilc.state.grid.cell[i]) * (double)drive.scale.speed_rad_s / 500.0;
    }
    TEST_ASSERT_DOUBLE_WITHIN(0.02, 0.5, mean);

    /* and it is still there after a time in speed mode */
    const num_t kept = drive.position.ilc.state.grid.cell[300];
    bench_command(DRIVE_MODE_SPEED, 0.0, 0.0, 0.0);
    spin(0.0, 5);
    go_to(shaft.theta);
    spin(0.0, 5);
    ASSERT_SAME_BITS(kept, drive.position.ilc.state.grid.cell[300]);
}

/* src is plugged in before its own correction: what it learns is speed command plus k_pp times error less speed */
void test_position_src_learns_from_the_error_of_the_velocity_loop(void)
{
    drive_params_t p = params();
    p.position_method = DRIVE_POSITION_SRC;
    p.profile_speed_rad_s = 20.0f;
    run_with(&p, 1000.0);
    samples(1);
    for (int k = 0; k < 70; k++) { /* 1.3 rad: nothing has come back yet */
        spin(19.0, 1);
        const double e = KPP * following() - 19.0;
        TEST_ASSERT_DOUBLE_WITHIN_MESSAGE(
            0.01, e, (double)num_to_float(drive.position.src.state.written) * (double)drive.scale.speed_rad_s,
            at("sample %d", k));
    }
}

static drive_params_t rdc_alone(void)
{
    drive_params_t p = params();
    p.position_method = DRIVE_POSITION_RDC;
    p.position_kp_per_s = 0.0f;
    p.position_kv_a_per_rad_s = 0.0f;
    p.rdc_inertia_kgm2 = 1e-3f;
    p.rdc_viscous_nms = 0.0f;
    p.profile_speed_rad_s = 20.0f;
    p.rdc_rho_nm = 0.0384f; /* 1 A */
    p.rdc_sigma = 0.01f;
    return p;
}

void test_position_rdc_robust_term_drives_towards_the_command(void)
{
    for (int sign = -1; sign <= 1; sign += 2) {
        for (int row = 0; row < 3; row++) {
            setUp();
            drive_params_t p = rdc_alone();
            p.rdc_p31 = (row == 0) ? 0.1f : 0.0f;
            p.rdc_p32 = (row == 1) ? 1e-3f : 0.0f;
            p.rdc_p33 = (row == 2) ? 5e-4f : 0.0f;
            run_with(&p, 1000.0 * sign);
            samples(100); /* held: all three errors point the same way */
            TEST_ASSERT_DOUBLE_WITHIN_MESSAGE(1e-4, 1.0 * sign, iq_ref(), at("row %d", row));
            TEST_ASSERT_DOUBLE_WITHIN(1e-4, 1.0 * sign, signal(SIGNAL_robust_a));
        }
    }
}

void test_position_rdc_learns_the_robust_torque_slowly(void)
{
    drive_params_t p = rdc_alone();
    p.rdc_p33 = 5e-4f;
    p.rdc_learn_gain = 0.25f;
    run_with(&p, 1000.0);
    samples(1);
    spin(18.0, 349); /* a turn; 2 rad/s too slow: the bound, 1 A */
    for (uint16_t i = 10U; i < 700U; i += 23U) {
        TEST_ASSERT_DOUBLE_WITHIN_MESSAGE(
            1e-3, 0.25, (double)num_to_float(drive.position.learn.state.grid.cell[i]) * (double)drive.scale.current_a,
            at("cell %u", i));
    }
}

/* 1.9 A from the model, 2 A allowed: the integral part may not go on when the sum is at the limit */
void test_position_integral_part_holds_when_model_and_feedback_together_are_limited(void)
{
    drive_params_t p = rdc_alone();
    p.position_kp_per_s = (float)KPP;
    p.position_kv_a_per_rad_s = 0.1f;
    p.rdc_rho_nm = 0.0f;
    p.iq_limit_a = 2.0f;
    p.rdc_line1_nm = 1.9f * 0.0384f;
    p.rdc_line1_rad = 1.5707963f; /* a line of no cycles: a constant */
    run_with(&p, 0.1);
    samples(2000);
    TEST_ASSERT_DOUBLE_WITHIN(1e-3, 2.0, iq_ref());
    TEST_ASSERT_TRUE((double)num_to_float(drive.position.pi.state.x) * (double)drive.scale.current_a < 0.02);
}

void test_position_rdc_adds_the_friction_of_the_command(void)
{
    drive_params_t p = params();
    p.position_method = DRIVE_POSITION_RDC;
    p.rdc_viscous_nms = 0.002f;
    p.rdc_coulomb_nm = 0.0384f;
    p.rdc_static_nm = 0.0384f;
    p.rdc_line1_cycles = 4.0f;
    p.rdc_line1_nm = 0.01f;
    p.rdc_line1_rad = 1.5707963f;
    p.profile_speed_rad_s = 2.0f;
    p.position_kp_per_s = 0.0f;
    p.position_kv_a_per_rad_s = 0.0f;
    const double per_nm = 1.0 / (1.5 * (double)p.pole_pairs * (double)p.motor_psi_wb);
    run_with(&p, 100.0);
    for (int k = 1; k < 200; k++) {
        sample();
        const double want = (0.0384 + 0.002 * 2.0 + 0.01 * cos(4.0 * 2.0 * TS * k)) * per_nm;
        TEST_ASSERT_DOUBLE_WITHIN_MESSAGE(2e-5, want, iq_ref(), at("sample %d", k));
    }
}

/* ---- refused ------------------------------------------------------------------------------------------------------------------------------ */

static void assert_refused(const drive_params_t *p, uint16_t param, const char *text)
{
    uint16_t culprit = PARAM_COUNT;

    TEST_ASSERT_FALSE_MESSAGE(drive_tune(&drive, p, &culprit), text);
    TEST_ASSERT_EQUAL_STRING_MESSAGE(params_info(param)->name, params_info(culprit)->name, text);
    TEST_ASSERT_EQUAL_INT(DRIVE_RUN, drive.state);
}

void test_position_parameters_that_do_not_fit_are_refused_by_name(void)
{
    const drive_params_t good = params();
    run_with(&good, 0.0);
    drive_params_t p = good;
    p.rdc_coulomb_nm = 0.5f;
    p.rdc_static_nm = 0.4f;
    assert_refused(&p, PARAM_rdc_static_nm, "static below Coulomb");
    p = good;
    p.position_min_turn = 2.0f;
    p.position_max_turn = 2.0f;
    assert_refused(&p, PARAM_position_min_turn, "no room between the limits");
    p.position_max_turn = 1.0f;
    assert_refused(&p, PARAM_position_min_turn, "limits the wrong way round");
    p = good;
    p.profile_speed_rad_s = 0.0f;
    assert_refused(&p, PARAM_profile_speed_rad_s, "no speed");
    p.profile_speed_rad_s = 3200.0f;
    assert_refused(&p, PARAM_profile_speed_rad_s, "more than half a turn per sample");
    p = good;
    p.homing_speed_rad_s = 0.0f;
    assert_refused(&p, PARAM_homing_speed_rad_s, "no homing speed");
    p = good;
    p.profile_accel_rad_s2 = -1.0f;
    assert_refused(&p, PARAM_profile_accel_rad_s2, "negative acceleration");
    p = good;
    p.profile_smooth_samples = 65U;
    assert_refused(&p, PARAM_profile_smooth_samples, "too long a mean");
    p = good;
    p.torque_delay_samples = 8U;
    assert_refused(&p, PARAM_torque_delay_samples, "too long a delay");
    p = good;
    p.rdc_inertia_kgm2 = -1e-3f;
    assert_refused(&p, PARAM_rdc_inertia_kgm2, "negative inertia");
    p = good;
    p.following_error_rad = NAN;
    assert_refused(&p, PARAM_following_error_rad, "not a number");
    p = good;
    p.src_period_turn = 1.0f;
    assert_refused(&p, PARAM_src_period_turn, "no delay");
}

void test_position_acceleration_too_fine_for_the_step_is_the_slowest_there_is(void)
{
    drive_params_t p = params();
    p.profile_accel_rad_s2 = 1e-6f; /* 7e-4 steps of 2^-32 turn per sample^2 */
    run_with(&p, 1.0);
    samples(100);
    TEST_ASSERT_TRUE(drive.setup->position.profile.acceleration == 1);
    TEST_ASSERT_TRUE(command_now() > 0.0);
}
