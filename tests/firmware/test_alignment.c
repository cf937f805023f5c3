/* firmware/app/alignment.c on the bench: order, vector, damping, and what the motion of a rotor shows. */
#include "mock_hal_clock.h"
#include "mock_hal_encoder.h"
#include "mock_hal_inverter.h"
#include "mock_hal_sample.h"
#include "tests/firmware/support/bench.h"

#define VOLT_TOLERANCE 2e-3 /* steps of the fixed build, and a vector that turns by 0.1 degrees in a period */
#define KP 0.6
#define CURRENT 2.0
#define PULL_QUARTERS 6U

static drive_params_t p;

void setUp(void)
{
    bench_start();
    p = bench_params();
    p.align_periods = 36000U; /* a quarter turn of the vector in 1000 */
    p.align_current_a = (float)CURRENT;
}
void tearDown(void) {}

static void begin(void)
{
    drive_init(&drive, &p);
    drive_background(&drive);
    drive_start(&drive);
    drive_background(&drive);
    TEST_ASSERT_EQUAL_INT(DRIVE_ALIGN, drive.state);
}

static void into_pull(void)
{
    begin();
    bench_live(BENCH_WAIT_PERIODS);
    drive_background(&drive);
    TEST_ASSERT_TRUE(bench.armed);
}

static void assert_vector(double length, double angle, const char *text)
{
    double alpha, beta;
    bench_voltage(&alpha, &beta);
    TEST_ASSERT_DOUBLE_WITHIN_MESSAGE(VOLT_TOLERANCE, length * cos(angle), alpha, text);
    TEST_ASSERT_DOUBLE_WITHIN_MESSAGE(VOLT_TOLERANCE, length * sin(angle), beta, text);
}

/* ---- before ------------------------------------------------------------------------------------------------------------ */

static void turn_by_hand(uint32_t periods, double speed)
{
    static double angle;
    for (uint32_t k = 0U; k < periods; k++) {
        angle += speed * 1e-4;
        bench_angle(angle);
        bench_live(1U);
        if (k % 10U == 0U) {
            drive_background(&drive);
        }
    }
}

void test_alignment_waits_with_the_bridge_off_until_the_shaft_rests(void)
{
    p.align_rest_s = 2.0f;
    begin();
    turn_by_hand(15000U, 5.0);
    TEST_ASSERT_EQUAL_UINT32(0U, bench.arms);
    TEST_ASSERT_EQUAL_INT(DRIVE_ALIGN, drive.state);
    bench_live(2100U);
    TEST_ASSERT_EQUAL_UINT32(1U, bench.arms);
    ASSERT_NO_FAULT("it came to rest");
}

void test_alignment_of_a_shaft_that_does_not_come_to_rest_is_a_fault_of_its_own(void)
{
    for (int way = -1; way <= 1; way += 2) {
        bench_start();
        p.align_rest_s = 0.5f;
        begin();
        turn_by_hand(4900U, 0.5 * way); /* slower than 5 r/min */
        ASSERT_NO_FAULT("not yet");
        turn_by_hand(200U, 0.5 * way);
        ASSERT_FAULT(FAULT_align_turning, at("way %d", way));
        TEST_ASSERT_EQUAL_UINT32(0U, bench.arms);
    }
}

/* ---- the vector -------------------------------------------------------------------------------------------------------- */

void test_alignment_current_rises_on_a_vector_a_quarter_turn_before_its_begin(void)
{
    into_pull();
    bench_periods(500U); /* of 2000 */
    assert_vector(KP * CURRENT / 4.0, -PI_OF_CIRCLE / 2.0, "rising");
    bench_periods(2000U);
    assert_vector(KP * CURRENT, -PI_OF_CIRCLE / 2.0, "there");
    bench_periods(500U);
    bench_live(2500U);
    bench_live(300U);
    assert_vector(KP * CURRENT, 0.0, "and at its begin");
}

void test_alignment_current_is_cut_to_the_limits_of_the_drive(void)
{
    p.align_current_a = 15.0f; /* more than over_current_a is refused before */
    p.iq_limit_a = 2.0f;
    into_pull();
    bench_periods(2500U);
    assert_vector(KP * 2.0, -PI_OF_CIRCLE / 2.0, "iq_limit_a");
    bench_start();
    p.iq_limit_a = 10.0f;
    p.id_limit_a = 1.0f;
    into_pull();
    bench_periods(2500U);
    assert_vector(KP * 1.0, -PI_OF_CIRCLE / 2.0, "id_limit_a");
}

void test_alignment_controls_the_current_along_its_vector(void)
{
    into_pull();
    bench_periods(2500U);
    bench_currents(1.5, 0.5, -PI_OF_CIRCLE / 2.0);
    bench_period();

    double alpha, beta;
    bench_voltage(&alpha, &beta);
    TEST_ASSERT_DOUBLE_WITHIN(VOLT_TOLERANCE, -KP * 0.5, alpha); /* errors 0.5 and -0.5 A on d and q, turned by -90 degrees */
    TEST_ASSERT_DOUBLE_WITHIN(VOLT_TOLERANCE, -KP * 0.5, beta);
}

/* The vector moves against what the rotor has just done, by four times of it, at most by 60 degrees. */
void test_alignment_vector_goes_against_the_motion_of_the_rotor(void)
{
    const double step[] = {0.02, 0.1, 2.0};
    for (size_t k = 0; k < COUNT_OF(step); k++) {
        for (int way = -1; way <= 1; way += 2) {
            bench_start();
            into_pull();
            bench_periods(2500U);
            bench_angle(step[k] * way / 4.0);
            bench_periods(1U);
            assert_vector(KP * CURRENT, -PI_OF_CIRCLE / 2.0 - fmin(4.0 * step[k], PI_OF_CIRCLE / 3.0) * way,
                          at("step %g", step[k] * way));
            bench_periods(400U); /* 3 time constants of 128 periods */
            double alpha, beta;
            bench_voltage(&alpha, &beta);
            TEST_ASSERT_DOUBLE_WITHIN_MESSAGE(4.0 * step[k] * 0.06, -PI_OF_CIRCLE / 2.0, atan2(beta, alpha),
                                              at("after %g", step[k] * way));
        }
    }
}

/* ---- what the motion says ---------------------------------------------------------------------------------------------- */

static void align(double rotor_pairs)
{
    drive_init(&drive, &p);
    drive_background(&drive);
    bench_rotor(rotor_pairs, 2.0);
    bench_align();
}

void test_alignment_of_a_rotor_that_follows_ends_in_run(void)
{
    for (uint16_t turns = 1U; turns <= 4U; turns++) {
        bench_start();
        p.align_turns = turns;
        align(4.0);
        TEST_ASSERT_EQUAL_INT_MESSAGE(DRIVE_RUN, drive.state, at("%u turns", turns));
    }
}

void test_alignment_vector_turns_as_often_as_asked_for_both_ways(void)
{
    for (uint16_t turns = 1U; turns <= 4U; turns += 3U) {
        bench_start();
        p.align_turns = turns;
        drive_init(&drive, &p);
        drive_background(&drive);
        bench_rotor(4.0, 0.0);
        drive_start(&drive);
        double most = 0.0, least = 0.0;
        for (int k = 0; (k < 6000) && (drive.state != DRIVE_RUN); k++) {
            bench_live(10U);
            most = fmax(most, bench.rotor_e);
            least = fmin(least, bench.rotor_e);
        }
        /* the whole turns, a quarter and a half to get into motion, and a part of a quarter to turn round */
        TEST_ASSERT_DOUBLE_WITHIN(0.5, turns + 0.5, (most - least) / TWO_PI - 0.25);
    }
}

void test_alignment_against_a_shaft_that_stands_is_a_fault_of_its_own(void)
{
    into_pull();
    bench_live(40000U);
    ASSERT_FAULT(FAULT_align_blocked, "no motion");
    TEST_ASSERT_FALSE(drive_zero_is_known(&drive));
}

void test_alignment_of_an_encoder_that_counts_down_says_so(void)
{
    align(-4.0);
    ASSERT_FAULT(FAULT_align_direction, "no parameter");
    bench_start();
    p.encoder_reversed = 1U;
    align(-4.0);
    TEST_ASSERT_EQUAL_INT(DRIVE_RUN, drive.state);
    bench_start();
    align(4.0);
    ASSERT_FAULT(FAULT_align_direction, "parameter for nothing");
}

void test_alignment_with_other_pole_pairs_says_how_many_there_are(void)
{
    const uint16_t pairs[] = {1U, 2U, 3U, 4U, 5U, 7U, 10U};
    for (size_t k = 0; k < COUNT_OF(pairs); k++) {
        for (size_t m = 0; m < COUNT_OF(pairs); m++) {
            const uint16_t set = pairs[k];
            const uint16_t true_pairs = pairs[m];
            bench_start();
            p.pole_pairs = set;
            align((double)true_pairs);
            if (set == true_pairs) {
                TEST_ASSERT_EQUAL_INT_MESSAGE(DRIVE_RUN, drive.state, at("%u pole pairs", set));
            } else {
                TEST_ASSERT_EQUAL_INT_MESSAGE(DRIVE_FAULT, drive.state, at("%u of %u", set, true_pairs));
                const bool reported = (drive.fault == FAULT_align_pole_pairs) && (drive.fault_detail == true_pairs);
                TEST_ASSERT_TRUE_MESSAGE(
                    reported || (set >= 2U * true_pairs), /* then its damping is too strong */
                    at("%u of %u: %s, %u", set, true_pairs, faults_info((uint16_t)drive.fault)->name, drive.fault_detail));
            }
        }
    }
}

/* ---- what cannot work is refused beforehand ----------------------------------------------------------------------------- */

static void assert_refused(uint16_t culprit)
{
    drive_init(&drive, &p);
    ASSERT_FAULT(FAULT_configuration, params_info(culprit)->name);
    TEST_ASSERT_EQUAL_STRING(params_info(culprit)->name, params_info(drive.fault_detail)->name);
}

void test_alignment_that_is_too_short_for_its_turns_is_refused(void)
{
    p.align_periods = BENCH_ALIGN_PERIODS - 1U;
    assert_refused(PARAM_align_periods);
    p.align_periods = BENCH_ALIGN_PERIODS;
    drive_init(&drive, &p);
    ASSERT_NO_FAULT("just enough");
    p.align_turns = 2U;
    assert_refused(PARAM_align_periods);
    p.align_periods = 0U;
    drive_init(&drive, &p);
    ASSERT_NO_FAULT("none at all");
}

void test_alignment_with_an_encoder_of_a_few_counts_is_refused(void)
{
    p.encoder_counts = 31.0f;
    assert_refused(PARAM_encoder_counts);
    p.encoder_counts = 32.0f;
    drive_init(&drive, &p);
    ASSERT_NO_FAULT("8 in an electrical turn");
}
