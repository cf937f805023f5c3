/* firmware/app/speed_isr.c: speed, error, correction, q-current reference, and when it acts. */
#include "firmware/app/internal.h"
#include "firmware/app/telemetry.h"
#include "mock_hal_clock.h"
#include "mock_hal_encoder.h"
#include "mock_hal_inverter.h"
#include "mock_hal_limits.h"
#include "mock_hal_sample.h"
#include "tests/firmware/support/bench.h"

#define KP 0.0368 /* A per electrical rad/s */
#define KI_TS 0.92e-3
#define GAIN 4.0 /* electrical rad/s per mechanical rad/s */

/* An ampere out of some operations on floats up to 10; in fixed point 4 steps of 6e-8 of the base of 10 A, and the gain of
 * 2.4 per unit of them. */
#define AMP_TOLERANCE 1e-5

void setUp(void) { bench_start(); }
void tearDown(void) {}

static double iq_ref(void) { return (double)telemetry_read(&drive, SIGNAL_iq_ref_a); }
static double speed(void) { return (double)telemetry_read(&drive, SIGNAL_speed_rad_s); }
static double correction(void) { return (double)telemetry_read(&drive, SIGNAL_rc_out_unit); }

/* From one speed sample to the next; the current interrupt of the next tick has not run. */
static void speed_period(void) { bench_periods(10U); }

/* The drive runs at the tick: the next period is one with a speed sample. Inline, so that its output shows at once. */
static void run_inline(drive_params_t p)
{
    p.speed_inline = 1U;
    bench_run_with(&p);
}

/* ---- PI ------------------------------------------------------------------------------------------------------------- */

/* rotor at rest, reference 0.5 rad/s: error 2 electrical rad/s */
void test_speed_isr_pi_output_is_that_of_a_hand_calculation(void)
{
    run_inline(bench_params());
    bench_command(DRIVE_MODE_SPEED, 0.5, 0.0, 0.0);
    for (int k = 0; k < 50; k++) {
        bench_period();
        TEST_ASSERT_DOUBLE_WITHIN(AMP_TOLERANCE, 2.0 * (KP + KI_TS * k), iq_ref());
        bench_periods(9U);
        TEST_ASSERT_DOUBLE_WITHIN(AMP_TOLERANCE, 2.0 * (KP + KI_TS * k), iq_ref()); /* held in between */
    }
}

void test_speed_isr_unit_of_the_error_multiplies_both_gains(void)
{
    drive_params_t p = bench_params();
    p.speed_error_gain = 9.5493f; /* r/min */
    run_inline(p);
    bench_command(DRIVE_MODE_SPEED, -1.0, 0.0, 0.0);
    bench_periods(11U);

    TEST_ASSERT_DOUBLE_WITHIN(AMP_TOLERANCE, -9.5493 * (KP + KI_TS), iq_ref());
}

/* The textbook controller with set-point weight b: KP (b r - y) + KI integral of (r - y); rotor at rest, r = 2 units. */
void test_speed_isr_set_point_weight_is_that_of_the_proportional_part(void)
{
    const double weight[] = {0.0, 0.25, 1.0};
    for (size_t w = 0; w < COUNT_OF(weight); w++) {
        setUp();
        drive_params_t p = bench_params();
        p.speed_setpoint_weight = (float)weight[w];
        run_inline(p);
        bench_command(DRIVE_MODE_SPEED, 0.5, 0.0, 0.0);
        for (int k = 0; k < 200; k++) {
            bench_period();
            TEST_ASSERT_DOUBLE_WITHIN_MESSAGE(3.0 * AMP_TOLERANCE, 2.0 * (KP * weight[w] + KI_TS * k), iq_ref(),
                                              at("weight %g, sample %d", weight[w], k));
            bench_periods(9U);
        }
        bench_command(DRIVE_MODE_CURRENT, 0.0, 0.0, 0.0); /* and again, from the speed there is */
        bench_periods(20U);
        bench_command(DRIVE_MODE_SPEED, 0.5, 0.0, 0.0);
        bench_period();
        TEST_ASSERT_DOUBLE_WITHIN(3.0 * AMP_TOLERANCE, 2.0 * KP * weight[w], iq_ref());
    }
}

/* 4000 counts at 10 kHz: 1500 r/min are 10 counts a sample in every turn, 0 waves; 1507.5 r/min are 10.05, 19.9 waves of 398.01 samples.
 * To 0.38 waves, or to 25.38. */
void test_speed_isr_with_aro_lets_the_rounding_of_the_encoder_drift_by_some_counts_per_turn(void)
{
    static const struct {
        uint16_t method;
        float    sync_hz;
        double   rpm, counts, more;
    } CASES[] = {{DRIVE_METHOD_ARO, 5000.0f, 1500.0, 0.62, 0.38},  {DRIVE_METHOD_ARO, 5000.0f, -1500.0, 0.62, 0.38},
                 {DRIVE_METHOD_ARO, 5000.0f, 1500.0, 26.0, 25.38}, {DRIVE_METHOD_ARO, 5000.0f, 1500.0, 0.31, 0.0},
                 {DRIVE_METHOD_ARO, 5000.0f, 1507.5, 26.0, 5.48},  {DRIVE_METHOD_ARO, 0.0f, 1500.0, 0.62, 0.0},
                 {DRIVE_METHOD_ARO, 5000.0f, 1500.0, 0.0, 0.0},    {DRIVE_METHOD_PI, 5000.0f, 1500.0, 0.62, 0.0}};
    for (size_t i = 0; i < COUNT_OF(CASES); i++) {
        setUp();
        drive_params_t p = bench_params();
        p.speed_error_gain = 0.1f;
        p.method = CASES[i].method;
        p.aro_sync_hz = CASES[i].sync_hz;
        p.aro_drift_counts = (float)CASES[i].counts;
        run_inline(p);
        const double ref = CASES[i].rpm * 3.14159265358979 / 30.0;
        bench_command(DRIVE_MODE_SPEED, ref, 0.0, 0.0);
        drive_background(&drive);
        bench_period();

        const bool   whole = (CASES[i].rpm * CASES[i].rpm) == (1500.0 * 1500.0); /* either side of it will do */
        const double current =
            (whole && (iq_ref() * ref < KP * 0.1 * ref * ref)) ? ((2.0 * KP * 0.1 * ref) - iq_ref()) : iq_ref();
        TEST_ASSERT_DOUBLE_WITHIN_MESSAGE(2.0 * AMP_TOLERANCE, KP * 0.1 * ref * (1.0 + (CASES[i].more / 4000.0)), current,
                                          at("case %u", (unsigned)i)); /* 0.38 counts: 6e-5 A */
    }
}

void test_speed_isr_nothing_drifts_in_other_modes_and_after_the_observer_is_gone(void)
{
    drive_params_t p = bench_params();
    p.disturbance_observer = DRIVE_OBSERVER_ARO;
    p.aro_sync_hz = 5000.0f;
    p.aro_drift_counts = 0.62f;
    bench_run_with(&p);
    const uint16_t modes[] = {DRIVE_MODE_CURRENT, DRIVE_MODE_POSITION};
    for (size_t m = 0; m < COUNT_OF(modes); m++) {
        bench_command(DRIVE_MODE_SPEED, 50.0 * 3.14159265358979, 0.0, 0.0);
        drive_background(&drive);
        TEST_ASSERT_TRUE_MESSAGE(drive.speed.drift != (num_t)0, at("before mode %u", (unsigned)modes[m]));
        bench_command((drive_mode_t)modes[m], 0.0, 0.0, 0.0);
        drive_background(&drive);
        ASSERT_NUM_WITHIN_AT(0.0, 0.0, drive.speed.drift, at("mode %u", (unsigned)modes[m]));
    }
    bench_command(DRIVE_MODE_SPEED, 50.0 * 3.14159265358979, 0.0, 0.0);
    drive_background(&drive);
    TEST_ASSERT_TRUE(drive.speed.drift != (num_t)0);
    drive_stop(&drive);
    drive_background(&drive);
    p.disturbance_observer = DRIVE_OBSERVER_NONE;
    uint16_t culprit = 0U;
    TEST_ASSERT_TRUE_MESSAGE(drive_tune(&drive, &p, &culprit), params_info(culprit)->name);
    bench_period();
    drive_background(&drive);
    ASSERT_NUM_WITHIN(0.0, 0.0, drive.speed.drift);
}

void test_speed_isr_sample_time_follows_the_divider(void)
{
    drive_params_t p = bench_params();
    p.speed_divider = 25U;
    run_inline(p);
    bench_command(DRIVE_MODE_SPEED, 0.5, 0.0, 0.0);
    bench_periods(26U);

    TEST_ASSERT_DOUBLE_WITHIN(AMP_TOLERANCE, 2.0 * (KP + 2.5 * KI_TS), iq_ref());
}

void test_speed_isr_output_is_cut_to_the_limit_in_both_directions(void)
{
    run_inline(bench_params());
    bench_command(DRIVE_MODE_SPEED, 300.0, 0.0, 0.0);
    bench_period();
    TEST_ASSERT_DOUBLE_WITHIN(AMP_TOLERANCE, 10.0, iq_ref());

    bench_command(DRIVE_MODE_SPEED, -300.0, 0.0, 0.0);
    speed_period();
    TEST_ASSERT_DOUBLE_WITHIN(AMP_TOLERANCE, -10.0, iq_ref());
}

void test_speed_isr_integral_part_holds_while_the_error_pushes_into_the_limit(void)
{
    run_inline(bench_params());
    bench_command(DRIVE_MODE_SPEED, 80.0, 0.0, 0.0); /* 320 units: 11.8 A */
    bench_periods(1000U);
    bench_command(DRIVE_MODE_SPEED, 0.5, 0.0, 0.0);
    bench_periods(10U);

    TEST_ASSERT_DOUBLE_WITHIN(AMP_TOLERANCE, 2.0 * KP, iq_ref());
}

/* x = 9.9 A first; then an error of -40 units keeps the sum at 8.4 A, and the integral part comes down at once */
void test_speed_isr_integral_part_moves_when_the_error_pulls_out_of_the_limit(void)
{
    run_inline(bench_params());
    bench_command(DRIVE_MODE_SPEED, 60.0, 0.0, 0.0); /* 240 units: 8.832 A, and 0.2208 A per sample until 10 A */
    bench_period();
    speed_period();
    TEST_ASSERT_DOUBLE_WITHIN(AMP_TOLERANCE, 240.0 * (KP + KI_TS), iq_ref());
    for (int k = 0; k < 20; k++) {
        speed_period();
    }
    TEST_ASSERT_DOUBLE_WITHIN(AMP_TOLERANCE, 10.0, iq_ref());
    /* proposals 240 (KP + KI_TS k): k = 5 gives 9.936 and is taken, k = 6 gives 10.157 and holds: x = 240 KI_TS 6 */
    const double x = 240.0 * KI_TS * 6.0;

    bench_command(DRIVE_MODE_SPEED, -10.0, 0.0, 0.0);
    speed_period();
    TEST_ASSERT_DOUBLE_WITHIN(2.0 * AMP_TOLERANCE, x - 40.0 * KP, iq_ref());
    speed_period();
    TEST_ASSERT_DOUBLE_WITHIN(2.0 * AMP_TOLERANCE, x - 40.0 * (KP + KI_TS), iq_ref());
}

void test_speed_isr_reference_shows_in_telemetry(void)
{
    run_inline(bench_params());
    bench_command(DRIVE_MODE_SPEED, 15.708, 0.0, 0.0);
    bench_period();

    TEST_ASSERT_EQUAL_FLOAT(15.708f, telemetry_read(&drive, SIGNAL_speed_ref_rad_s));
}

/* ---- ramp ----------------------------------------------------------------------------------------------------------- */

static double ref(void) { return (double)telemetry_read(&drive, SIGNAL_speed_ref_rad_s); }

void test_speed_isr_reference_goes_to_the_speed_asked_for_at_the_acceleration_set(void)
{
    drive_params_t p = bench_params();
    p.speed_ramp_rad_s2 = 200.0f;
    run_inline(p);
    bench_command(DRIVE_MODE_SPEED, 5.05, 0.0, 0.0);
    for (int k = 1; k <= 40; k++) { /* 0.2 rad/s in each sample of 1 ms, from the rotor's 0 */
        bench_period();
        TEST_ASSERT_DOUBLE_WITHIN_MESSAGE(1e-5, (0.2 * k < 5.05) ? (0.2 * k) : 5.05, ref(), at("sample %d", k));
        bench_periods(9U);
    }
    TEST_ASSERT_EQUAL_FLOAT(5.05f, telemetry_read(&drive, SIGNAL_speed_ref_rad_s)); /* as it was commanded, bit for bit */
}

void test_speed_isr_jerk_makes_the_ramp_an_s_curve(void)
{
    drive_params_t p = bench_params();
    p.speed_ramp_rad_s2 = 200.0f;
    p.speed_jerk_rad_s3 = 20000.0f; /* 10 ms until the acceleration is there */
    run_inline(p);
    bench_command(DRIVE_MODE_SPEED, -6.0, 0.0, 0.0);
    double before = 0.0;
    double steps = 0.0;
    int    samples = 0;
    while ((ref() > -6.0) && (samples < 100)) {
        bench_periods(10U);
        samples++;
        const double step = ref() - before;
        TEST_ASSERT_TRUE_MESSAGE(fabs(step) < 0.2 + 1e-5, at("acceleration in sample %d", samples));
        TEST_ASSERT_TRUE_MESSAGE(fabs(step - steps) < 0.02 + 1e-5, at("jerk in sample %d", samples));
        steps = step;
        before = ref();
    }
    /* 6 / 200 s and 200 / 20000 s, less the sample in which it would stand; at most one more, since the steps are whole numbers */
    TEST_ASSERT_INT_WITHIN(1, 30 + 10 - 1, samples);
}

/* 2 rad/s: the tracking filter is about to find out that the rotor of the bench does not turn any more */
void test_speed_isr_ramp_begins_at_the_speed_there_is(void)
{
    drive_params_t p = bench_params();
    p.speed_ramp_rad_s2 = 100.0f;
    p.speed_source = DRIVE_SPEED_PLL;
    run_inline(p);
    bench_command(DRIVE_MODE_CURRENT, 0.0, 0.0, 0.0);
    bench_spin(50.0, 1.0);
    bench_periods(10U);
    const double there = speed();
    bench_command(DRIVE_MODE_SPEED, 300.0, 0.0, 0.0);
    speed_period();
    TEST_ASSERT_DOUBLE_WITHIN_MESSAGE(2.0, there + 0.1, ref(), at("speed %g", there));
    bench_command(DRIVE_MODE_CURRENT, 0.0, 0.0, 0.0);
    speed_period();
    const double later = speed();
    bench_command(DRIVE_MODE_SPEED, 300.0, 0.0, 0.0);
    speed_period();
    TEST_ASSERT_DOUBLE_WITHIN_MESSAGE(2.0, later + 0.1, ref(), "again, not from where the ramp was");
}

void test_speed_isr_ramp_steeper_than_its_numbers_and_jerk_without_ramp_are_refused(void)
{
    drive_params_t p = bench_params();
    p.speed_ramp_rad_s2 = 1.0e5f;
    p.speed_divider = 52U; /* 520 rad/s in a sample; 512 fit */
    drive_init(&drive, &p);
    TEST_ASSERT_EQUAL_INT(FAULT_configuration, drive.fault);
    TEST_ASSERT_EQUAL_UINT16(PARAM_speed_ramp_rad_s2, drive.fault_detail);
    p.speed_divider = 51U;
    drive_init(&drive, &p);
    TEST_ASSERT_EQUAL_INT(FAULT_none, drive.fault);
    p.speed_ramp_rad_s2 = 0.0f;
    p.speed_jerk_rad_s3 = 1.0f;
    drive_init(&drive, &p);
    TEST_ASSERT_EQUAL_UINT16(PARAM_speed_jerk_rad_s3, drive.fault_detail);
}

/* ---- inline or in its own interrupt --------------------------------------------------------------------------------- */

void test_speed_isr_inline_output_acts_in_the_same_period(void)
{
    run_inline(bench_params());
    bench_command(DRIVE_MODE_SPEED, 0.5, 0.0, 0.0);
    bench_period();

    TEST_ASSERT_DOUBLE_WITHIN(AMP_TOLERANCE, 2.0 * KP, iq_ref());
}

void test_speed_isr_in_its_own_interrupt_the_output_acts_one_period_later(void)
{
    drive_params_t p = bench_params();
    bench_run_with(&p);
    bench_command(DRIVE_MODE_SPEED, 0.5, 0.0, 0.0);
    bench_period();
    TEST_ASSERT_EQUAL_UINT32(1U, bench.requests);
    TEST_ASSERT_DOUBLE_WITHIN(1e-9, 0.0, iq_ref());

    bench_period();
    TEST_ASSERT_DOUBLE_WITHIN(AMP_TOLERANCE, 2.0 * KP, iq_ref());
}

void test_speed_isr_in_its_own_interrupt_does_nothing_when_the_loop_is_inline(void)
{
    run_inline(bench_params());
    bench_command(DRIVE_MODE_SPEED, 0.5, 0.0, 0.0);
    bench_period();
    for (int k = 0; k < 10; k++) {
        drive_speed_isr(&drive);
    }
    bench_period();

    TEST_ASSERT_DOUBLE_WITHIN(AMP_TOLERANCE, 2.0 * KP, iq_ref());
}

/* ---- modes ---------------------------------------------------------------------------------------------------------- */

void test_speed_isr_entering_current_mode_clears_the_integral_part(void)
{
    run_inline(bench_params());
    bench_command(DRIVE_MODE_SPEED, 20.0, 0.0, 0.0);
    bench_periods(500U);
    TEST_ASSERT_TRUE(iq_ref() > 5.0);
    bench_command(DRIVE_MODE_CURRENT, 0.0, 0.0, 0.25);
    bench_periods(10U);
    TEST_ASSERT_DOUBLE_WITHIN(AMP_TOLERANCE, 0.25, iq_ref());

    bench_command(DRIVE_MODE_SPEED, 0.5, 0.0, 0.0);
    bench_periods(10U);

    TEST_ASSERT_DOUBLE_WITHIN(AMP_TOLERANCE, 2.0 * KP, iq_ref());
}

void test_speed_isr_current_mode_acts_at_once(void)
{
    run_inline(bench_params());
    bench_command(DRIVE_MODE_SPEED, 20.0, 0.0, 0.0);
    bench_periods(13U);
    bench_command(DRIVE_MODE_CURRENT, 0.0, 0.0, -1.25);
    bench_period();

    TEST_ASSERT_DOUBLE_WITHIN(AMP_TOLERANCE, -1.25, iq_ref());
}

void test_speed_isr_d_reference_acts_in_speed_mode_too(void)
{
    run_inline(bench_params());
    bench_command(DRIVE_MODE_SPEED, 0.5, -3.0, 7.0);
    bench_period();

    TEST_ASSERT_DOUBLE_WITHIN(AMP_TOLERANCE, -3.0, (double)telemetry_read(&drive, SIGNAL_id_ref_a));
    TEST_ASSERT_DOUBLE_WITHIN(AMP_TOLERANCE, 2.0 * KP, iq_ref());
}

void test_speed_isr_loop_rests_until_the_drive_runs(void)
{
    drive_params_t p = bench_params();
    p.speed_inline = 1U;
    drive_init(&drive, &p);
    bench_command(DRIVE_MODE_SPEED, 20.0, 0.0, 0.0);
    bench_live(500U);
    TEST_ASSERT_EQUAL_INT(DRIVE_READY, drive.state);

    drive_start(&drive);
    drive_background(&drive);
    bench_periods(1U);

    TEST_ASSERT_DOUBLE_WITHIN(AMP_TOLERANCE, 80.0 * KP, iq_ref());
}

/* ---- speed ---------------------------------------------------------------------------------------------------------- */

/* One speed period later the encoder has passed @p counts edges. */
static void edges_pass(int32_t counts)
{
    bench_periods(9U); /* the tick is the first of the ten */
    bench.edge.edge_count += counts;
    bench.edge.edge_cyc += 200000U;
    bench.clock_cyc = bench.edge.edge_cyc;
    bench_periods(1U);
}

void test_speed_isr_mt_speed_is_counts_over_the_time_between_edges(void)
{
    drive_params_t p = bench_params();
    run_inline(p);
    bench_period();
    for (int k = 0; k < 3; k++) {
        edges_pass(37);
    }

    /* 37 of 4000 counts in 1 ms: 58.119 rad/s, within a few float roundings or 2 steps of 6e-8 of 162.5 rad/s and the
     * count's own speed of 0.0097 per unit rounded to a step, times 37 */
    TEST_ASSERT_DOUBLE_WITHIN(per_numeric(2e-5, 4e-4), TWO_PI * 37.0 / 4000.0 / 1e-3, speed());
}

void test_speed_isr_mt_speed_of_a_reversed_encoder_counts_the_other_way(void)
{
    drive_params_t p = bench_params();
    p.encoder_reversed = 1U;
    run_inline(p);
    bench_period();
    for (int k = 0; k < 3; k++) {
        edges_pass(37);
    }

    TEST_ASSERT_DOUBLE_WITHIN(per_numeric(2e-5, 4e-4), -TWO_PI * 37.0 / 4000.0 / 1e-3, speed());
}

void test_speed_isr_error_is_reference_minus_speed(void)
{
    run_inline(bench_params());
    bench_command(DRIVE_MODE_SPEED, 50.0, 0.0, 0.0);
    drive.set[0].setup.speed.pi.ki_ts = (num_t)0;
    drive.speed.pi.params.ki_ts = (num_t)0;
    bench_period();
    for (int k = 0; k < 3; k++) {
        edges_pass(37);
    }

    const double error = GAIN * (50.0 - TWO_PI * 37.0 / 4.0);
    TEST_ASSERT_DOUBLE_WITHIN(KP * GAIN * per_numeric(2e-5, 4e-4) + AMP_TOLERANCE, KP * error, iq_ref());
}

void test_speed_isr_tracking_filter_gives_the_speed_when_chosen(void)
{
    drive_params_t p = bench_params();
    p.speed_source = 0U;
    p.speed_ki_a_per_unit_s = 0.0f;
    run_inline(p);
    bench_command(DRIVE_MODE_SPEED, 120.0, 0.0, 0.0);
    bench_spin(100.0, 1.0);

    TEST_ASSERT_DOUBLE_WITHIN(2e-3, 100.0, speed());
    TEST_ASSERT_DOUBLE_WITHIN(KP * GAIN * 2e-3, KP * GAIN * 20.0, iq_ref());
}

/* ---- repetitive control --------------------------------------------------------------------------------------------- */

static drive_params_t forc(void)
{
    drive_params_t p = bench_params();
    p.method = DRIVE_METHOD_FORC;
    p.speed_ki_a_per_unit_s = 0.0f;
    return p;
}

/* A reference of 15.70796 rad/s (150 r/min) makes N = 60 / (p n T_s) = 100. The rotor stands, so that the error is
 * e = 62.83 units for ever, and by the recursion y[k] = sum q_j w[k - N + j], w[k] = y[k] + k_rc e[k + m], m = 5:
 * w is k_rc e from k = -5 on, so y starts at k = 94 with the outer tap, 95 adds the middle one, 96 is complete. */
static void assert_forc_learns(double reference)
{
    const double e = GAIN * reference;
    const double learned = 0.6 * e;
    bench_start();
    run_inline(forc());
    bench_command(DRIVE_MODE_SPEED, reference, 0.0, 0.0);
    bench_period();
    for (int k = 0; k < 94; k++) {
        TEST_ASSERT_DOUBLE_WITHIN_MESSAGE(1e-9, 0.0, correction(), at("sample %d", k));
        speed_period();
    }
    /* floats of 38 units; 650 units times some steps of 6e-8; N is within 1e-4 of 100, which moves nothing here */
    const double tolerance = per_numeric(2e-4, 5e-3);
    TEST_ASSERT_DOUBLE_WITHIN_MESSAGE(tolerance, 0.45 * learned, correction(), "sample 94");
    speed_period();
    TEST_ASSERT_DOUBLE_WITHIN_MESSAGE(tolerance, 0.55 * learned, correction(), "sample 95");
    speed_period();
    TEST_ASSERT_DOUBLE_WITHIN_MESSAGE(tolerance, learned, correction(), "sample 96");
    TEST_ASSERT_DOUBLE_WITHIN_MESSAGE(2.0 * AMP_TOLERANCE, KP * (e + learned), iq_ref(), "error and correction through the PI");
}

void test_speed_isr_repetitive_correction_is_that_of_a_hand_calculation(void) { assert_forc_learns(15.707963); }

void test_speed_isr_repetitive_control_works_backwards(void) { assert_forc_learns(-15.707963); }

void test_speed_isr_period_of_the_repetitive_controller_is_that_of_the_reference(void)
{
    run_inline(forc());
    bench_command(DRIVE_MODE_SPEED, 26.703538, 0.0, 0.0); /* 255 r/min: 60 / (4 255 1e-3) = 58.8235 */
    bench_period();

    TEST_ASSERT_DOUBLE_WITHIN(2e-4, 58.823529, (double)telemetry_read(&drive, SIGNAL_rc_period_samples));
}

/* lambda(e) = |e|^-0.4 outside of delta, on the same recursion; and in both numerics the same number */
void test_speed_isr_lambda_at_the_output_multiplies_the_correction(void)
{
    const double   reference = 15.707963;
    const double   e = GAIN * reference;
    drive_params_t p = forc();
    p.method = DRIVE_METHOD_FAL_FORC;
    p.rc_fal_at = 1U;
    run_inline(p);
    bench_command(DRIVE_MODE_SPEED, reference, 0.0, 0.0);
    bench_periods(961U);

    TEST_ASSERT_DOUBLE_WITHIN(per_numeric(2e-4, 2e-2), 0.6 * e * pow(e, -0.4), correction());
}

/* fal(e) = e^0.6 is learned instead of e */
void test_speed_isr_fal_at_the_input_teaches_the_bent_error(void)
{
    const double   reference = 15.707963;
    drive_params_t p = forc();
    p.method = DRIVE_METHOD_FAL_FORC;
    run_inline(p);
    bench_command(DRIVE_MODE_SPEED, reference, 0.0, 0.0);
    bench_periods(961U);

    TEST_ASSERT_DOUBLE_WITHIN(per_numeric(2e-4, 2e-3), 0.6 * pow(GAIN * reference, 0.6), correction());
}

void test_speed_isr_reference_too_slow_for_the_memory_rests_the_repetitive_controller(void)
{
    run_inline(forc());
    bench_command(DRIVE_MODE_SPEED, 15.707963, 0.0, 0.0);
    bench_periods(1000U);
    TEST_ASSERT_TRUE(correction() > 1.0);

    /* the memory holds 509 samples at order 2: 3.09 rad/s */
    bench_command(DRIVE_MODE_SPEED, 3.0, 0.0, 0.0);
    speed_period();
    TEST_ASSERT_DOUBLE_WITHIN(1e-9, 0.0, correction());
    TEST_ASSERT_DOUBLE_WITHIN(AMP_TOLERANCE, KP * GAIN * 3.0, iq_ref());

    bench_command(DRIVE_MODE_SPEED, 0.0, 0.0, 0.0);
    speed_period();
    TEST_ASSERT_DOUBLE_WITHIN(1e-9, 0.0, correction());

    /* and it has kept what it knew */
    bench_command(DRIVE_MODE_SPEED, 15.707963, 0.0, 0.0);
    speed_period();
    TEST_ASSERT_TRUE(correction() > 1.0);
}

void test_speed_isr_slowest_reference_that_fits_the_memory_is_served(void)
{
    run_inline(forc());
    bench_command(DRIVE_MODE_SPEED, 3.1, 0.0, 0.0); /* N = 506.7 */
    bench_period();

    TEST_ASSERT_DOUBLE_WITHIN(5e-3, TWO_PI / 4e-3 / 3.1, (double)telemetry_read(&drive, SIGNAL_rc_period_samples));
}

void test_speed_isr_stop_and_start_forgets_what_the_repetitive_controller_learned(void)
{
    drive_params_t p = forc();
    p.speed_inline = 1U;
    drive_init(&drive, &p);
    drive_background(&drive);
    drive_start(&drive);
    drive_background(&drive);
    bench_command(DRIVE_MODE_SPEED, 15.707963, 0.0, 0.0);
    bench_periods(1000U);
    TEST_ASSERT_TRUE(correction() > 1.0);

    drive_stop(&drive);
    drive_background(&drive);
    bench_periods(10U);
    drive_start(&drive);
    drive_background(&drive);
    bench_periods(10U);

    TEST_ASSERT_DOUBLE_WITHIN(1e-9, 0.0, correction());
}

/* ---- the model fed forward ---------------------------------------------------------------------------------------------- */

/* Lines and friction of the model at the reference: J, friction and lines by hand, in ampere of 0.0384 N m. */
void test_speed_isr_feeds_friction_and_the_torque_over_the_angle_forward_when_it_is_asked_to(void)
{
    for (int feeds = 0; feeds < 2; feeds++) {
        bench_start();
        drive_params_t p = bench_params();
        p.speed_kp_a_per_unit = 0.0f;
        p.speed_ki_a_per_unit_s = 0.0f;
        p.speed_model_ff = (uint16_t)feeds;
        p.rdc_coulomb_nm = 0.02f;
        p.rdc_static_nm = 0.02f;
        p.rdc_viscous_nms = 0.001f;
        p.rdc_line1_cycles = 6.0f;
        p.rdc_line1_nm = 0.01f;
        p.rdc_line1_rad = 0.5f;
        bench_run_with(&p);
        bench_angle(0.3);
        bench_command(DRIVE_MODE_SPEED, -2.0, 0.0, 0.0);
        bench_periods(30U);
        /* the torque acts half a speed sample and two periods later */
        const double theta = 0.3 - 2.0 * (0.5e-3 + 2.0e-4);
        const double torque = -0.02 - 0.001 * 2.0 + 0.01 * sin(6.0 * theta + 0.5);
        const double amp = feeds * torque / (1.5 * 4.0 * 6.4e-3);
        TEST_ASSERT_DOUBLE_WITHIN(2e-5, amp, (double)drive_si(drive.speed.iq_ref, drive.scale.current_a));
        const double seen = feeds * (torque + 0.001 * 2.0) / (1.5 * 4.0 * 6.4e-3); /* by an observer of the disturbance */
        TEST_ASSERT_DOUBLE_WITHIN(2e-5, seen, (double)drive_si(drive.speed.fed, drive.scale.current_a));
    }
}
