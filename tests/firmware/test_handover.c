/* Commands and parameters cross from the main loop to the interrupts as a whole, or not at all. */
#include "firmware/app/telemetry.h"
#include "mock_hal_clock.h"
#include "mock_hal_encoder.h"
#include "mock_hal_inverter.h"
#include "mock_hal_sample.h"
#include "tests/firmware/support/bench.h"

void setUp(void) { bench_start(); }
void tearDown(void) {}

static double shown(uint16_t signal) { return (double)telemetry_read(&drive, signal); }

/* ---- commands ------------------------------------------------------------------------------------------------------- */

void test_drive_command_acts_as_a_whole_with_the_next_sample(void)
{
    bench_into(DRIVE_RUN);
    bench_command(DRIVE_MODE_CURRENT, 0.0, 1.0, 2.0);
    bench_period();
    bench_command(DRIVE_MODE_CURRENT, 0.0, -3.0, -4.0);
    TEST_ASSERT_DOUBLE_WITHIN(1e-6, 1.0, shown(SIGNAL_id_ref_a));
    TEST_ASSERT_DOUBLE_WITHIN(1e-6, 2.0, shown(SIGNAL_iq_ref_a));

    bench_period();

    TEST_ASSERT_DOUBLE_WITHIN(1e-6, -3.0, shown(SIGNAL_id_ref_a));
    TEST_ASSERT_DOUBLE_WITHIN(1e-6, -4.0, shown(SIGNAL_iq_ref_a));
}

void test_drive_command_of_several_the_newest_counts(void)
{
    bench_into(DRIVE_RUN);
    for (int k = 1; k <= 7; k++) {
        bench_command(DRIVE_MODE_CURRENT, 0.0, 0.0, (double)k);
    }
    bench_period();

    TEST_ASSERT_DOUBLE_WITHIN(1e-6, 7.0, shown(SIGNAL_iq_ref_a));
}

/* the interrupt never sees the half that is being written */
void test_drive_command_is_written_where_no_interrupt_reads(void)
{
    bench_into(DRIVE_RUN);
    for (int k = 0; k < 5; k++) {
        const drive_command_t before = drive.command[drive.command_at & 1U];
        const uint16_t        at_before = drive.command_at;
        bench_command(DRIVE_MODE_SPEED, 10.0 + k, 0.0, 0.0);

        TEST_ASSERT_EQUAL_MEMORY(&before, &drive.command[at_before & 1U], sizeof before);
        TEST_ASSERT_NOT_EQUAL_UINT16(at_before, drive.command_at);
    }
}

void test_drive_command_with_a_number_that_is_none_is_refused_and_the_old_one_goes_on(void)
{
    const float bad[] = {NAN, INFINITY, -INFINITY, 1.1e6f, -1.1e6f};
    bench_into(DRIVE_RUN);
    bench_command(DRIVE_MODE_CURRENT, 0.0, 0.5, 1.5);
    for (size_t k = 0; k < COUNT_OF(bad); k++) {
        const drive_command_t speed = {.mode = DRIVE_MODE_SPEED, .speed_ref_rad_s = bad[k]};
        const drive_command_t d = {.mode = DRIVE_MODE_CURRENT, .id_ref_a = bad[k]};
        const drive_command_t q = {.mode = DRIVE_MODE_CURRENT, .iq_ref_a = bad[k]};
        TEST_ASSERT_FALSE(drive_command(&drive, &speed));
        TEST_ASSERT_FALSE(drive_command(&drive, &d));
        const drive_command_t target = {.mode = DRIVE_MODE_POSITION, .target_rad = bad[k]};
        TEST_ASSERT_FALSE(drive_command(&drive, &q));
        TEST_ASSERT_FALSE(drive_command(&drive, &target));
    }
    bench_period();

    TEST_ASSERT_DOUBLE_WITHIN(1e-6, 0.5, shown(SIGNAL_id_ref_a));
    TEST_ASSERT_DOUBLE_WITHIN(1e-6, 1.5, shown(SIGNAL_iq_ref_a));
}

void test_drive_command_before_the_start_acts_after_it(void)
{
    bench_into(DRIVE_READY);
    bench_command(DRIVE_MODE_CURRENT, 0.0, 0.0, 2.0);
    drive_start(&drive);
    drive_background(&drive);
    bench_period();

    TEST_ASSERT_DOUBLE_WITHIN(1e-6, 2.0, shown(SIGNAL_iq_ref_a));
}

/* ---- parameters ----------------------------------------------------------------------------------------------------- */

static uint16_t culprit;

static bool tune(const drive_params_t *p)
{
    culprit = 0x5555U;
    return drive_tune(&drive, p, &culprit);
}

static double q_volts(void)
{
    bench_period();
    return shown(SIGNAL_vq_v);
}

void test_drive_tune_acts_between_two_samples_and_not_before(void)
{
    bench_into(DRIVE_RUN);
    bench_command(DRIVE_MODE_CURRENT, 0.0, 0.0, 1.0);
    TEST_ASSERT_DOUBLE_WITHIN(2e-5, 0.6, q_volts());
    drive_params_t p = drive.params;
    p.current_kp_v_per_a = 0.9f;

    TEST_ASSERT_TRUE(tune(&p));

    TEST_ASSERT_EQUAL_UINT16(PARAM_COUNT, culprit);
    TEST_ASSERT_EQUAL_FLOAT(0.6f, drive.params.current_kp_v_per_a); /* the interrupts still have the old ones */
    TEST_ASSERT_DOUBLE_WITHIN(2e-5, 0.9, q_volts());
    TEST_ASSERT_EQUAL_FLOAT(0.9f, drive.params.current_kp_v_per_a);
}

/* limits and gains of one change belong together: an interrupt sees both or none */
void test_drive_tune_protection_limits_change_with_the_rest(void)
{
    bench_into(DRIVE_RUN);
    bench.sample.vdc_v = 30.0f;
    bench_period();
    drive_params_t p = drive.params;
    p.over_voltage_v = (float)per_numeric(28.0, 40.0); /* in fixed point it is a base and may not change */
    p.under_voltage_v = (float)per_numeric(5.0, 31.0);
    TEST_ASSERT_TRUE(tune(&p));
    ASSERT_NO_FAULT("no sample yet");

    bench_period();

    ASSERT_FAULT((drive_fault_t)per_numeric((double)FAULT_over_voltage, (double)FAULT_under_voltage), "30 V are too much now");
}

void test_drive_tune_refused_changes_nothing(void)
{
    bench_into(DRIVE_RUN);
    bench_periods(25U);
    static drive_t before;
    before = drive;
    drive_params_t p = drive.params;
    p.current_kp_v_per_a = 0.9f;
    p.iq_limit_a = 21.0f; /* more than trips */

    TEST_ASSERT_FALSE(tune(&p));

    TEST_ASSERT_EQUAL_UINT16(PARAM_iq_limit_a, culprit);
    TEST_ASSERT_EQUAL_MEMORY(&before.params, &drive.params, sizeof before.params);
    TEST_ASSERT_EQUAL_MEMORY(&before.setup, &drive.setup, sizeof before.setup);
    TEST_ASSERT_EQUAL_UINT16(0U, drive.next_ready);
    bench_command(DRIVE_MODE_CURRENT, 0.0, 0.0, 1.0);
    TEST_ASSERT_DOUBLE_WITHIN(2e-5, 0.6, q_volts());
}

void test_drive_tune_refuses_what_is_out_of_range_or_no_number(void)
{
    bench_into(DRIVE_RUN);
    drive_params_t p = drive.params;
    p.rc_lead = 16U;
    TEST_ASSERT_FALSE(tune(&p));
    TEST_ASSERT_EQUAL_UINT16(PARAM_rc_lead, culprit);

    p = drive.params;
    p.speed_kp_a_per_unit = NAN;
    TEST_ASSERT_FALSE(tune(&p));
    TEST_ASSERT_EQUAL_UINT16(PARAM_speed_kp_a_per_unit, culprit);
}

void test_drive_tune_second_change_waits_until_the_first_was_taken_over(void)
{
    bench_into(DRIVE_RUN);
    bench_command(DRIVE_MODE_CURRENT, 0.0, 0.0, 1.0);
    bench_period();
    drive_params_t p = drive.params;
    p.current_kp_v_per_a = 0.9f;
    TEST_ASSERT_TRUE(tune(&p));
    p.current_kp_v_per_a = 0.3f;

    TEST_ASSERT_FALSE(tune(&p));
    TEST_ASSERT_EQUAL_UINT16(PARAM_COUNT, culprit); /* nothing wrong with it, but not now */
    TEST_ASSERT_DOUBLE_WITHIN(2e-5, 0.9, q_volts());

    TEST_ASSERT_TRUE(tune(&p));
    TEST_ASSERT_DOUBLE_WITHIN(2e-5, 0.3, q_volts());
}

void test_drive_tune_keeps_the_integral_parts(void)
{
    drive_params_t p = bench_params();
    p.current_ki_v_per_as = 1080.0f;
    bench_run_with(&p);
    bench_command(DRIVE_MODE_CURRENT, 0.0, 0.0, 1.0);
    bench_periods(20U);
    p.current_kp_v_per_a = 0.9f;
    TEST_ASSERT_TRUE(tune(&p));

    TEST_ASSERT_DOUBLE_WITHIN(4e-5, 0.9 + 20.0 * 0.108, q_volts());
}

void test_drive_tune_reaches_the_speed_controller_and_the_tracking_filter(void)
{
    drive_params_t p = bench_params();
    p.speed_inline = 1U;
    p.speed_ki_a_per_unit_s = 0.0f;
    bench_run_with(&p);
    bench_command(DRIVE_MODE_SPEED, 1.0, 0.0, 0.0);
    bench_periods(20U);
    TEST_ASSERT_DOUBLE_WITHIN(1e-5, 4.0 * 0.0368, shown(SIGNAL_iq_ref_a));
    p.speed_kp_a_per_unit = 0.1f;
    p.pll_kp_per_s = 2000.0f;
    p.pll_ki_per_s2 = 500000.0f;
    TEST_ASSERT_TRUE(tune(&p));
    bench_periods(10U);
    TEST_ASSERT_DOUBLE_WITHIN(1e-5, 0.4, shown(SIGNAL_iq_ref_a));

    /* an angle of 0.01 rad is answered by k_i T_s 0.01 at once */
    bench_angle(0.01);
    bench_period();
    TEST_ASSERT_DOUBLE_WITHIN(1e-4, 0.5, value_of(drive.tracking.pll.state.w) * (double)drive.scale.speed_rad_s);
}

/* The blocks of the speed interrupt may not change under it: the current interrupt waits while it was requested. */
void test_drive_tune_waits_while_the_speed_interrupt_is_under_way(void)
{
    bench_into(DRIVE_RUN);
    bench.sample.seq++;
    drive_current_isr(&drive);
    TEST_ASSERT_TRUE(bench.speed_requested); /* requested, and still running */
    drive_params_t p = drive.params;
    p.current_kp_v_per_a = 0.9f;
    TEST_ASSERT_TRUE(tune(&p));

    bench.sample.seq++;
    drive_current_isr(&drive);
    TEST_ASSERT_EQUAL_FLOAT(0.6f, drive.params.current_kp_v_per_a);

    drive_speed_isr(&drive);
    bench.sample.seq++;
    drive_current_isr(&drive);
    TEST_ASSERT_EQUAL_FLOAT(0.9f, drive.params.current_kp_v_per_a);
}

void test_drive_tune_interrupt_in_the_middle_of_a_change_sees_the_old_parameters(void)
{
    bench_into(DRIVE_RUN);
    bench_command(DRIVE_MODE_CURRENT, 0.0, 0.0, 1.0);
    bench_period();
    drive_params_t p = drive.params;
    p.current_kp_v_per_a = 0.9f;
    bench.in_clock_hz = bench_period; /* called while the new setup is made */
    TEST_ASSERT_TRUE(tune(&p));

    TEST_ASSERT_NULL(bench.in_clock_hz);
    TEST_ASSERT_DOUBLE_WITHIN(2e-5, 0.6, shown(SIGNAL_vq_v));
    TEST_ASSERT_DOUBLE_WITHIN(2e-5, 0.9, q_volts());
}

/* ---- what a change does to memories --------------------------------------------------------------------------------- */

static drive_params_t learning(void)
{
    drive_params_t p = bench_params();
    p.method = DRIVE_METHOD_FORC;
    p.speed_inline = 1U;
    bench_run_with(&p);
    bench_command(DRIVE_MODE_SPEED, 15.707963, 0.0, 0.0);
    bench_periods(1005U);
    TEST_ASSERT_TRUE(shown(SIGNAL_rc_out_unit) > 1.0);
    return p;
}

void test_drive_tune_of_a_gain_keeps_what_the_repetitive_controller_learned(void)
{
    drive_params_t p = learning();
    const double   before = shown(SIGNAL_rc_out_unit);
    p.rc_gain = 0.61f;
    TEST_ASSERT_TRUE(tune(&p));
    bench_periods(10U);

    TEST_ASSERT_DOUBLE_WITHIN(0.05 * before, before, shown(SIGNAL_rc_out_unit));
}

/* the rotor stands: a period teaches the gain times the error; without gain the memory only turns round */
void test_drive_tune_of_a_gain_changes_what_is_learned_from_now_on(void)
{
    drive_params_t p = learning();
    p.rc_gain = 0.0f;
    p.rc_q_side = 0.0f;
    p.rc_q_centre = 1.0f;
    TEST_ASSERT_TRUE(tune(&p));
    bench_periods(1500U); /* the last samples with the old gain have come round */
    const double before = shown(SIGNAL_rc_out_unit);
    bench_periods(1000U); /* a period of 100 samples */

    TEST_ASSERT_TRUE(before > 1.0);
    TEST_ASSERT_DOUBLE_WITHIN(0.01 * before, before, shown(SIGNAL_rc_out_unit));
}

void test_drive_tune_of_order_lead_or_memory_clears_it(void)
{
    for (int what = 0; what < 3; what++) {
        bench_start();
        drive_params_t p = learning();
        p.rc_order = (what == 0) ? 3U : p.rc_order;
        p.rc_lead = (what == 1) ? 4U : p.rc_lead;
        p.rc_memory = (what == 2) ? 1U : p.rc_memory;
        TEST_ASSERT_TRUE(tune(&p));
        bench_periods(10U);

        TEST_ASSERT_DOUBLE_WITHIN_MESSAGE(1e-9, 0.0, shown(SIGNAL_rc_out_unit), at("change %d", what));
    }
}

void test_drive_tune_away_from_repetitive_control_takes_its_correction_off(void)
{
    drive_params_t p = learning();
    p.method = DRIVE_METHOD_PI;
    TEST_ASSERT_TRUE(tune(&p));
    bench_periods(10U);

    TEST_ASSERT_DOUBLE_WITHIN(1e-9, 0.0, shown(SIGNAL_rc_out_unit));
    TEST_ASSERT_EQUAL_UINT32(0U, drive_rejected(&drive));
}

void test_drive_tune_every_method_can_follow_every_other(void)
{
    const uint16_t methods = (uint16_t)(params_info(PARAM_method)->max + 1.0f);
    for (uint16_t from = 0U; from < methods; from++) {
        for (uint16_t to = 0U; to < methods; to++) {
            bench_start();
            drive_params_t p = bench_params();
            p.method = from;
            bench_run_with(&p);
            bench_command(DRIVE_MODE_SPEED, 15.707963, 0.0, 0.0);
            bench_periods(200U);
            p.method = to;
            TEST_ASSERT_TRUE_MESSAGE(tune(&p), at("%u to %u", (unsigned)from, (unsigned)to));
            bench_periods(200U);

            TEST_ASSERT_EQUAL_INT_MESSAGE(DRIVE_RUN, drive.state, at("%u to %u", (unsigned)from, (unsigned)to));
            ASSERT_DUTIES_LEGAL(at("%u to %u", (unsigned)from, (unsigned)to));
            TEST_ASSERT_EQUAL_UINT16_MESSAGE(to, drive.params.method, at("%u to %u", (unsigned)from, (unsigned)to));
        }
    }
}

/* ---- electrical zero ------------------------------------------------------------------------------------------------ */

static double theta_e(void)
{
    bench_period();
    return (double)drive.tracking.theta_e / TURN_STEPS * TWO_PI;
}

void test_drive_tune_of_the_encoder_offset_acts_at_once_when_the_encoder_is_absolute(void)
{
    bench_into(DRIVE_RUN);
    bench_angle(0.5);
    TEST_ASSERT_DOUBLE_WITHIN(2e-6, 2.0, theta_e());
    drive_params_t p = drive.params;
    p.encoder_offset_rad = 0.75f;
    TEST_ASSERT_TRUE(tune(&p));

    TEST_ASSERT_DOUBLE_WITHIN(2e-6, 2.75, theta_e());
}

void test_drive_tune_leaves_the_zero_that_an_alignment_has_found(void)
{
    drive_params_t p = bench_params();
    p.align_periods = BENCH_ALIGN_PERIODS;
    drive_init(&drive, &p);
    drive_background(&drive);
    bench_rotor(4.0, 2.0);
    bench_align();
    TEST_ASSERT_EQUAL_INT(DRIVE_RUN, drive.state);
    bench.rotor_pairs = 0.0;
    bench_angle(0.0); /* the rotor of the bench has its d axis at encoder angle 0 */

    p.encoder_offset_rad = 0.75f;
    p.align_periods = 0U; /* of the next start-up */
    TEST_ASSERT_TRUE(tune(&p));

    TEST_ASSERT_DOUBLE_WITHIN(5e-3, 0.0, remainder(theta_e(), TWO_PI)); /* as the alignment has found it */
}

/* ---- what the electrical angle stands on ------------------------------------------------------------------------------ */

void test_drive_tune_refuses_what_the_electrical_angle_stands_on_while_the_bridge_is_armed(void)
{
    const drive_state_t armed[] = {DRIVE_RUN, DRIVE_ALIGN};
    const uint16_t      param[] = {PARAM_pole_pairs, PARAM_encoder_reversed};
    for (size_t k = 0; k < 4U; k++) {
        bench_start();
        bench_into(armed[k / 2U]);
        drive_params_t p = drive.params;
        TEST_ASSERT_TRUE(params_set(&p, param[k % 2U], 1.0f));

        TEST_ASSERT_FALSE(tune(&p));

        TEST_ASSERT_EQUAL_STRING(params_info(param[k % 2U])->name, params_info(culprit)->name);
        TEST_ASSERT_TRUE(drive_needs_rest(&drive, culprit));
        bench_periods(2U);
        TEST_ASSERT_EQUAL_UINT16(4U, drive.setup.pole_pairs);
        TEST_ASSERT_FALSE(drive.setup.encoder_reversed);
    }
}

void test_drive_tune_takes_them_at_rest_and_everything_else_while_running(void)
{
    bench_into(DRIVE_READY);
    drive_params_t p = drive.params;
    p.pole_pairs = 3U;
    p.encoder_reversed = 1U;
    TEST_ASSERT_TRUE(tune(&p));
    TEST_ASSERT_FALSE(drive_needs_rest(&drive, PARAM_pole_pairs));

    bench_into(DRIVE_RUN);
    for (uint16_t k = 0U; k < (uint16_t)PARAM_COUNT; k++) {
        TEST_ASSERT_EQUAL_MESSAGE((k == (uint16_t)PARAM_pole_pairs) || (k == (uint16_t)PARAM_encoder_reversed),
                                  drive_needs_rest(&drive, k), params_info(k)->name);
    }
    TEST_ASSERT_FALSE(drive_needs_rest(&drive, PARAM_COUNT));
}

/* ---- bases of the fixed build --------------------------------------------------------------------------------------- */

static void assert_base_refused(uint16_t index, float value)
{
    drive_params_t p = drive.params;
    TEST_ASSERT_TRUE(params_set(&p, index, value));
    TEST_ASSERT_FALSE(tune(&p));
    TEST_ASSERT_EQUAL_STRING(params_info(index)->name, params_info(culprit)->name);
}

void test_drive_tune_in_fixed_point_refuses_a_new_base_by_the_name_of_its_parameter(void)
{
    FIXED_ONLY();
    bench_into(DRIVE_RUN);
    assert_base_refused(PARAM_over_current_a, 30.0f);
    assert_base_refused(PARAM_over_voltage_v, 50.0f);
    assert_base_refused(PARAM_over_speed_rad_s, 700.0f);
    assert_base_refused(PARAM_speed_error_gain, 1.0f);
}

/* the product of the two is a base as well, and stays */
void test_drive_tune_in_fixed_point_is_not_fooled_by_two_changes_that_cancel(void)
{
    FIXED_ONLY();
    bench_into(DRIVE_RUN);
    drive_params_t p = drive.params;
    p.over_speed_rad_s *= 2.0f;
    p.speed_error_gain *= 0.5f;

    TEST_ASSERT_FALSE(tune(&p));
    TEST_ASSERT_EQUAL_UINT16(PARAM_over_speed_rad_s, culprit);
}

void test_drive_tune_in_float_takes_new_limits(void)
{
    FLOAT_ONLY();
    bench_into(DRIVE_RUN);
    drive_params_t p = drive.params;
    p.over_current_a = 15.0f;
    p.over_speed_rad_s = 100.0f;
    TEST_ASSERT_TRUE(tune(&p));
    bench_period();

    bench.sample.ia_a = 16.0f;
    bench_period();
    ASSERT_FAULT(FAULT_over_current, "16 of 15 A");
}
