/* firmware/app/braking.c: what the dc link leaves of the torque that brakes. */
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

static double shaft_rad;

static double iq_ref(void) { return (double)telemetry_read(&drive, SIGNAL_iq_ref_a); }

/* At a voltage that stands; the last of the periods are after a speed sample. */
static double turns_at(double speed_rad_s, double volt, uint32_t periods)
{
    bench.sample.vdc_v = (float)volt;
    for (uint32_t k = 0U; k < periods; k++) {
        shaft_rad += speed_rad_s * 1e-4;
        bench_angle(shaft_rad);
        bench_period();
    }
    return iq_ref();
}

/* No braking at 32 V, all of it at 28 V; the speed loop asks for 10 A, its limit, against any speed that is used here. */
static drive_params_t braking(void)
{
    drive_params_t p = bench_params();
    p.regeneration_limit_v = 32.0f;
    p.regeneration_band_v = 4.0f;
    p.speed_source = DRIVE_SPEED_PLL;
    p.speed_kp_a_per_unit = 1.0f;
    p.speed_ki_a_per_unit_s = 0.0f;
    return p;
}

static void spin(const drive_params_t *p, double speed_rad_s)
{
    bench_start();
    bench_run_with(p);
    bench_spin(speed_rad_s, 0.0);
    shaft_rad = 0.0;
    bench_command(DRIVE_MODE_SPEED, 0.0, 0.0, 0.0);
}

void test_braking_comes_down_on_a_line_below_the_limit_in_both_directions(void)
{
    const drive_params_t p = braking();
    for (double way = -1.0; way <= 1.0; way += 2.0) {
        spin(&p, 300.0 * way);
        TEST_ASSERT_DOUBLE_WITHIN(1e-4, -10.0 * way, turns_at(300.0 * way, 24.0, 40U));
        TEST_ASSERT_DOUBLE_WITHIN(1e-4, -10.0 * way, turns_at(300.0 * way, 28.0, 40U));
        TEST_ASSERT_DOUBLE_WITHIN(1e-3, -7.5 * way, turns_at(300.0 * way, 29.0, 40U));
        TEST_ASSERT_DOUBLE_WITHIN(1e-3, -2.5 * way, turns_at(300.0 * way, 31.0, 40U));
        TEST_ASSERT_DOUBLE_WITHIN(1e-3, 0.0, turns_at(300.0 * way, 32.0, 40U));
        TEST_ASSERT_DOUBLE_WITHIN(1e-3, 0.0, turns_at(300.0 * way, 39.0, 40U));
        ASSERT_NO_FAULT("limited");
        bench_command(DRIVE_MODE_SPEED, 600.0 * way, 0.0, 0.0); /* what drives is not limited */
        TEST_ASSERT_DOUBLE_WITHIN(1e-4, 10.0 * way, turns_at(300.0 * way, 39.0, 40U));
    }
}

/* A rise by 1 V in the last sample is 2 V more when the torque acts: at 28 V as at 30 V, and a fall counts as none. */
void test_braking_looks_ahead_while_the_voltage_rises(void)
{
    const drive_params_t p = braking();
    spin(&p, 300.0);
    (void)turns_at(300.0, 27.0, 40U);
    double   least = -10.0;
    uint32_t fewer = 0U;
    for (int k = 0; k < 30; k++) {
        const double now = turns_at(300.0, 28.0, 1U);
        least = fmax(least, now);
        fewer += (now > -9.0) ? 1U : 0U;
    }
    TEST_ASSERT_DOUBLE_WITHIN(1e-3, -5.0, least);
    TEST_ASSERT_EQUAL_UINT32_MESSAGE(10U, fewer, "for one speed sample");
    (void)turns_at(300.0, 31.0, 40U);
    double most = 0.0;
    for (int k = 0; k < 30; k++) {
        most = fmin(most, turns_at(300.0, 30.0, 1U));
    }
    TEST_ASSERT_DOUBLE_WITHIN(1e-3, -5.0, most);
}

/* p psi / R = 0.0711 A per rad/s, with a margin of a quarter 0.0889: 10 A are heat in the winding below 112.5 rad/s. */
void test_braking_that_the_winding_turns_into_heat_is_not_limited(void)
{
    const drive_params_t p = braking();
    spin(&p, 110.0);
    TEST_ASSERT_DOUBLE_WITHIN(1e-4, -10.0, turns_at(110.0, 35.0, 40U));
    spin(&p, 115.0);
    TEST_ASSERT_DOUBLE_WITHIN(1e-3, 0.0, turns_at(115.0, 35.0, 40U));

    drive_params_t unknown = braking();
    unknown.motor_resistance_ohm = 0.0f;
    spin(&unknown, 110.0);
    TEST_ASSERT_DOUBLE_WITHIN(1e-3, 0.0, turns_at(110.0, 35.0, 40U));
}

void test_braking_is_not_limited_by_default(void)
{
    drive_params_t p = braking();
    p.regeneration_limit_v = 0.0f;
    spin(&p, 300.0);
    TEST_ASSERT_DOUBLE_WITHIN(1e-4, -10.0, turns_at(300.0, 39.0, 40U));
}

void test_braking_is_limited_in_torque_and_position_mode_and_not_in_current_mode(void)
{
    drive_params_t p = braking();
    p.following_error_rad = 100.0f;
    spin(&p, 300.0);
    bench_command(DRIVE_MODE_TORQUE, 600.0, 0.0, -10.0);
    TEST_ASSERT_DOUBLE_WITHIN(1e-3, -5.0, turns_at(300.0, 30.0, 40U));
    bench_command(DRIVE_MODE_POSITION, 0.0, 0.0, 0.0);
    TEST_ASSERT_DOUBLE_WITHIN(1e-3, -5.0, turns_at(300.0, 30.0, 40U));
    bench_command(DRIVE_MODE_CURRENT, 0.0, 0.0, -10.0);
    TEST_ASSERT_DOUBLE_WITHIN(1e-3, -10.0, turns_at(300.0, 30.0, 40U));
    ASSERT_NO_FAULT("all modes");
}

/* What an observer adds is taken off by the current interrupt: the sum is limited. */
void test_braking_counts_what_the_observer_adds(void)
{
    const drive_params_t p = braking();
    spin(&p, 300.0);
    drive.observer.estimate = num_from_float(3.0f * drive.scale.inv_current); /* nobody else writes it without an observer */
    TEST_ASSERT_DOUBLE_WITHIN(1e-3, -5.0, turns_at(300.0, 30.0, 40U));
    drive.observer.estimate = num_from_float(-3.0f * drive.scale.inv_current);
    TEST_ASSERT_DOUBLE_WITHIN(1e-3, -5.0, turns_at(300.0, 30.0, 40U));
    bench_command(DRIVE_MODE_TORQUE, 600.0, 0.0, -6.0);
    TEST_ASSERT_DOUBLE_WITHIN(1e-3, -3.0, turns_at(300.0, 30.0, 40U)); /* less than is left */
    drive.observer.estimate = num_from_float(3.0f * drive.scale.inv_current);
    bench_command(DRIVE_MODE_TORQUE, 600.0, 0.0, -4.0);
    TEST_ASSERT_DOUBLE_WITHIN(1e-3, -5.0, turns_at(300.0, 30.0, 40U)); /* not 7 A */
}

/* 0.2 s of an error of -300 would bring the integral part to -10 A, which it then keeps without an error. */
void test_braking_that_is_limited_does_not_wind_up_the_controller(void)
{
    drive_params_t p = braking();
    p.speed_ki_a_per_unit_s = 1.0f;
    spin(&p, 300.0);
    TEST_ASSERT_DOUBLE_WITHIN(1e-3, 0.0, turns_at(300.0, 35.0, 2000U));
    bench_command(DRIVE_MODE_SPEED, 300.0, 0.0, 0.0);
    TEST_ASSERT_DOUBLE_WITHIN(0.5, 0.0, turns_at(300.0, 24.0, 20U));
}

void test_braking_no_number_of_the_dc_link_brakes(void)
{
    const drive_params_t p = braking();
    spin(&p, 300.0);
    drive.sample.vdc_v = (float)NAN;
    TEST_ASSERT_EQUAL_FLOAT(0.0f, num_to_float(drive_limit_braking(&drive, num_from_float(-5.0f * drive.scale.inv_current))));
}

static uint16_t refused(float limit, float band)
{
    drive_params_t p = bench_params();
    p.regeneration_limit_v = limit;
    p.regeneration_band_v = band;
    drive_init(&drive, &p);
    return (drive.fault == FAULT_configuration) ? drive.fault_detail : (uint16_t)PARAM_COUNT;
}

void test_braking_limit_lies_between_its_band_and_the_trip(void)
{
    TEST_ASSERT_EQUAL_UINT16(PARAM_COUNT, refused(40.0f, 4.0f));
    TEST_ASSERT_EQUAL_UINT16(PARAM_regeneration_limit_v, refused(40.5f, 4.0f));
    TEST_ASSERT_EQUAL_UINT16(PARAM_regeneration_limit_v, refused(3.0f, 4.0f));
    TEST_ASSERT_EQUAL_UINT16(PARAM_COUNT, refused(0.0f, 4.0f));
}

/* ---- chopper -------------------------------------------------------------------------------------------------------- */

static double heat(void) { return (double)telemetry_read(&drive, SIGNAL_chopper_heat); }

/* From 30 V on, full on at 32 V; 10 ohm. */
static drive_params_t chopping(void)
{
    drive_params_t p = bench_params();
    p.chopper_v = 30.0f;
    p.chopper_band_v = 2.0f;
    return p;
}

static float duty_at(double volt)
{
    bench.sample.vdc_v = (float)volt;
    bench_live(20U);
    return bench.brake_duty;
}

void test_chopper_is_on_in_proportion_to_the_voltage_above_its_threshold_in_every_state(void)
{
    const drive_params_t p = chopping();
    bench_run_with(&p);
    TEST_ASSERT_EQUAL_FLOAT(0.0f, duty_at(24.0));
    TEST_ASSERT_EQUAL_FLOAT(0.0f, duty_at(30.0));
    TEST_ASSERT_FLOAT_WITHIN(1e-5f, 0.25f, duty_at(30.5));
    TEST_ASSERT_FLOAT_WITHIN(1e-5f, 0.75f, duty_at(31.5));
    TEST_ASSERT_EQUAL_FLOAT(1.0f, duty_at(32.1));
    TEST_ASSERT_EQUAL_FLOAT(1.0f, duty_at(35.0));
    drive_stop(&drive);
    bench_live(20U);
    TEST_ASSERT_EQUAL_INT(DRIVE_READY, drive.state);
    TEST_ASSERT_FLOAT_WITHIN(1e-5f, 0.25f, duty_at(30.5));
    TEST_ASSERT_EQUAL_FLOAT(1.0f, duty_at(45.0)); /* over-voltage */
    TEST_ASSERT_EQUAL_INT(DRIVE_FAULT, drive.state);
    drive.sample.vdc_v = (float)NAN;
    drive_chop(&drive);
    TEST_ASSERT_EQUAL_FLOAT(0.0f, bench.brake_duty);
}

void test_chopper_is_not_driven_by_default(void)
{
    const drive_params_t p = bench_params();
    bench_run_with(&p);
    (void)duty_at(39.0);
    TEST_ASSERT_EQUAL_UINT32(0U, bench.brakes);
}

/* Half on at 31 V: 48.05 W of 40 W, 1 s: heat 1.2 (1 - exp(-t)), which is 1 after 1.785 s. Then it is off until 0.9, for 0.105 s. */
void test_chopper_rests_when_its_resistor_is_too_hot_until_a_tenth_has_cooled(void)
{
    drive_params_t p = chopping();
    p.chopper_continuous_w = 40.0f;
    p.chopper_thermal_s = 1.0f;
    p.regeneration_limit_v = 39.0f; /* so that the drive goes on */
    bench_run_with(&p);
    const double load = 0.5 * 31.0 * 31.0 / 10.0 / 40.0;
    const double hot_s = -log(1.0 - 1.0 / load);
    (void)duty_at(31.0);
    bench_live(9980U);
    TEST_ASSERT_DOUBLE_WITHIN(3e-3, load * (1.0 - exp(-1.0)), heat());
    bench_live((uint32_t)(1e4 * hot_s) - 10000U - 40U);
    TEST_ASSERT_FLOAT_WITHIN(1e-5f, 0.5f, bench.brake_duty);
    bench_live(80U);
    TEST_ASSERT_EQUAL_FLOAT(0.0f, bench.brake_duty);
    ASSERT_NO_FAULT("the braking would come down");
    bench_live((uint32_t)(1e4 * log(1.0 / 0.9)) - 100U);
    TEST_ASSERT_EQUAL_FLOAT(0.0f, bench.brake_duty);
    bench_live(120U);
    TEST_ASSERT_FLOAT_WITHIN(1e-5f, 0.5f, bench.brake_duty);
}

void test_chopper_that_must_rest_trips_a_drive_whose_braking_is_not_limited(void)
{
    drive_params_t p = chopping();
    p.chopper_continuous_w = 40.0f;
    p.chopper_thermal_s = 0.1f;
    bench_run_with(&p);
    (void)duty_at(31.0);
    bench_live(1765U); /* hot after 0.1785 s, cool again 10.5 ms later */
    ASSERT_FAULT(FAULT_brake_overload, "48 W of 40 W");
    TEST_ASSERT_EQUAL_FLOAT(0.0f, bench.brake_duty);
    bench.sample.vdc_v = 24.0f;
    bench_live(20U);
    drive_clear_fault(&drive);
    bench_live(10U);
    drive_start(&drive);
    bench_live(20U);
    ASSERT_NO_FAULT("below its threshold nothing is missing");
    drive_stop(&drive);
    bench_live(10U);
    bench.sample.vdc_v = 31.0f; /* another drive on the same dc link */
    bench_live(3000U);
    ASSERT_NO_FAULT("this one does not brake");
}

static uint16_t chopper_refused(float begin, float regeneration, float watt)
{
    drive_params_t p = chopping();
    p.chopper_v = begin;
    p.regeneration_limit_v = regeneration;
    p.chopper_continuous_w = watt;
    drive_init(&drive, &p);
    return (drive.fault == FAULT_configuration) ? drive.fault_detail : (uint16_t)PARAM_COUNT;
}

/* Full on at 40 V, the trip; with a limit of the braking at 38 V, which begins at 34 V, there. 40^2 / 10 ohm / 64 = 2.5 W. */
void test_chopper_is_full_on_before_the_trip_and_before_the_braking_is_limited(void)
{
    TEST_ASSERT_EQUAL_UINT16(PARAM_COUNT, chopper_refused(38.0f, 0.0f, 0.0f));
    TEST_ASSERT_EQUAL_UINT16(PARAM_chopper_v, chopper_refused(38.5f, 0.0f, 0.0f));
    TEST_ASSERT_EQUAL_UINT16(PARAM_COUNT, chopper_refused(32.0f, 38.0f, 0.0f));
    TEST_ASSERT_EQUAL_UINT16(PARAM_chopper_v, chopper_refused(32.5f, 38.0f, 0.0f));
    TEST_ASSERT_EQUAL_UINT16(PARAM_chopper_continuous_w, chopper_refused(30.0f, 0.0f, 2.4f));
    TEST_ASSERT_EQUAL_UINT16(PARAM_COUNT, chopper_refused(30.0f, 0.0f, 2.6f));
    bench.limits.has_chopper = false;
    TEST_ASSERT_EQUAL_UINT16(PARAM_chopper_v, chopper_refused(30.0f, 0.0f, 0.0f));
    TEST_ASSERT_EQUAL_UINT16(PARAM_COUNT, chopper_refused(0.0f, 0.0f, 0.0f));
}
