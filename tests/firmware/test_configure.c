/* firmware/app/configure.c: what does not fit together is refused by name, what fits arrives in the blocks. */
#include "mock_hal_clock.h"
#include "mock_hal_encoder.h"
#include "mock_hal_inverter.h"
#include "mock_hal_limits.h"
#include "mock_hal_sample.h"
#include "tests/firmware/support/bench.h"

static drive_params_t params;

void setUp(void)
{
    bench_start();
    params_default(&params);
}
void tearDown(void) {}

static void assert_refused(uint16_t culprit)
{
    drive_init(&drive, &params);

    ASSERT_FAULT(FAULT_configuration, params_info(culprit)->name);
    TEST_ASSERT_TRUE(drive.fault_detail < (uint16_t)PARAM_COUNT);
    TEST_ASSERT_EQUAL_STRING(params_info(culprit)->name, params_info(drive.fault_detail)->name);
}

static void assert_accepted(const char *what)
{
    drive_init(&drive, &params);

    TEST_ASSERT_EQUAL_STRING_MESSAGE("none", faults_info((uint16_t)drive.fault)->name,
                                     (drive.fault == FAULT_configuration) ? params_info(drive.fault_detail)->name : what);
    TEST_ASSERT_EQUAL_INT_MESSAGE(DRIVE_INIT, drive.state, what);
}

/* ---- refusals ------------------------------------------------------------------------------------------------------- */

void test_configure_defaults_are_accepted_with_every_method(void)
{
    for (uint16_t method = 0U; method <= (uint16_t)params_info(PARAM_method)->max; method++) {
        params.method = method;
        assert_accepted(at("method %u", (unsigned)method));
    }
}

void test_configure_defaults_are_accepted_with_every_memory_and_fal(void)
{
    params.method = DRIVE_METHOD_FAL_FORC;
    for (uint16_t memory = 0U; memory < 3U; memory++) {
        for (uint16_t fal_at = 0U; fal_at < 2U; fal_at++) {
            for (uint16_t order = 1U; order <= 3U; order++) {
                params.rc_memory = memory;
                params.rc_fal_at = fal_at;
                params.rc_order = order;
                assert_accepted(at("memory %u fal %u order %u", (unsigned)memory, (unsigned)fal_at, (unsigned)order));
            }
        }
    }
}

void test_configure_parameter_out_of_its_range_is_refused_by_name(void)
{
    params.speed_divider = 0U;
    assert_refused(PARAM_speed_divider);
}

void test_configure_parameter_that_is_not_a_number_is_refused_by_name(void)
{
    params.current_kp_v_per_a = NAN;
    assert_refused(PARAM_current_kp_v_per_a);
}

void test_configure_voltage_window_without_room_is_refused(void)
{
    params.under_voltage_v = 40.0f;
    params.over_voltage_v = 40.0f;
    assert_refused(PARAM_under_voltage_v);
    params.under_voltage_v = 39.9f;
    assert_accepted("a window of 0.1 V");
}

void test_configure_q_current_beyond_the_over_current_limit_is_refused(void)
{
    params.iq_limit_a = 20.5f;
    assert_refused(PARAM_iq_limit_a);
    params.iq_limit_a = 20.0f;
    assert_accepted("both 20 A");
}

void test_configure_q_current_limit_of_zero_is_refused(void)
{
    params.iq_limit_a = 0.0f;
    assert_refused(PARAM_iq_limit_a);
}

void test_configure_tracking_filter_faster_than_its_samples_is_refused(void)
{
    params.pll_kp_per_s = 10001.0f; /* k_p T_s may be 1 */
    assert_refused(PARAM_pll_kp_per_s);
    params.pll_kp_per_s = 9999.0f;
    assert_accepted("k_p T_s = 0.9999");
    params.pll_kp_per_s = 0.0f;
    assert_refused(PARAM_pll_kp_per_s);
}

void test_configure_tracking_filter_without_integral_part_is_refused(void)
{
    params.pll_ki_per_s2 = 0.0f;
    assert_refused(PARAM_pll_ki_per_s2);
}

void test_configure_repetitive_parameters_are_judged_only_when_it_is_used(void)
{
    params.rc_limit_unit = 0.0f;
    assert_accepted("pi does not look at it");
    params.method = DRIVE_METHOD_CRC;
    assert_refused(PARAM_rc_limit_unit);
}

void test_configure_filter_that_amplifies_is_refused(void)
{
    params.method = DRIVE_METHOD_FORC;
    params.rc_q_side = 0.46f; /* 0.1 + 2 0.46 > 1 */
    assert_refused(PARAM_rc_q_centre);
}

void test_configure_angle_memory_without_lead_is_refused(void)
{
    params.method = DRIVE_METHOD_FORC;
    params.rc_memory = 2U;
    params.rc_lead = 1U;
    assert_refused(PARAM_rc_lead);
    params.rc_lead = 2U;
    assert_accepted("lead 2");
}

void test_configure_angle_memory_smaller_than_the_lead_needs_is_refused(void)
{
    params.method = DRIVE_METHOD_FORC;
    params.rc_memory = 2U;
    params.rc_lead = 15U;
    params.rc_order = 3U;
    params.rc_cells = 22U; /* lead + order + 5 = 23 */
    assert_refused(PARAM_rc_cells);
    params.rc_cells = 23U;
    assert_accepted("23 cells");
}

void test_configure_largest_lead_fits_the_memory_over_time(void)
{
    params.method = DRIVE_METHOD_FORC;
    params.rc_lead = 15U;
    params.rc_order = 3U;
    assert_accepted("lead 15, order 3");
}

void test_configure_refusal_leaves_the_bridge_off(void)
{
    params.pole_pairs = 0U;
    drive_init(&drive, &params);

    TEST_ASSERT_TRUE(bench.disarms >= 1U);
    TEST_ASSERT_EQUAL_UINT32(0U, bench.arms);
}

void test_configure_fixed_point_refuses_gains_beyond_its_range_and_names_them(void)
{
    FIXED_ONLY();
    /* bases 10 A, 20 V, 162.5 rad/s, 650 units: per unit k_p 128 is 256 V/A */
    params.current_kp_v_per_a = 257.0f;
    assert_refused(PARAM_current_kp_v_per_a);
    params.current_kp_v_per_a = 255.0f;
    assert_accepted("127.5 per unit");

    params_default(&params);
    params.speed_kp_a_per_unit = 2.0f; /* times 65 units per A: 130 */
    assert_refused(PARAM_speed_kp_a_per_unit);
    params.speed_kp_a_per_unit = 1.9f;
    assert_accepted("123.5 per unit");
}

/* 2 pi / (p T_s base) = 251 samples per unit of speed: cut to 128 the controller would learn the wrong period */
void test_configure_fixed_point_refuses_a_period_that_it_cannot_hold(void)
{
    FIXED_ONLY();
    params.pole_pairs = 1U;
    params.over_speed_rad_s = 100.0f;
    assert_accepted("pi needs no period");
    params.method = DRIVE_METHOD_FORC;
    assert_refused(PARAM_over_speed_rad_s);
    params.over_speed_rad_s = 197.0f; /* 127.6 */
    assert_accepted("over_speed 197 rad/s");
}

/* Per unit of 10 A, 20 V and 162.5 rad/s; a number of 128 or more would be cut, and be another one than what was asked for. Each is
 * refused from there on by its own name, and only for who uses it. */
void test_configure_fixed_point_refuses_a_number_of_a_block_that_it_cannot_hold(void)
{
    FIXED_ONLY();
    const struct {
        uint16_t param;
        float    fits, beyond;
        uint16_t user, choice; /* the parameter that chooses the block */
    } row[] = {
        /* R: 128 * 20 V / 10 A */
        {PARAM_motor_resistance_ohm, 255.0f, 257.0f, PARAM_current_controller, 1U},
        /* L / T_s, 10 kHz: 0.0256 H */
        {PARAM_motor_lq_h, 0.0255f, 0.0257f, PARAM_current_controller, 1U},
        {PARAM_motor_ld_h, 0.0255f, 0.0257f, PARAM_current_controller, 1U},
        /* J 162.5 rad/s / (T_s k_T 10 A 16), k_T = 1.5 * 4 * 6.4 mWb: 4.84e-4 kg m^2 */
        {PARAM_observer_inertia_kgm2, 4.8e-4f, 4.88e-4f, PARAM_method, 4U},
        /* J 162.5 rad/s / (k_T 10 A): 0.302 kg m^2; and the same of the viscous friction */
        {PARAM_rdc_inertia_kgm2, 0.30f, 0.305f, PARAM_position_method, 3U},
        {PARAM_rdc_viscous_nms, 0.30f, 0.305f, PARAM_position_method, 3U},
    };
    for (size_t k = 0; k < COUNT_OF(row); k++) {
        setUp();
        (void)params_set(&params, row[k].user, (float)row[k].choice);
        (void)params_set(&params, row[k].param, row[k].fits);
        assert_accepted(params_info(row[k].param)->name);
        (void)params_set(&params, row[k].param, row[k].beyond);
        assert_refused(row[k].param);
        (void)params_set(&params, row[k].user, 0.0f);
        assert_accepted(params_info(row[k].param)->name);
    }
}

void test_configure_float_takes_the_same_gains_and_period(void)
{
    FLOAT_ONLY();
    params.current_kp_v_per_a = 257.0f;
    params.speed_kp_a_per_unit = 2.0f;
    params.pole_pairs = 1U;
    params.over_speed_rad_s = 100.0f;
    params.method = DRIVE_METHOD_FORC;
    assert_accepted("float has no such bounds");
}

/* ---- what arrives --------------------------------------------------------------------------------------------------- */

/* Expected per unit of: half the over-current, half the over-voltage, a quarter of the over-speed (and that times the
 * gain of the error). In the float build these are 1. */
static double per(double value, double fixed_base) { return value / per_numeric(1.0, fixed_base); }

/* fixed point: one step and the rounding of the float arithmetic before it */
#define ARRIVES(expected, actual)                                                                                                \
    TEST_ASSERT_DOUBLE_WITHIN(fabs(expected) * 4.0 * FLOAT_EPS + per_numeric(0.0, FIXED_STEP), (expected), value_of(actual))

static const double AMP = 10.0, VOLT = 20.0, SPEED = 162.5, UNIT = 650.0;

void test_configure_scale_is_si_in_float_and_per_unit_of_the_limits_in_fixed_point(void)
{
    assert_accepted("defaults");

    TEST_ASSERT_EQUAL_FLOAT((float)per_numeric(1.0, 10.0), drive.scale.current_a);
    TEST_ASSERT_EQUAL_FLOAT((float)per_numeric(1.0, 20.0), drive.scale.voltage_v);
    TEST_ASSERT_EQUAL_FLOAT((float)per_numeric(1.0, 162.5), drive.scale.speed_rad_s);
    TEST_ASSERT_EQUAL_FLOAT((float)per_numeric(1.0, 650.0), drive.scale.error_unit);
    TEST_ASSERT_EQUAL_FLOAT(1.0f / drive.scale.current_a, drive.scale.inv_current);
    TEST_ASSERT_EQUAL_FLOAT(1.0f / drive.scale.voltage_v, drive.scale.inv_voltage);
    TEST_ASSERT_EQUAL_FLOAT(1.0f / drive.scale.speed_rad_s, drive.scale.inv_speed);
}

void test_configure_current_gains_arrive_with_the_sample_time(void)
{
    assert_accepted("defaults");

    ARRIVES(per(0.6, VOLT / AMP), drive.setup->current.pi.kp);
    ARRIVES(per(0.108, VOLT / AMP), drive.setup->current.pi.ki_ts);
    ARRIVES(per(1.5e-4 * 4.0 / TWO_PI, 1.0 / SPEED), drive.setup->current.advance);
    TEST_ASSERT_TRUE(drive.setup->current.voltage_limit == NUM_MAX); /* none of its own: the dc link limits */
}

void test_configure_speed_gains_arrive_with_the_speed_sample_time_and_the_unit_of_the_error(void)
{
    assert_accepted("defaults");

    ARRIVES(per(0.0368, AMP / UNIT), drive.setup->speed.pi.kp);
    ARRIVES(per(0.92e-3, AMP / UNIT), drive.setup->speed.pi.ki_ts);
    ARRIVES(per(10.0, AMP), drive.setup->speed.pi.out_max);
    ARRIVES(per(-10.0, AMP), drive.setup->speed.pi.out_min);
    ARRIVES(per_numeric(4.0, 1.0), drive.setup->speed.error_scale);
    TEST_ASSERT_EQUAL_INT(CTL_PI_HOLD_OUTWARD, drive.setup->speed.pi.anti_windup);
    TEST_ASSERT_EQUAL_INT(CTL_PI_HOLD, drive.setup->current.pi.anti_windup);
}

void test_configure_tracking_filter_and_edge_timer_arrive_with_their_times(void)
{
    assert_accepted("defaults");

    ARRIVES(0.0754, drive.setup->tracking.pll.kp_ts);
    ARRIVES(per(14.2122, SPEED), drive.setup->tracking.pll.ki_ts);
    ARRIVES(per(1e-4, 1.0 / SPEED), drive.setup->tracking.pll.rad_per_speed_ts);
    ARRIVES(per(975.0, SPEED), drive.setup->tracking.pll.speed_max);
    ARRIVES(per(TWO_PI / 4.0, SPEED), drive.setup->speed.mt.speed_1_count); /* one of 4000 counts in 1 ms */
    TEST_ASSERT_EQUAL_UINT32(200000U, drive.setup->speed.mt.sample_cyc);
    TEST_ASSERT_EQUAL_UINT32(BENCH_PERIOD_CYC, drive.setup->period_cyc);
}

void test_configure_repetitive_controller_arrives_in_units_of_the_error(void)
{
    params.method = DRIVE_METHOD_FORC;
    assert_accepted("forc");

    ARRIVES(0.6, drive.setup->speed.rc.gain);
    ARRIVES(0.45, drive.setup->speed.rc.q.side);
    ARRIVES(0.10, drive.setup->speed.rc.q.centre);
    ARRIVES(per(1000.0, UNIT), drive.setup->speed.rc.limit);
    ARRIVES(per(TWO_PI / 4e-3, SPEED), drive.setup->speed.rc_period_scale);
    TEST_ASSERT_EQUAL_UINT16(2U, drive.setup->speed.rc.order);
    TEST_ASSERT_EQUAL_UINT16(5U, drive.setup->speed.rc.lead);
    TEST_ASSERT_EQUAL_INT(CTL_RC_FAL_NONE, drive.setup->speed.rc.fal_at);
    TEST_ASSERT_TRUE(drive.setup->speed.rc_used);
}

void test_configure_crc_has_no_interpolation_and_no_fal(void)
{
    params.method = DRIVE_METHOD_CRC;
    assert_accepted("crc");

    TEST_ASSERT_EQUAL_UINT16(0U, drive.setup->speed.rc.order);
    TEST_ASSERT_TRUE(drive.setup->speed.rc.truncate);
    TEST_ASSERT_EQUAL_INT(CTL_RC_FAL_NONE, drive.setup->speed.rc.fal_at);
}

/* fal(u x) = u^alpha fal'(x) with its knee at delta / u: at the input of the memory the gain takes u^(alpha - 1) along */
void test_configure_fal_at_the_input_keeps_its_size_in_every_unit(void)
{
    params.method = DRIVE_METHOD_FAL_FORC;
    assert_accepted("fal-forc");

    const double gain = 0.6 * per_numeric(1.0, pow(UNIT, -0.4));
    TEST_ASSERT_DOUBLE_WITHIN(1e-5 * gain, gain,
                              value_of(drive.setup->speed.rc.gain)); /* log2 and exp2 of the fixed build: 1e-6 */
    ARRIVES(0.6, drive.setup->speed.rc.fal.alpha);
    ARRIVES(per(0.4, UNIT), drive.setup->speed.rc.fal.delta);
    TEST_ASSERT_EQUAL_INT(CTL_RC_FAL_INPUT, drive.setup->speed.rc.fal_at);
}

/* lambda(u x) = u^(alpha - 1) lambda'(x), too; it multiplies what the gain and the limit have made */
void test_configure_fal_at_the_output_keeps_its_size_in_every_unit(void)
{
    params.method = DRIVE_METHOD_FAL_FORC;
    params.rc_fal_at = 1U;
    assert_accepted("fal-forc, output");

    const double gain = 0.6 * per_numeric(1.0, pow(UNIT, -0.4));
    const double limit = 1000.0 * per_numeric(1.0, pow(UNIT, -0.4) / UNIT);
    TEST_ASSERT_DOUBLE_WITHIN(1e-5 * gain, gain, value_of(drive.setup->speed.rc.gain));
    TEST_ASSERT_DOUBLE_WITHIN(1e-5 * limit, limit, value_of(drive.setup->speed.rc.limit));
    TEST_ASSERT_EQUAL_INT(CTL_RC_FAL_OUTPUT, drive.setup->speed.rc.fal_at);
}

void test_configure_voltage_limit_and_switches_arrive(void)
{
    params.voltage_limit_v = 12.0f;
    params.speed_inline = 1U;
    params.encoder_reversed = 1U;
    params.pole_pairs = 7U;
    params.speed_divider = 20U;
    params.encoder_offset_rad = (float)(PI_OF_CIRCLE / 2.0);
    assert_accepted("switches");

    ARRIVES(per(12.0, VOLT), drive.setup->current.voltage_limit);
    TEST_ASSERT_TRUE(drive.setup->speed.inlined);
    TEST_ASSERT_TRUE(drive.setup->tracking.encoder_reversed);
    TEST_ASSERT_EQUAL_UINT16(7U, drive.setup->tracking.pole_pairs);
    TEST_ASSERT_EQUAL_UINT16(20U, drive.setup->speed.between + 1U);
    TEST_ASSERT_EQUAL_UINT32(400000U, drive.setup->speed.mt.sample_cyc);
    /* a quarter turn; 2^-24 of a turn is what the float of the angle holds */
    TEST_ASSERT_UINT32_WITHIN(256U, 0x40000000U, drive.setup->tracking.encoder_offset);
}
