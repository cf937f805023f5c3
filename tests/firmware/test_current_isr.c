/* firmware/app/current_isr.c: measure, track, control, set duties, in this order and with the right vector. */
#include "firmware/app/telemetry.h"
#include "mock_hal_clock.h"
#include "mock_hal_encoder.h"
#include "mock_hal_inverter.h"
#include "mock_hal_limits.h"
#include "mock_hal_sample.h"
#include "tests/firmware/support/bench.h"

/* Volts out of duties: a float duty has 2^-25 of rounding, times 24 V and the sum of three; the vector itself some
 * 10 operations on up to 14 V. In fixed point: 1e-7 of a duty, and 20 V times a few steps of 6e-8. */
#define VOLT_TOLERANCE 2e-5

void setUp(void) { bench_start(); }
void tearDown(void) {}

static void assert_vector(double alpha_v, double beta_v, double tolerance, const char *text)
{
    double alpha;
    double beta;
    bench_voltage(&alpha, &beta);
    TEST_ASSERT_DOUBLE_WITHIN_MESSAGE(tolerance, alpha_v, alpha, text);
    TEST_ASSERT_DOUBLE_WITHIN_MESSAGE(tolerance, beta_v, beta, text);
}

/* The vector d + j q of the frame at theta_e. */
static void assert_dq(double d_v, double q_v, double theta_e, double tolerance, const char *text)
{
    assert_vector(d_v * cos(theta_e) - q_v * sin(theta_e), d_v * sin(theta_e) + q_v * cos(theta_e), tolerance, text);
}

static double length(void)
{
    double alpha;
    double beta;
    bench_voltage(&alpha, &beta);
    return hypot(alpha, beta);
}

/* ---- order of things ------------------------------------------------------------------------------------------------ */

void test_current_isr_reads_one_sample_and_then_sets_the_duties_once_in_every_state(void)
{
    for (int state = DRIVE_INIT; state <= DRIVE_FAULT; state++) {
        bench_start();
        bench_into((drive_state_t)state);
        bench_forget_calls();
        const uint32_t reads = bench.reads;
        const uint32_t duties = bench.duties;

        bench_period();

        TEST_ASSERT_EQUAL_UINT32_MESSAGE(reads + 1U, bench.reads, at("state %d", state));
        TEST_ASSERT_EQUAL_UINT32_MESSAGE(duties + 1U, bench.duties, at("state %d", state));
        TEST_ASSERT_TRUE_MESSAGE(bench_first(CALL_READ) >= 0, at("state %d", state));
        TEST_ASSERT_TRUE_MESSAGE(bench_first(CALL_READ) < bench_first(CALL_DUTY), at("state %d", state));
    }
}

void test_current_isr_without_control_gives_exactly_zero_voltage(void)
{
    const drive_state_t state[] = {DRIVE_INIT, DRIVE_OFFSET_CALIBRATION, DRIVE_READY, DRIVE_FAULT};
    for (size_t i = 0; i < COUNT_OF(state); i++) {
        bench_start();
        bench_into(state[i]);
        bench_command(DRIVE_MODE_CURRENT, 0.0, 3.0, 5.0);
        bench_currents(1.0, 2.0, 0.7);
        bench_angle(1.3);

        bench_periods(20U);

        ASSERT_ZERO_VOLTAGE(at("state %d", (int)state[i]));
    }
}

void test_current_isr_never_arms_the_bridge(void)
{
    bench_into(DRIVE_READY);
    bench_periods(100U);

    TEST_ASSERT_EQUAL_UINT32(0U, bench.arms);
}

void test_current_isr_duties_stay_within_zero_and_one_whatever_comes(void)
{
    noise_t        noise = {77U};
    drive_params_t p = bench_params();
    p.current_ki_v_per_as = 1080.0f;
    p.over_speed_rad_s = 20000.0f;
    p.over_current_a = 1000.0f;
    p.over_voltage_v = 1000.0f;
    p.under_voltage_v = 0.0f;
    bench_run_with(&p);
    for (int k = 0; k < 5000; k++) {
        bench_command(DRIVE_MODE_CURRENT, 0.0, 40.0 * noise_next(&noise), 40.0 * noise_next(&noise));
        bench_currents(200.0 * noise_next(&noise), 200.0 * noise_next(&noise), TWO_PI * noise_next(&noise));
        bench_angle(TWO_PI * noise_next(&noise));
        bench.sample.vdc_v = (float)(30.0 + 60.0 * noise_next(&noise));

        bench_period();

        ASSERT_DUTIES_LEGAL(at("period %d", k));
    }
    TEST_ASSERT_EQUAL_INT(DRIVE_RUN, drive.state); /* all of it was control, not zero voltage after a fault */
}

void test_current_isr_dead_dc_link_gives_zero_voltage(void)
{
    drive_params_t p = bench_params();
    p.under_voltage_v = 0.0f;
    bench_run_with(&p);
    bench_command(DRIVE_MODE_CURRENT, 0.0, 0.0, 5.0);
    const float dead[] = {0.0f, 1e-9f};
    for (size_t i = 0; i < COUNT_OF(dead); i++) {
        bench.sample.vdc_v = dead[i];
        bench_period();
        ASSERT_DUTIES_LEGAL("no dc link");
    }
}

/* ---- the vector ----------------------------------------------------------------------------------------------------- */

void test_current_isr_positive_q_error_turns_the_vector_a_quarter_ahead_of_the_magnets(void)
{
    bench_into(DRIVE_RUN);
    bench_command(DRIVE_MODE_CURRENT, 0.0, 0.0, 1.0);
    for (int k = 0; k < 24; k++) {
        /* standing at each angle long enough for the filter to stand, too: no advance */
        const double theta_m = TWO_PI / 24.0 * k;
        bench_spin(0.0, theta_m);

        assert_dq(0.0, 0.6, 4.0 * theta_m, VOLT_TOLERANCE, at("theta_m = %g", theta_m));
    }
}

/* by hand at theta_e = 0: v_q = 0.6 V lies on beta, so phase a 0, b +0.5196, c -0.5196 V: duties around 1/2 by 0.02165 */
void test_current_isr_q_error_at_angle_zero_pushes_phase_b_and_pulls_phase_c(void)
{
    bench_into(DRIVE_RUN);
    bench_command(DRIVE_MODE_CURRENT, 0.0, 0.0, 1.0);

    bench_period();

    TEST_ASSERT_FLOAT_WITHIN(1e-6f, 0.5f, bench.duty.a);
    TEST_ASSERT_FLOAT_WITHIN(1e-6f, 0.521651f, bench.duty.b);
    TEST_ASSERT_FLOAT_WITHIN(1e-6f, 0.478349f, bench.duty.c);
}

void test_current_isr_d_error_lies_on_the_magnets(void)
{
    bench_into(DRIVE_RUN);
    bench_command(DRIVE_MODE_CURRENT, 0.0, -2.0, 0.0);
    bench_spin(0.0, 0.4);

    assert_dq(-1.2, 0.0, 1.6, VOLT_TOLERANCE, "id_ref = -2 A");
}

void test_current_isr_measured_current_counts_against_the_reference(void)
{
    bench_into(DRIVE_RUN);
    bench_command(DRIVE_MODE_CURRENT, 0.0, 1.0, 4.0);
    bench_currents(3.0, -1.0, 1.6);
    bench_spin(0.0, 0.4);

    assert_dq(0.6 * (1.0 - 3.0), 0.6 * (4.0 + 1.0), 1.6, VOLT_TOLERANCE, "errors -2 and 5 A");
}

void test_current_isr_common_part_of_the_three_currents_has_no_effect(void)
{
    bench_into(DRIVE_RUN);
    bench_command(DRIVE_MODE_CURRENT, 0.0, 0.0, 1.0);
    bench.sample.ia_a = 2.0f;
    bench.sample.ib_a = 2.0f;
    bench.sample.ic_a = 2.0f;

    bench_period();

    assert_dq(0.0, 0.6, 0.0, VOLT_TOLERANCE, "all phases 2 A");
}

static void assert_advance(double periods, double speed, double theta_m)
{
    drive_params_t p = bench_params();
    p.angle_advance_periods = (float)periods;
    bench_start();
    bench_run_with(&p);
    bench_command(DRIVE_MODE_CURRENT, 0.0, 0.0, 10.0);
    bench_spin(speed, theta_m);

    /* the filter is within 1e-3 rad/s of the speed (angles are floats: 2.4e-7 rad of noise, times 1400/s), and the
     * electrical angle itself within 1e-6 rad; on 6 V */
    assert_dq(0.0, 6.0, 4.0 * theta_m + periods * 1e-4 * 4.0 * speed, 2e-5 + 6.0 * (2e-6 + periods * 4e-4 * 2e-3),
              at("%g periods at %g rad/s", periods, speed));
}

void test_current_isr_voltage_is_turned_to_the_middle_of_the_period_in_which_it_acts(void)
{
    assert_advance(1.5, 100.0, 0.9);
    assert_advance(1.5, -100.0, 0.9);
    assert_advance(1.5, 600.0, 5.0);
}

void test_current_isr_angle_advance_follows_its_parameter(void)
{
    assert_advance(0.0, 300.0, 2.0);
    assert_advance(2.5, 300.0, 2.0);
}

void test_current_isr_integral_part_grows_by_its_gain_and_the_sample_time(void)
{
    drive_params_t p = bench_params();
    p.current_ki_v_per_as = 1080.0f;
    bench_run_with(&p);
    bench_command(DRIVE_MODE_CURRENT, 0.0, 0.5, 1.0);
    for (int k = 0; k < 40; k++) {
        bench_period();

        /* u = kp e + x, x += ki e Ts: 0.108 V per period and ampere; 40 roundings more than the plain vector */
        const double gain = 0.6 + 0.108 * k;
        assert_dq(0.5 * gain, gain, 0.0, 2.0 * VOLT_TOLERANCE, at("period %d", k));
    }
}

/* ---- limits --------------------------------------------------------------------------------------------------------- */

void test_current_isr_vector_is_shortened_to_what_the_dc_link_reaches_and_keeps_its_direction(void)
{
    bench_into(DRIVE_RUN);
    bench_command(DRIVE_MODE_CURRENT, 0.0, 6.0, 8.0);
    bench_currents(-12.0, -16.0, 0.0); /* errors 18 and 24 A: 10.8 and 14.4 V, 18 V long */

    bench_period();

    const double reach = BENCH_VDC / SQRT3;
    assert_dq(0.6 * reach, 0.8 * reach, 0.0, 5.0 * VOLT_TOLERANCE, "a 3-4-5 triangle");
}

void test_current_isr_vector_inside_the_limit_is_left_alone(void)
{
    bench_into(DRIVE_RUN);
    bench_command(DRIVE_MODE_CURRENT, 0.0, 6.0, 8.0);
    bench_currents(-6.8, -9.0, 0.0); /* 7.68 and 10.2 V: 12.77 V, below 13.86 */

    bench_period();

    assert_dq(7.68, 10.2, 0.0, 2.0 * VOLT_TOLERANCE, "92 %");
}

void test_current_isr_voltage_limit_parameter_counts_where_it_is_the_lower_one(void)
{
    drive_params_t p = bench_params();
    p.voltage_limit_v = 6.0f;
    bench_run_with(&p);
    bench_command(DRIVE_MODE_CURRENT, 0.0, 0.0, 10.0);
    bench_currents(0.0, -10.0, 0.0);

    bench_period();
    TEST_ASSERT_DOUBLE_WITHIN(5.0 * VOLT_TOLERANCE, 6.0, length());

    bench.sample.vdc_v = 10.2f; /* reaches 5.89 V */
    bench_period();
    TEST_ASSERT_DOUBLE_WITHIN(5.0 * VOLT_TOLERANCE, 10.2 / SQRT3, length());
}

void test_current_isr_integral_parts_of_both_axes_hold_while_the_vector_is_limited(void)
{
    drive_params_t p = bench_params();
    p.current_ki_v_per_as = 1080.0f;
    bench_run_with(&p);
    bench_command(DRIVE_MODE_CURRENT, 0.0, 1.0, 9.0);
    bench_currents(0.0, -19.0, 0.0); /* 16.8 V */
    bench_periods(100U);
    TEST_ASSERT_DOUBLE_WITHIN(5.0 * VOLT_TOLERANCE, BENCH_VDC / SQRT3, length());

    bench_currents(1.0, 9.0, 0.0); /* no error: what is left is the integral part */
    bench_period();

    assert_dq(0.0, 0.0, 0.0, VOLT_TOLERANCE, "nothing was learned");
}

void test_current_isr_references_in_current_mode_are_cut_to_their_limits(void)
{
    drive_params_t p = bench_params();
    p.iq_limit_a = 5.0f;
    p.id_limit_a = 3.0f;
    bench_run_with(&p);
    bench_command(DRIVE_MODE_CURRENT, 0.0, 50.0, -50.0);
    bench_period();
    assert_dq(1.8, -2.4, 0.0, VOLT_TOLERANCE, "3 A and -4 A: 5 A long");

    bench_command(DRIVE_MODE_CURRENT, 0.0, 0.0, 50.0);
    bench_period();
    assert_dq(0.0, 3.0, 0.0, VOLT_TOLERANCE, "5 A");
}

/* 0.6 V/A, no integral part: the voltage is the reference. The longest vector is the larger limit, 13 A. */
void test_current_isr_d_current_takes_its_part_of_the_longest_vector_first(void)
{
    const double   triple[][2] = {{5.0, 12.0}, {-5.0, 12.0}, {12.0, 5.0}, {-12.0, 5.0}, {13.0, 0.0}, {0.0, 13.0}};
    drive_params_t p = bench_params();
    p.iq_limit_a = 13.0f;
    p.id_limit_a = 13.0f;
    bench_run_with(&p);
    for (size_t k = 0; k < COUNT_OF(triple); k++) {
        for (double sign = -1.0; sign < 2.0; sign += 2.0) {
            bench_command(DRIVE_MODE_CURRENT, 0.0, triple[k][0], 13.0 * sign);
            bench_period();
            assert_dq(0.6 * triple[k][0], 0.6 * triple[k][1] * sign, 0.0, 2.0 * VOLT_TOLERANCE, at("case %d", (int)k));
        }
    }
}

void test_current_isr_speed_loop_gets_what_the_d_current_leaves(void)
{
    drive_params_t p = bench_params();
    p.speed_inline = 1U;
    p.iq_limit_a = 10.0f;
    p.id_limit_a = 10.0f;
    bench_run_with(&p);
    bench_command(DRIVE_MODE_SPEED, 600.0, 6.0, 0.0); /* far off: the speed loop asks for all it can have */
    bench_periods(30U);

    assert_dq(3.6, 4.8, 0.0, 2.0 * VOLT_TOLERANCE, "6 A and 8 A: 10 A long");
    TEST_ASSERT_DOUBLE_WITHIN(1e-5, 8.0, (double)telemetry_read(&drive, SIGNAL_iq_ref_a));
}

/* ...and winds up against that, not against the limit of its own: after the error has changed its sign the reference follows
 * within one sample. */
void test_current_isr_speed_loop_does_not_wind_up_beyond_what_it_gets(void)
{
    drive_params_t p = bench_params();
    p.speed_inline = 1U;
    p.stall_s = 0.0f;
    p.id_limit_a = 10.0f;
    bench_run_with(&p);
    bench_command(DRIVE_MODE_SPEED, 20.0, 8.0, 0.0); /* 80 units: 2.9 A at once, 0.07 A more each sample, room for 6 A */
    bench_periods(10000U);
    TEST_ASSERT_DOUBLE_WITHIN(1e-4, 6.0, (double)telemetry_read(&drive, SIGNAL_iq_ref_a));
    bench_command(DRIVE_MODE_SPEED, -20.0, 8.0, 0.0);
    bench_periods(10U);

    /* held when it reached 6 A: the integral part is 3.06 A or one step more, and the proportional one -2.94 A now */
    TEST_ASSERT_DOUBLE_WITHIN(0.16, 6.0 - 2.0 * 80.0 * 0.0368, (double)telemetry_read(&drive, SIGNAL_iq_ref_a));
}

/* ---- angle ---------------------------------------------------------------------------------------------------------- */

void test_current_isr_encoder_offset_turns_the_frame(void)
{
    drive_params_t p = bench_params();
    p.encoder_offset_rad = 0.8f;
    bench_run_with(&p);
    bench_command(DRIVE_MODE_CURRENT, 0.0, 0.0, 1.0);
    bench_spin(0.0, 0.3);

    assert_dq(0.0, 0.6, 1.2 + 0.8, VOLT_TOLERANCE, "offset 0.8 rad electrical");
}

void test_current_isr_reversed_encoder_counts_against_the_motor(void)
{
    drive_params_t p = bench_params();
    p.encoder_reversed = 1U;
    bench_run_with(&p);
    bench_command(DRIVE_MODE_CURRENT, 0.0, 0.0, 10.0);
    bench_spin(-200.0, 0.3); /* the motor turns forward */

    assert_dq(0.0, 6.0, -1.2 + 1.5e-4 * 800.0, 2e-5 + 6.0 * 4e-6, "advance against the count");
    TEST_ASSERT_DOUBLE_WITHIN(2e-3, 200.0, value_of(drive.tracking.pll.state.w) * (double)drive.scale.speed_rad_s);
}

void test_current_isr_number_of_pole_pairs_multiplies_the_angle(void)
{
    drive_params_t p = bench_params();
    p.pole_pairs = 7U;
    bench_run_with(&p);
    bench_command(DRIVE_MODE_CURRENT, 0.0, 0.0, 1.0);
    bench_spin(0.0, 6.1);

    assert_dq(0.0, 0.6, 42.7, VOLT_TOLERANCE, "7 pole pairs");
}

void test_current_isr_tracking_starts_on_the_first_angle_without_a_jump(void)
{
    bench_into(DRIVE_RUN);
    bench_angle(3.0);
    bench_period();

    TEST_ASSERT_DOUBLE_WITHIN(1e-9, 0.0, value_of(drive.tracking.pll.state.w));
    ASSERT_NO_FAULT("an angle of 3 rad at the start");
}

/* ---- speed tick ----------------------------------------------------------------------------------------------------- */

void test_current_isr_asks_for_the_speed_interrupt_once_in_ten_periods(void)
{
    bench_into(DRIVE_RUN);
    bench_periods(100U);

    TEST_ASSERT_EQUAL_UINT32(10U, bench.requests);
    TEST_ASSERT_EQUAL_UINT32(10U, bench.edges);
}

void test_current_isr_speed_divider_sets_the_rate(void)
{
    drive_params_t p = bench_params();
    p.speed_divider = 7U;
    bench_run_with(&p);
    bench_periods(70U);
    TEST_ASSERT_EQUAL_UINT32(10U, bench.requests);

    p.speed_divider = 1U;
    bench_start();
    bench_run_with(&p);
    bench_periods(70U);
    TEST_ASSERT_EQUAL_UINT32(70U, bench.requests);
}

void test_current_isr_inline_speed_loop_needs_no_interrupt(void)
{
    drive_params_t p = bench_params();
    p.speed_inline = 1U;
    bench_run_with(&p);
    bench_periods(100U);

    TEST_ASSERT_EQUAL_UINT32(0U, bench.requests);
    TEST_ASSERT_EQUAL_UINT32(10U, bench.edges);
}

/* ---- samples that cannot be used ------------------------------------------------------------------------------------ */

void test_current_isr_stale_sample_gives_zero_voltage_for_that_period(void)
{
    bench_into(DRIVE_RUN);
    bench_command(DRIVE_MODE_CURRENT, 0.0, 0.0, 1.0);
    bench_period();
    bench.seq_by_itself = false;
    bench.sample_status = HAL_STALE;

    bench_period();
    ASSERT_ZERO_VOLTAGE("stale");

    bench.seq_by_itself = true;
    bench.sample_status = HAL_OK;
    bench_period();
    assert_dq(0.0, 0.6, 0.0, VOLT_TOLERANCE, "the next one is good");
    TEST_ASSERT_EQUAL_UINT32(1U, drive_rejected(&drive));
}

void test_current_isr_sample_after_a_gap_is_used_and_the_gap_is_counted(void)
{
    bench_into(DRIVE_RUN);
    bench_command(DRIVE_MODE_CURRENT, 0.0, 0.0, 1.0);
    bench_period();
    bench.sample.seq += 2U; /* of 3 that trip */

    bench_period();

    assert_dq(0.0, 0.6, 0.0, VOLT_TOLERANCE, "after the gap");
    TEST_ASSERT_EQUAL_UINT32(1U, drive_rejected(&drive));
}

void test_current_isr_sequence_number_may_wrap(void)
{
    bench_into(DRIVE_RUN);
    bench.sample.seq = UINT32_MAX - 5U;
    bench_periods(20U);

    TEST_ASSERT_EQUAL_UINT32(0U, drive_rejected(&drive));
}

void test_current_isr_first_sample_may_have_any_sequence_number(void)
{
    bench_into(DRIVE_RUN);
    bench.sample.seq = 123456U;
    bench_period();

    TEST_ASSERT_EQUAL_UINT32(0U, drive_rejected(&drive));
}

void test_current_isr_bad_sample_teaches_the_controllers_nothing(void)
{
    drive_params_t p = bench_params();
    p.current_ki_v_per_as = 1080.0f;
    bench_run_with(&p);
    bench_command(DRIVE_MODE_CURRENT, 0.0, 0.0, 1.0);
    bench_periods(2U);
    bench.sample.ib_a = NAN;
    bench_period();
    ASSERT_ZERO_VOLTAGE("nan");
    bench.sample.ib_a = 0.0f;
    bench_period();

    assert_dq(0.0, 0.6 + 2.0 * 0.108, 0.0, 2.0 * VOLT_TOLERANCE, "two learned samples so far");
}

/* ---- duration ------------------------------------------------------------------------------------------------------- */

void test_current_isr_measures_its_duration_and_remembers_the_longest(void)
{
    bench_into(DRIVE_RUN);
    bench.isr_cyc = 900U;
    bench_periods(1U);
    bench.isr_cyc = 500U;
    bench_periods(1U);

    TEST_ASSERT_EQUAL_UINT32(500U, drive.timing.current.last_cyc);
    TEST_ASSERT_UINT32_WITHIN(900U, 1800U,
                              drive.timing.current.max_cyc); /* one or two steps of the clock: the speed tick reads it, too */
}

void test_current_isr_duration_is_right_when_the_clock_wraps(void)
{
    bench_into(DRIVE_RUN);
    bench.isr_cyc = 0U;
    bench_period(); /* the speed tick is over */
    bench.clock_cyc = UINT32_MAX - 100U;
    bench.isr_cyc = 300U;
    bench_period();

    TEST_ASSERT_EQUAL_UINT32(300U, drive.timing.current.last_cyc);
    ASSERT_NO_FAULT("wrap of the clock");
}
