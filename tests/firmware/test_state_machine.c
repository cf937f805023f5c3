/* firmware/app/state_machine.c: every way from state to state, and the interrupt that comes in the middle of one. */
#include "firmware/app/telemetry.h"
#include "firmware/app/internal.h"
#include "mock_hal_clock.h"
#include "mock_hal_encoder.h"
#include "mock_hal_inverter.h"
#include "mock_hal_limits.h"
#include "mock_hal_sample.h"
#include "tests/firmware/support/bench.h"

void setUp(void) { bench_start(); }
void tearDown(void) {}

#define ALIGNS BENCH_ALIGN_PERIODS

static drive_params_t params(uint16_t calibration, uint16_t alignment)
{
    drive_params_t p = bench_params();
    p.offset_calibration_periods = calibration;
    p.align_periods = alignment;
    return p;
}

static void init(uint16_t calibration, uint16_t alignment)
{
    const drive_params_t p = params(calibration, alignment);
    drive_init(&drive, &p);
}

static void pass_to(drive_state_t expected)
{
    drive_background(&drive);
    TEST_ASSERT_EQUAL_INT(expected, drive.state);
}

/* ---- start-up ------------------------------------------------------------------------------------------------------- */

void test_state_machine_starts_in_init_with_the_bridge_off(void)
{
    init(100U, ALIGNS);

    TEST_ASSERT_EQUAL_INT(DRIVE_INIT, drive.state);
    TEST_ASSERT_EQUAL_INT(FAULT_none, drive.fault);
    TEST_ASSERT_TRUE(bench.disarms > 0U);
    TEST_ASSERT_EQUAL_UINT32(0U, bench.arms);
}

void test_state_machine_init_forgets_everything_of_before(void)
{
    bench_into(DRIVE_FAULT);
    init(0U, 0U);

    TEST_ASSERT_EQUAL_INT(DRIVE_INIT, drive.state);
    TEST_ASSERT_EQUAL_INT(FAULT_none, drive.fault);
    TEST_ASSERT_EQUAL_UINT32(0U, drive_rejected(&drive));
}

void test_state_machine_goes_from_init_to_what_is_wanted_first(void)
{
    init(10U, ALIGNS);
    pass_to(DRIVE_OFFSET_CALIBRATION);
    init(0U, ALIGNS);
    pass_to(DRIVE_READY);
    init(0U, 0U);
    pass_to(DRIVE_READY);
}

void test_state_machine_start_up_ends_in_ready_and_nothing_more_comes_without_a_start(void)
{
    init(20U, ALIGNS);
    pass_to(DRIVE_OFFSET_CALIBRATION);
    bench_periods(19U);
    pass_to(DRIVE_OFFSET_CALIBRATION);
    bench_periods(1U);
    pass_to(DRIVE_READY);
    TEST_ASSERT_FALSE(drive_zero_is_known(&drive));
    bench_live(20000U);

    TEST_ASSERT_EQUAL_INT(DRIVE_READY, drive.state);
    TEST_ASSERT_EQUAL_UINT32(0U, bench.arms);
}

void test_state_machine_start_aligns_first_and_then_runs(void)
{
    init(0U, ALIGNS);
    bench_rotor(4.0, 1.0);
    pass_to(DRIVE_READY);
    drive_start(&drive);
    pass_to(DRIVE_ALIGN);
    bench_live(BENCH_WAIT_PERIODS - 20U);
    TEST_ASSERT_EQUAL_UINT32(0U, bench.arms); /* it looks whether the shaft rests */
    bench_live(40U);
    TEST_ASSERT_TRUE(bench.armed);
    bench_live(ALIGNS - 200U);
    TEST_ASSERT_EQUAL_INT(DRIVE_ALIGN, drive.state);
    bench_live(250U);
    TEST_ASSERT_EQUAL_INT(DRIVE_RUN, drive.state);
    TEST_ASSERT_TRUE(drive_zero_is_known(&drive));

    drive_stop(&drive);
    pass_to(DRIVE_READY);
    drive_start(&drive);
    pass_to(DRIVE_RUN); /* once is enough */
}

void test_state_machine_bridge_is_armed_only_while_aligning_and_running(void)
{
    init(10U, ALIGNS);
    bench_rotor(4.0, 1.0);
    TEST_ASSERT_FALSE(bench.armed);
    pass_to(DRIVE_OFFSET_CALIBRATION);
    TEST_ASSERT_FALSE(bench.armed);
    bench_periods(10U);
    pass_to(DRIVE_READY);
    TEST_ASSERT_FALSE(bench.armed);
    drive_start(&drive);
    pass_to(DRIVE_ALIGN);
    TEST_ASSERT_FALSE(bench.armed);
    bench_live(BENCH_WAIT_PERIODS + 20U);
    TEST_ASSERT_TRUE(bench.armed);
    bench_live(ALIGNS + 50U);
    TEST_ASSERT_EQUAL_INT(DRIVE_RUN, drive.state);
    TEST_ASSERT_TRUE(bench.armed);
    drive_stop(&drive);
    pass_to(DRIVE_READY);
    TEST_ASSERT_FALSE(bench.armed);
}

/* auto_run is a matter of who powers the drive up, see services.c: here it does nothing, at rest and changed live. */
void test_state_machine_auto_run_starts_nothing(void)
{
    drive_params_t p = params(0U, 0U);
    uint16_t       culprit;
    p.auto_run = 1U;
    drive_init(&drive, &p);
    bench_live(1000U);
    TEST_ASSERT_EQUAL_INT(DRIVE_READY, drive.state);

    p.auto_run = 0U;
    drive_init(&drive, &p);
    bench_live(10U);
    p.auto_run = 1U;
    TEST_ASSERT_TRUE(drive_tune(&drive, &p, &culprit));
    bench_live(1000U);
    TEST_ASSERT_EQUAL_INT(DRIVE_READY, drive.state);
    TEST_ASSERT_EQUAL_UINT32(0U, bench.arms);
}

/* 10 s each; what a client may do without a start. */
void test_state_machine_nothing_but_a_start_arms_the_bridge(void)
{
    const uint16_t param[] = {PARAM_pole_pairs, PARAM_encoder_reversed, PARAM_auto_run, PARAM_align_periods};
    const float    other[] = {3.0f, 1.0f, 1.0f, 60000.0f};
    for (size_t k = 0; k < COUNT_OF(param); k++) {
        bench_start();
        init(0U, ALIGNS);
        bench_rotor(4.0, 1.0);
        pass_to(DRIVE_READY);
        bench_align();
        TEST_ASSERT_EQUAL_INT(DRIVE_RUN, drive.state);
        drive_stop(&drive);
        pass_to(DRIVE_READY);
        const uint32_t arms = bench.arms;
        drive_params_t p = *drive.params;
        uint16_t       culprit;
        TEST_ASSERT_TRUE(params_set(&p, param[k], other[k]));
        TEST_ASSERT_TRUE(drive_tune(&drive, &p, &culprit));
        bench_live(1000U);
        bench.sample_status = HAL_SENSOR_FAULT;
        bench_period();
        bench.sample_status = HAL_OK;
        ASSERT_FAULT(FAULT_encoder_error, "provoked");
        drive_clear_fault(&drive);
        bench_live(100000U);
        TEST_ASSERT_EQUAL_INT(DRIVE_READY, drive.state);
        TEST_ASSERT_EQUAL_UINT32_MESSAGE(arms, bench.arms, params_info(param[k])->name);
    }
}

/* ---- offset calibration --------------------------------------------------------------------------------------------- */

static void calibrate(uint16_t periods)
{
    init(periods, 0U);
    pass_to(DRIVE_OFFSET_CALIBRATION);
}

void test_state_machine_offsets_are_the_means_over_the_calibration(void)
{
    calibrate(100U);
    for (int k = 0; k < 100; k++) { /* 0.1 A and a ramp around it; -0.2 A and a square wave; their negative sum */
        bench.sample.ia_a = 0.1f + 0.001f * ((float)k - 49.5f);
        bench.sample.ib_a = -0.2f + ((k % 2 == 0) ? 0.05f : -0.05f);
        bench.sample.ic_a = -bench.sample.ia_a - bench.sample.ib_a;
        bench_period();
    }
    pass_to(DRIVE_READY);

    /* a sum of 100 floats up to 20 */
    TEST_ASSERT_FLOAT_WITHIN(2e-6f, 0.1f, drive.offset_a_a);
    TEST_ASSERT_FLOAT_WITHIN(2e-6f, -0.2f, drive.offset_b_a);
    TEST_ASSERT_FLOAT_WITHIN(2e-6f, 0.1f, drive.offset_c_a);
}

void test_state_machine_offsets_are_taken_off_every_later_sample(void)
{
    calibrate(10U);
    bench.sample.ia_a = 0.25f;
    bench.sample.ib_a = -0.125f;
    bench.sample.ic_a = -0.125f;
    bench_periods(10U);
    pass_to(DRIVE_READY);
    bench_periods(1U);

    TEST_ASSERT_EQUAL_FLOAT(0.0f, drive.ia_a);
    TEST_ASSERT_EQUAL_FLOAT(0.0f, drive.ib_a);
    TEST_ASSERT_EQUAL_FLOAT(0.0f, drive.ic_a);
}

void test_state_machine_over_current_limit_counts_after_the_offset(void)
{
    calibrate(10U);
    bench.sample.ia_a = 0.4f;
    bench.sample.ic_a = -0.4f;
    bench_periods(10U);
    pass_to(DRIVE_READY);
    bench.sample.ia_a = 20.3f; /* 19.9 A */
    bench_period();
    ASSERT_NO_FAULT("19.9 A");
    bench.sample.ia_a = 20.5f;
    bench_period();
    ASSERT_FAULT(FAULT_over_current, "20.1 A");
}

static void assert_offset_limit(float a, float b, float c, bool allowed)
{
    bench_start();
    calibrate(10U);
    bench.sample.ia_a = a;
    bench.sample.ib_a = b;
    bench.sample.ic_a = c;
    bench_periods(10U);
    drive_background(&drive);
    if (allowed) {
        TEST_ASSERT_EQUAL_INT_MESSAGE(DRIVE_READY, drive.state, at("%g %g %g", (double)a, (double)b, (double)c));
    } else {
        ASSERT_FAULT(FAULT_offset_calibration, at("%g %g %g", (double)a, (double)b, (double)c));
    }
}

void test_state_machine_offset_beyond_its_limit_is_a_fault(void)
{
    assert_offset_limit(0.49f, -0.49f, 0.0f, true);
    assert_offset_limit(0.51f, 0.0f, 0.0f, false);
    assert_offset_limit(-0.51f, 0.0f, 0.0f, false);
    assert_offset_limit(0.0f, 0.51f, 0.0f, false);
    assert_offset_limit(0.0f, -0.51f, 0.0f, false);
}

/* the third may be the negative sum of the other two */
void test_state_machine_offset_of_the_third_phase_may_be_twice_as_large(void)
{
    assert_offset_limit(0.45f, 0.45f, -0.9f, true);
    assert_offset_limit(0.0f, 0.0f, 1.01f, false);
    assert_offset_limit(0.0f, 0.0f, -1.01f, false);
}

void test_state_machine_samples_that_were_lost_do_not_thin_the_mean(void)
{
    calibrate(40U);
    bench.sample.ia_a = 0.3f;
    bench.sample.ic_a = -0.3f;
    for (int k = 0; k < 20; k++) {
        bench.seq_by_itself = false;
        bench.sample_status = HAL_STALE;
        bench_periods(1U);
        bench.seq_by_itself = true;
        bench.sample_status = HAL_OK;
        bench_periods(2U);
    }
    pass_to(DRIVE_READY);

    TEST_ASSERT_FLOAT_WITHIN(1e-6f, 0.3f, drive.offset_a_a);
}

void test_state_machine_calibration_shortened_on_the_way_has_the_mean_of_what_it_saw(void)
{
    calibrate(1000U);
    bench.sample.ia_a = 0.3f;
    bench.sample.ic_a = -0.3f;
    bench_periods(200U);
    drive_params_t p = params(50U, 0U);
    uint16_t       culprit = 0U;
    TEST_ASSERT_TRUE(drive_tune(&drive, &p, &culprit));
    bench_periods(1U);
    pass_to(DRIVE_READY);

    TEST_ASSERT_FLOAT_WITHIN(1e-5f, 0.3f, drive.offset_a_a);
}

void test_state_machine_calibration_called_off_before_its_first_sample_leaves_the_offsets(void)
{
    calibrate(1000U);
    drive_params_t p = params(0U, 0U);
    uint16_t       culprit = 0U;
    TEST_ASSERT_TRUE(drive_tune(&drive, &p, &culprit));
    bench.sample_status = HAL_STALE;
    bench_periods(1U);
    pass_to(DRIVE_READY);

    TEST_ASSERT_EQUAL_FLOAT(0.0f, drive.offset_a_a);
}

void test_state_machine_second_calibration_knows_nothing_of_the_first(void)
{
    init(10U, ALIGNS);
    pass_to(DRIVE_OFFSET_CALIBRATION);
    bench.sample.ia_a = 0.4f;
    bench.sample.ib_a = -0.2f;
    bench.sample.ic_a = -0.2f;
    bench_periods(9U);
    bench.sample.vdc_v = 100.0f;
    bench_period();
    bench.sample.vdc_v = (float)BENCH_VDC;
    drive_clear_fault(&drive);
    pass_to(DRIVE_INIT);
    pass_to(DRIVE_OFFSET_CALIBRATION);
    bench.sample.ia_a = 0.1f;
    bench.sample.ib_a = 0.0f;
    bench.sample.ic_a = -0.1f;
    bench_periods(10U);
    pass_to(DRIVE_READY);

    TEST_ASSERT_FLOAT_WITHIN(1e-6f, 0.1f, drive.offset_a_a);
    TEST_ASSERT_FLOAT_WITHIN(1e-6f, 0.0f, drive.offset_b_a);
    TEST_ASSERT_FLOAT_WITHIN(1e-6f, -0.1f, drive.offset_c_a);
}

/* ---- alignment ------------------------------------------------------------------------------------------------------ */

static void aligned(double pairs, bool reversed)
{
    drive_params_t p = params(0U, ALIGNS);
    p.encoder_reversed = reversed ? 1U : 0U;
    drive_init(&drive, &p);
    bench_rotor(pairs, 2.3);
    pass_to(DRIVE_READY);
    bench_align();
    ASSERT_NO_FAULT("alignment");
    bench.rotor_pairs = 0.0;
}

static double theta_e(void)
{
    bench_period();
    return (double)drive.tracking.theta_e / TURN_STEPS * TWO_PI;
}

/* the rotor of the bench is 20 periods behind the vector, the same both ways */
void test_state_machine_alignment_stores_where_the_d_axis_is(void)
{
    aligned(4.0, false);
    bench_angle(0.0);
    TEST_ASSERT_DOUBLE_WITHIN(5e-3, 0.0, remainder(theta_e(), TWO_PI));
    bench_angle(0.1);
    TEST_ASSERT_DOUBLE_WITHIN(5e-3, 0.4, theta_e());
}

void test_state_machine_alignment_of_a_reversed_encoder_counts_the_other_way(void)
{
    aligned(-4.0, true);
    bench_angle(-0.1);

    TEST_ASSERT_DOUBLE_WITHIN(5e-3, 0.4, theta_e());
}

void test_state_machine_without_alignment_the_zero_is_the_parameter(void)
{
    drive_params_t p = params(0U, 0U);
    p.encoder_offset_rad = 1.25f;
    drive_init(&drive, &p);
    pass_to(DRIVE_READY);
    bench_angle(0.5);

    TEST_ASSERT_DOUBLE_WITHIN(4e-6, 2.0 + 1.25, theta_e());
}

void test_state_machine_lost_zero_without_alignment_is_the_parameter_again(void)
{
    aligned(4.0, false);
    drive_stop(&drive);
    pass_to(DRIVE_READY);
    drive_params_t p = *drive.params;
    uint16_t       culprit = 0U;
    p.align_periods = 0U;
    p.encoder_offset_rad = 1.25f;
    TEST_ASSERT_TRUE(drive_tune(&drive, &p, &culprit));
    bench_periods(1U);
    bench.sample_status = HAL_SENSOR_FAULT; /* the zero that was found is void */
    bench_period();
    bench.sample_status = HAL_OK;
    drive_clear_fault(&drive);
    pass_to(DRIVE_READY);
    bench_angle(0.5);
    TEST_ASSERT_DOUBLE_WITHIN(4e-6, 2.0 + 1.25, theta_e());

    p.encoder_offset_rad = 0.25f; /* and follows it from now on */
    TEST_ASSERT_TRUE(drive_tune(&drive, &p, &culprit));
    TEST_ASSERT_DOUBLE_WITHIN(4e-6, 2.0 + 0.25, theta_e());
}

/* ---- start and stop ------------------------------------------------------------------------------------------------- */

void test_state_machine_waits_in_ready_for_a_start(void)
{
    bench_into(DRIVE_READY);
    bench_live(200U);
    TEST_ASSERT_EQUAL_INT(DRIVE_READY, drive.state);

    drive_start(&drive);
    pass_to(DRIVE_RUN);
}

void test_state_machine_start_during_start_up_waits_for_its_end(void)
{
    init(10U, 0U);
    drive_start(&drive);
    pass_to(DRIVE_OFFSET_CALIBRATION);
    bench_periods(10U);
    pass_to(DRIVE_READY);
    pass_to(DRIVE_RUN);
}

void test_state_machine_stop_takes_back_a_start_that_waits(void)
{
    init(10U, 0U);
    drive_start(&drive);
    pass_to(DRIVE_OFFSET_CALIBRATION);
    drive_stop(&drive);
    bench_periods(10U);
    pass_to(DRIVE_READY);
    bench_live(100U);

    TEST_ASSERT_EQUAL_INT(DRIVE_READY, drive.state);
}

void test_state_machine_stop_and_start_at_once_stops(void)
{
    bench_into(DRIVE_READY);
    drive_start(&drive);
    drive_stop(&drive);
    bench_live(100U);

    TEST_ASSERT_EQUAL_INT(DRIVE_READY, drive.state);
    TEST_ASSERT_EQUAL_UINT32(0U, bench.arms);
}

void test_state_machine_second_start_while_running_does_not_survive_the_stop(void)
{
    bench_into(DRIVE_READY);
    drive_start(&drive);
    pass_to(DRIVE_RUN);
    drive_start(&drive);
    pass_to(DRIVE_RUN);
    drive_stop(&drive);
    pass_to(DRIVE_READY);
    bench_live(100U);

    TEST_ASSERT_EQUAL_INT(DRIVE_READY, drive.state);
    TEST_ASSERT_FALSE(bench.armed);
}

void test_state_machine_stop_before_the_start_has_no_memory(void)
{
    bench_into(DRIVE_READY);
    drive_stop(&drive);
    pass_to(DRIVE_READY);
    drive_start(&drive);
    pass_to(DRIVE_RUN);
    bench_live(50U);

    TEST_ASSERT_EQUAL_INT(DRIVE_RUN, drive.state);
}

void test_state_machine_stop_switches_an_alignment_off_and_a_start_aligns_again(void)
{
    init(0U, ALIGNS);
    bench_rotor(4.0, 1.0);
    pass_to(DRIVE_READY);
    drive_start(&drive);
    bench_live(BENCH_WAIT_PERIODS + 500U);
    TEST_ASSERT_TRUE(bench.armed);
    drive_stop(&drive);
    pass_to(DRIVE_READY);
    TEST_ASSERT_FALSE(bench.armed);
    const uint32_t arms = bench.arms;
    bench_live(5000U);
    TEST_ASSERT_EQUAL_INT(DRIVE_READY, drive.state);
    TEST_ASSERT_EQUAL_UINT32(arms, bench.arms);

    bench_align();
    TEST_ASSERT_EQUAL_INT(DRIVE_RUN, drive.state);
}

void test_state_machine_stop_while_it_waits_for_the_shaft_keeps_the_bridge_off(void)
{
    init(0U, ALIGNS);
    pass_to(DRIVE_READY);
    drive_start(&drive);
    bench_live(500U);
    TEST_ASSERT_EQUAL_INT(DRIVE_ALIGN, drive.state);
    drive_stop(&drive);
    pass_to(DRIVE_READY);
    bench_live(5000U);

    TEST_ASSERT_EQUAL_UINT32(0U, bench.arms);
}

void test_state_machine_stop_during_calibration_withdraws_the_start_and_nothing_is_armed(void)
{
    init(20U, ALIGNS);
    drive_start(&drive);
    pass_to(DRIVE_OFFSET_CALIBRATION);
    drive_stop(&drive);
    bench_live(5000U);

    TEST_ASSERT_EQUAL_INT(DRIVE_READY, drive.state);
    TEST_ASSERT_EQUAL_UINT32(0U, bench.arms);
}

void test_state_machine_stop_during_a_fault_keeps_the_drive_from_running_when_it_is_cleared(void)
{
    bench_into(DRIVE_RUN);
    bench.sample.vdc_v = 100.0f;
    bench_period();
    bench.sample.vdc_v = (float)BENCH_VDC;
    drive_stop(&drive);
    drive_background(&drive);
    drive_clear_fault(&drive);
    pass_to(DRIVE_READY);
    bench_live(100U);

    TEST_ASSERT_EQUAL_INT(DRIVE_READY, drive.state);
}

void test_state_machine_other_pole_pairs_or_direction_void_an_alignment(void)
{
    const uint16_t param[] = {PARAM_pole_pairs, PARAM_encoder_reversed};
    const float    other[] = {3.0f, 1.0f};
    for (size_t k = 0; k < COUNT_OF(param); k++) {
        bench_start();
        init(0U, ALIGNS);
        bench_rotor(4.0, 8.0); /* far from 0: with the other direction the angle jumps by 4 rad */
        pass_to(DRIVE_READY);
        bench_align();
        TEST_ASSERT_EQUAL_INT(DRIVE_RUN, drive.state);
        drive_stop(&drive);
        pass_to(DRIVE_READY);
        drive_params_t p = *drive.params;
        uint16_t       culprit;
        TEST_ASSERT_TRUE(params_set(&p, param[k], other[k]));
        TEST_ASSERT_TRUE(drive_tune(&drive, &p, &culprit));
        drive_start(&drive);
        pass_to(DRIVE_READY); /* not before the change has been taken over */
        bench_periods(1U);
        bench_rotor((k == 0U) ? 3.0 : -4.0, bench.rotor_e * ((k == 0U) ? 0.75 : -1.0));
        pass_to(DRIVE_ALIGN);
        bench_live(BENCH_WAIT_PERIODS + ALIGNS + 100U);
        TEST_ASSERT_EQUAL_INT_MESSAGE(DRIVE_RUN, drive.state, params_info(param[k])->name);
        bench_periods(50U);
        ASSERT_NO_FAULT(params_info(param[k])->name);
    }
}

void test_state_machine_shows_no_command_once_the_bridge_is_off(void)
{
    static const uint16_t COMMANDS[] = {
        SIGNAL_speed_ref_rad_s, SIGNAL_id_ref_a,           SIGNAL_iq_ref_a, SIGNAL_vd_v, SIGNAL_vq_v,
        SIGNAL_compensation_a,  SIGNAL_velocity_ref_rad_s, SIGNAL_robust_a};
    drive_params_t p = bench_params();
    p.auto_run = 0U;
    p.speed_inline = 1U;
    drive_init(&drive, &p);
    pass_to(DRIVE_READY);
    for (int k = 0; k < 2; k++) { /* a stop, then a fault */
        drive_start(&drive);
        pass_to(DRIVE_RUN);
        bench_command(DRIVE_MODE_SPEED, 30.0, -0.5, 0.0);
        bench_periods(50U);
        TEST_ASSERT_EQUAL_FLOAT(30.0f, telemetry_read(&drive, SIGNAL_speed_ref_rad_s));
        TEST_ASSERT_TRUE(telemetry_read(&drive, SIGNAL_iq_ref_a) > 0.01f);
        TEST_ASSERT_TRUE(telemetry_read(&drive, SIGNAL_vq_v) > 0.01f);
        if (k == 0) {
            drive_stop(&drive);
            pass_to(DRIVE_READY);
        } else {
            bench.sample.vdc_v = 100.0f;
            bench_period();
            bench.sample.vdc_v = (float)BENCH_VDC;
            TEST_ASSERT_TRUE(telemetry_read(&drive, SIGNAL_vq_v) > 0.01f); /* the row of the fault shows what led to it */
            pass_to(DRIVE_FAULT);
        }
        bench_periods(20U); /* nobody brings them back */
        for (size_t i = 0U; i < (sizeof(COMMANDS) / sizeof(COMMANDS[0])); i++) {
            TEST_ASSERT_EQUAL_FLOAT_MESSAGE(0.0f, telemetry_read(&drive, COMMANDS[i]), telemetry_info(COMMANDS[i])->name);
        }
    }
}

void test_state_machine_start_begins_with_controllers_at_rest(void)
{
    drive_params_t p = bench_params();
    p.current_ki_v_per_as = 1080.0f;
    drive_init(&drive, &p);
    pass_to(DRIVE_READY);
    for (int k = 0; k < 2; k++) {
        drive_start(&drive);
        pass_to(DRIVE_RUN);
        bench_command(DRIVE_MODE_CURRENT, 0.0, -0.5, 1.0);
        bench_periods(1U);
        TEST_ASSERT_FLOAT_WITHIN(2e-5f, 0.6f, telemetry_read(&drive, SIGNAL_vq_v));
        TEST_ASSERT_FLOAT_WITHIN(2e-5f, -0.3f, telemetry_read(&drive, SIGNAL_vd_v));
        bench_periods(50U);
        drive_stop(&drive);
        pass_to(DRIVE_READY);
    }
}

void test_state_machine_bridge_that_cannot_be_armed_is_a_fault(void)
{
    bench_into(DRIVE_READY);
    bench.arm_status = HAL_SENSOR_FAULT;
    drive_start(&drive);
    drive_background(&drive);

    ASSERT_FAULT(FAULT_gate_driver, "arm refused");
}

void test_state_machine_alignment_that_cannot_be_armed_is_a_fault(void)
{
    init(0U, ALIGNS);
    bench.arm_status = HAL_SENSOR_FAULT;
    drive_start(&drive);
    bench_live(BENCH_WAIT_PERIODS + 50U);

    ASSERT_FAULT(FAULT_gate_driver, "arm refused");
}

/* ---- faults --------------------------------------------------------------------------------------------------------- */

static void over_voltage_now(void)
{
    bench.sample.vdc_v = 100.0f;
    bench_period();
    bench.sample.vdc_v = (float)BENCH_VDC;
}

void test_state_machine_clear_leads_from_a_fault_back_to_ready(void)
{
    bench_into(DRIVE_RUN);
    over_voltage_now();
    ASSERT_FAULT(FAULT_over_voltage, "provoked");

    drive_clear_fault(&drive);
    pass_to(DRIVE_READY);

    TEST_ASSERT_EQUAL_INT(FAULT_none, drive.fault);
    TEST_ASSERT_EQUAL_UINT32(1U, bench.clears);
    drive_start(&drive);
    pass_to(DRIVE_RUN);
}

void test_state_machine_clear_without_a_fault_has_no_memory(void)
{
    bench_into(DRIVE_READY);
    drive_clear_fault(&drive);
    pass_to(DRIVE_READY);
    over_voltage_now();
    bench_live(100U);

    ASSERT_FAULT(FAULT_over_voltage, "cleared before it came");
    TEST_ASSERT_EQUAL_UINT32(0U, bench.clears);
}

void test_state_machine_start_during_a_fault_does_not_survive_the_clear(void)
{
    bench_into(DRIVE_READY);
    over_voltage_now();
    drive_start(&drive);
    bench_live(20U);
    drive_clear_fault(&drive);
    bench_live(100U);

    TEST_ASSERT_EQUAL_INT(DRIVE_READY, drive.state);
    TEST_ASSERT_EQUAL_UINT32(0U, bench.arms);
}

void test_state_machine_fault_whose_cause_stands_comes_back(void)
{
    bench_into(DRIVE_READY);
    bench.inverter_fault = HAL_INVERTER_OVER_TEMPERATURE;
    bench_period();
    drive_clear_fault(&drive);
    bench_live(20U);

    ASSERT_FAULT(FAULT_over_temperature, "still hot");
}

void test_state_machine_counters_start_again_after_a_clear(void)
{
    bench_into(DRIVE_READY);
    bench.sample_status = HAL_STALE;
    bench_periods(3U);
    ASSERT_FAULT(FAULT_lost_sample, "three");
    drive_clear_fault(&drive);
    drive_background(&drive);
    bench_periods(2U);
    ASSERT_NO_FAULT("two more");
    bench.sample_status = HAL_OK;
    bench_period();

    bench.sample.ia_a = NAN;
    bench_periods(3U);
    ASSERT_FAULT(FAULT_non_finite, "three");
    drive_clear_fault(&drive);
    drive_background(&drive);
    bench_periods(2U);
    ASSERT_NO_FAULT("two more");
}

void test_state_machine_configuration_fault_cannot_be_cleared(void)
{
    drive_params_t p = bench_params();
    p.pole_pairs = 0U;
    drive_init(&drive, &p);
    drive_clear_fault(&drive);
    bench_live(20U);

    ASSERT_FAULT(FAULT_configuration, "only drive_init helps");
    TEST_ASSERT_EQUAL_UINT16(PARAM_pole_pairs, drive.fault_detail);

    p.pole_pairs = 4U;
    drive_init(&drive, &p);
    ASSERT_NO_FAULT("new parameters");
}

void test_state_machine_fault_during_calibration_starts_up_again(void)
{
    init(10U, ALIGNS);
    pass_to(DRIVE_OFFSET_CALIBRATION);
    over_voltage_now();
    drive_clear_fault(&drive);
    pass_to(DRIVE_INIT);
    pass_to(DRIVE_OFFSET_CALIBRATION);
    bench_periods(10U);
    pass_to(DRIVE_READY);
}

/* a drive that does not know its electrical zero would run away */
void test_state_machine_start_after_a_fault_during_alignment_aligns_again(void)
{
    init(0U, ALIGNS);
    bench_rotor(4.0, 1.0);
    pass_to(DRIVE_READY);
    drive_start(&drive);
    bench_live(BENCH_WAIT_PERIODS + 500U);
    over_voltage_now();
    drive_clear_fault(&drive);
    pass_to(DRIVE_READY);
    TEST_ASSERT_FALSE(drive_zero_is_known(&drive));
    bench_align();
    TEST_ASSERT_EQUAL_INT(DRIVE_RUN, drive.state);
}

void test_state_machine_encoder_that_may_have_lost_counts_is_aligned_again_with_the_next_start(void)
{
    init(0U, ALIGNS);
    bench_rotor(4.0, 1.0);
    pass_to(DRIVE_READY);
    bench_align();
    bench.sample_status = HAL_SENSOR_FAULT;
    bench_period();
    bench.sample_status = HAL_OK;
    ASSERT_FAULT(FAULT_encoder_error, "phase error");

    drive_clear_fault(&drive);
    pass_to(DRIVE_READY);
    TEST_ASSERT_FALSE(drive_zero_is_known(&drive));
    bench_align();
    TEST_ASSERT_EQUAL_INT(DRIVE_RUN, drive.state);
}

/* a wrong zero turns the motor against its limits, too: these may have been its work */
void test_state_machine_faults_that_a_wrong_zero_makes_are_followed_by_an_alignment(void)
{
    for (int f = FAULT_none + 1; f < FAULT_COUNT; f++) {
        const bool doubt = (f == FAULT_encoder_lost) || (f == FAULT_encoder_error) || (f == FAULT_stall) ||
                           (f == FAULT_over_speed) || (f == FAULT_speed_deviation) || (f == FAULT_electrical_zero) ||
                           (f == FAULT_encoder_index) ||
                           (f == FAULT_current_implausible); /* the angle is in the motor's equations */
        TEST_ASSERT_EQUAL_MESSAGE(doubt, drive_fault_voids_zero((drive_fault_t)f), faults_info((uint16_t)f)->name);
    }
}

void test_state_machine_other_faults_keep_the_electrical_zero(void)
{
    aligned(4.0, false);
    const angle_t zero = drive.zero.e;
    over_voltage_now();
    drive_clear_fault(&drive);
    pass_to(DRIVE_READY);

    TEST_ASSERT_TRUE(drive_zero_is_known(&drive));
    TEST_ASSERT_EQUAL_HEX32(zero, drive.zero.e);
}

/* ---- the interrupt comes in the middle ------------------------------------------------------------------------------ */

/* It finds a current that trips while the main loop is inside a HAL function. */
static void over_current_interrupt(void)
{
    const float before = bench.sample.ia_a;
    bench.sample.ia_a = 25.0f;
    bench.sample.seq++;
    drive_current_isr(&drive);
    bench.sample.ia_a = before;
}

static void assert_trip_held(const char *when)
{
    ASSERT_FAULT(FAULT_over_current, when);
    bench_live(50U);
    ASSERT_FAULT(FAULT_over_current, when);
}

void test_state_machine_trip_while_arming_for_run_is_not_lost(void)
{
    bench_into(DRIVE_READY);
    bench.in_arm = over_current_interrupt;
    drive_start(&drive);
    drive_background(&drive);

    assert_trip_held("the bridge was armed after the trip");
}

void test_state_machine_trip_while_arming_for_alignment_is_not_lost(void)
{
    init(0U, ALIGNS);
    bench.in_arm = over_current_interrupt;
    drive_start(&drive);
    bench_live(BENCH_WAIT_PERIODS + 50U);

    assert_trip_held("alignment");
}

static void to_the_end_of_an_alignment(void)
{
    init(0U, ALIGNS);
    bench_rotor(4.0, 1.0);
    pass_to(DRIVE_READY);
    drive_start(&drive);
    drive_background(&drive);
    for (int k = 0; (k < 20000) && (drive.align.phase != DRIVE_ALIGN_DONE); k++) {
        bench_period();
        if (drive.align.phase == DRIVE_ALIGN_RESTS) {
            drive_background(&drive);
        }
    }
    TEST_ASSERT_EQUAL_INT(DRIVE_ALIGN_DONE, drive.align.phase);
}

void test_state_machine_trip_at_the_end_of_alignment_is_not_lost(void)
{
    to_the_end_of_an_alignment();
    bench.in_disarm = over_current_interrupt;
    drive_background(&drive);

    assert_trip_held("end of alignment");
}

void test_state_machine_trip_while_stopping_is_not_lost(void)
{
    bench_into(DRIVE_RUN);
    drive_stop(&drive);
    bench.in_disarm = over_current_interrupt;
    drive_background(&drive);

    assert_trip_held("stop");
}

void test_state_machine_alignment_that_tripped_at_its_end_does_not_count(void)
{
    to_the_end_of_an_alignment();
    bench.in_disarm = over_current_interrupt;
    drive_background(&drive);
    drive_clear_fault(&drive);
    pass_to(DRIVE_READY);

    TEST_ASSERT_FALSE(drive_zero_is_known(&drive));
}

void test_state_machine_trip_while_clearing_is_seen_again(void)
{
    bench_into(DRIVE_FAULT);
    bench.in_clear = over_current_interrupt;
    drive_clear_fault(&drive);
    drive_background(&drive);
    TEST_ASSERT_FALSE(bench.armed); /* this trip belongs to the fault that is being cleared... */

    bench.sample.ia_a = 25.0f;
    bench_period();
    ASSERT_FAULT(FAULT_over_current, "...and comes back when its cause stands");
}

/* ---- what one pass leaves behind --------------------------------------------------------------------------------------- */

/* The offsets come as the mean of equal samples: exact. */
void test_state_machine_offset_of_exactly_its_limit_is_allowed(void)
{
    assert_offset_limit(0.5f, -0.5f, 0.0f, true);
    assert_offset_limit(-0.5f, 0.5f, 0.0f, true);
}

void test_state_machine_calibration_of_one_sample_is_one(void)
{
    init(1U, 0U);
    pass_to(DRIVE_OFFSET_CALIBRATION);
    bench_period();
    pass_to(DRIVE_READY);
}

/* The permit goes with a stop and with a fault, and without it nothing is armed, whoever asks. */
void test_state_machine_permit_ends_with_a_stop_and_with_a_fault(void)
{
    bench_into(DRIVE_RUN);
    TEST_ASSERT_TRUE(drive.permitted);
    drive_stop(&drive);
    drive_background(&drive);
    TEST_ASSERT_FALSE(drive.permitted);

    bench_into(DRIVE_RUN);
    bench.sample.vdc_v = 100.0f;
    bench_period();
    drive_background(&drive);
    TEST_ASSERT_FALSE(drive.permitted);
}

void test_state_machine_alignment_without_a_permit_goes_no_further(void)
{
    init(0U, ALIGNS);
    pass_to(DRIVE_READY);
    drive_start(&drive);
    drive_background(&drive);
    for (uint32_t k = 0U; (k < 2U * BENCH_WAIT_PERIODS) && (drive.align.phase != DRIVE_ALIGN_RESTS); k++) {
        bench_period();
    }
    TEST_ASSERT_EQUAL_INT(DRIVE_ALIGN_RESTS, drive.align.phase);
    drive.start_wanted = false; /* as a bit that flips would have it */
    drive.permitted = false;
    drive_background(&drive);

    TEST_ASSERT_EQUAL_UINT32(0U, bench.arms);
    TEST_ASSERT_EQUAL_INT(DRIVE_ALIGN_RESTS, drive.align.phase);
}

/* A start is used up by the run that it leads to. */
void test_state_machine_run_leaves_no_start_behind(void)
{
    init(0U, 0U);
    pass_to(DRIVE_READY);
    drive_start(&drive);
    pass_to(DRIVE_RUN);
    TEST_ASSERT_FALSE(drive.start_wanted);
}

void test_state_machine_figures_of_a_run_begin_with_it_and_a_refused_start_keeps_them(void)
{
    init(0U, 0U);
    TEST_ASSERT_NOT_EQUAL_UINT16(0U, drive.timing.epoch); /* the start-up has its own */
    pass_to(DRIVE_READY);
    const uint16_t before = drive.timing.epoch;
    drive_start(&drive);
    pass_to(DRIVE_RUN);
    TEST_ASSERT_NOT_EQUAL_UINT16(before, drive.timing.epoch);

    bench_into(DRIVE_READY);
    const uint16_t ready = drive.timing.epoch;
    bench.arm_status = HAL_SENSOR_FAULT;
    drive_start(&drive);
    drive_background(&drive);
    ASSERT_FAULT(FAULT_gate_driver, "not armed");
    TEST_ASSERT_EQUAL_UINT16(ready, drive.timing.epoch);

    drive_restart_timing(&drive);
    TEST_ASSERT_NOT_EQUAL_UINT16(ready, drive.timing.epoch);
}

void test_state_machine_start_into_a_fast_motor_keeps_the_figures(void)
{
    bench_into(DRIVE_READY);
    bench_spin(500.0, 0.0);
    const uint16_t before = drive.timing.epoch;
    drive_start(&drive);
    drive_background(&drive);
    ASSERT_FAULT(FAULT_start_turning, "500 rad/s");
    TEST_ASSERT_EQUAL_UINT16(before, drive.timing.epoch);
}

static void gets_hot(void) { bench.inverter_fault = HAL_INVERTER_OVER_TEMPERATURE; }

void test_state_machine_bridge_that_refuses_says_why_in_the_same_pass(void)
{
    bench_into(DRIVE_READY);
    bench.arm_status = HAL_SENSOR_FAULT;
    bench.in_arm = gets_hot;
    drive_start(&drive);
    drive_background(&drive);
    ASSERT_FAULT(FAULT_over_temperature, "the reason, not that it was refused");
}

/* The hardware arms after the interrupt has switched off: the pass that armed takes it back itself. */
void test_state_machine_trip_while_arming_for_alignment_is_off_in_the_same_pass(void)
{
    init(0U, ALIGNS);
    pass_to(DRIVE_READY);
    drive_start(&drive);
    drive_background(&drive);
    for (uint32_t k = 0U; (k < 2U * BENCH_WAIT_PERIODS) && (drive.align.phase != DRIVE_ALIGN_RESTS); k++) {
        bench_period();
    }
    bench.in_arm = over_current_interrupt;
    drive_background(&drive);
    ASSERT_FAULT(FAULT_over_current, "between the check and the arming");
}

void test_state_machine_clear_leaves_no_detail_and_no_jump_of_the_encoder(void)
{
    bench_into(DRIVE_FAULT);
    drive.fault_detail = 7U;
    drive.tracking.jump_periods = 3U;
    drive_clear_fault(&drive);
    pass_to(DRIVE_READY);
    TEST_ASSERT_EQUAL_UINT16(0U, drive_fault_detail(&drive));
    TEST_ASSERT_EQUAL_UINT16(0U, drive.tracking.jump_periods);
}

/* Each pass attends to what may wait for it. */
void test_state_machine_pass_attends_to_stall_and_restarts(void)
{
    drive_params_t p = bench_params();
    p.restart_limit = 3U;
    p.restart_window_s = 1.0f;
    bench_run_with(&p);
    drive.restarts.at[0] = drive.sample.seq;
    drive.restarts.count = 1U;
    drive.stall.since = drive.sample.seq - 5U;
    drive_background(&drive);
    TEST_ASSERT_EQUAL_UINT32(drive.sample.seq, drive.stall.since); /* nothing pushes: its time begins again */
    TEST_ASSERT_EQUAL_UINT16(1U, drive.restarts.count);
    bench_live(10100U);
    TEST_ASSERT_EQUAL_UINT16(0U, drive.restarts.count); /* older than the window */
}

static void run_aro(float drift, drive_mode_t mode)
{
    drive_params_t p = bench_params();
    p.method = (uint16_t)DRIVE_METHOD_ARO;
    p.aro_drift_counts = drift;
    p.following_error_rad = 100.0f;
    bench_run_with(&p);
    bench_command(mode, 20.0, 0.0, 0.0);
    bench_live(20U);
}

void test_state_machine_observer_drifts_in_speed_mode_and_by_its_parameter_only(void)
{
    run_aro(0.0f, DRIVE_MODE_SPEED);
    TEST_ASSERT_FALSE(drive.observer.observer.state.drifts);
    run_aro(1.0f, DRIVE_MODE_SPEED);
    TEST_ASSERT_TRUE(drive.observer.observer.state.drifts);
    run_aro(1.0f, DRIVE_MODE_CURRENT);
    TEST_ASSERT_FALSE(drive.observer.observer.state.drifts);
}

void test_state_machine_pass_in_init_forgets_offsets_and_zero_of_before(void)
{
    init(10U, 0U);
    drive.started_up = true;
    drive.zero.found = true;
    drive.zero.e = 12345U;
    pass_to(DRIVE_OFFSET_CALIBRATION);
    TEST_ASSERT_FALSE(drive.started_up);
    TEST_ASSERT_FALSE(drive.zero.found);
    TEST_ASSERT_EQUAL_UINT32(drive.setup->tracking.encoder_offset, drive.zero.e);
}

/* Order of the rounding and quality figure of the angle observer are the main loop's. */
void test_state_machine_pass_keeps_rounding_and_quality_of_the_observer(void)
{
    run_aro(0.0f, DRIVE_MODE_SPEED);
    ctl_observer_state_t *const s = &drive.observer.observer.state;
    s->memory.state.primed = true;
    s->memory.state.value = num_from_float(0.5f);
    s->wait = 0U;
    s->held = false;
    s->synchronous = false;
    s->seen = (num_t)0;
    s->kept_rounding = 0xBEEFU;
    drive_background(&drive);
    TEST_ASSERT_NOT_EQUAL_UINT16(0xBEEFU, s->kept_rounding);
    TEST_ASSERT_TRUE(s->seen > (num_t)0);
}
