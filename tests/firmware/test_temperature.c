/* firmware/app/thermal.c: what temperature sensors do to limits and bridge. */
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

#define PASSES 170U /* periods of 17 passes, after the two of warm() and the like */

static double iq_ref(void) { return (double)telemetry_read(&drive, SIGNAL_iq_ref_a); }

/* In current mode at 10 A, the default limit. */
static void run_with(float motor_derate, float motor_trip, float bridge_derate, float bridge_trip)
{
    drive_params_t p = bench_params();
    p.motor_derate_c = motor_derate;
    p.motor_trip_c = motor_trip;
    p.bridge_derate_c = bridge_derate;
    p.bridge_trip_c = bridge_trip;
    bench_start();
    bench_run_with(&p);
    bench_command(DRIVE_MODE_CURRENT, 0.0, 0.0, 10.0);
    bench_live(20U);
}

static void warm(double motor, double bridge)
{
    bench.celsius[HAL_TEMPERATURE_MOTOR] = (float)motor;
    bench.celsius[HAL_TEMPERATURE_BRIDGE] = (float)bridge;
    bench_live(20U);
}

/* A straight line from 10 A at 100 to nothing at 140 degrees, in steps of half a percent; the colder of the two decides nothing. */
void test_temperature_limit_comes_down_on_a_line_before_it_trips_and_comes_back(void)
{
    run_with(100.0f, 140.0f, 60.0f, 80.0f);
    warm(100.0, 60.0);
    TEST_ASSERT_DOUBLE_WITHIN(1e-4, 10.0, iq_ref());
    warm(110.0, 25.0);
    TEST_ASSERT_DOUBLE_WITHIN(0.05, 7.5, iq_ref());
    warm(110.0, 75.0);
    TEST_ASSERT_DOUBLE_WITHIN(0.05, 2.5, iq_ref());
    warm(139.0, 25.0);
    TEST_ASSERT_DOUBLE_WITHIN(0.05, 0.25, iq_ref());
    ASSERT_NO_FAULT("139 of 140");
    warm(25.0, 25.0);
    TEST_ASSERT_DOUBLE_WITHIN(1e-4, 10.0, iq_ref());
    warm(140.0, 25.0);
    bench_live(PASSES);
    ASSERT_FAULT(FAULT_motor_temperature, "motor");
    TEST_ASSERT_EQUAL_DOUBLE(140.0, (double)telemetry_read(&drive, SIGNAL_motor_temperature_c));

    run_with(100.0f, 140.0f, 60.0f, 80.0f);
    warm(25.0, 80.5);
    bench_live(PASSES);
    ASSERT_FAULT(FAULT_over_temperature, "bridge");
    TEST_ASSERT_EQUAL_DOUBLE(80.5, (double)telemetry_read(&drive, SIGNAL_bridge_temperature_c));
}

void test_temperature_without_a_derating_only_trips(void)
{
    run_with(0.0f, 140.0f, 0.0f, 0.0f);
    warm(139.9, 500.0);
    TEST_ASSERT_DOUBLE_WITHIN(1e-4, 10.0, iq_ref());
    ASSERT_NO_FAULT("what the bridge shows is not judged");
    warm((double)NAN, 25.0);
    bench_live(PASSES);
    ASSERT_FAULT(FAULT_motor_temperature, "not a number");
}

/* Both limit: the I2t of a motor that bears 5 A, of which 10 A are a load of 4, and the sensor. */
void test_temperature_and_overload_leave_the_smaller_current(void)
{
    drive_params_t p = bench_params();
    p.motor_continuous_a = 5.0f;
    p.motor_thermal_s = 1.0f;
    p.bridge_derate_c = 60.0f;
    p.bridge_trip_c = 80.0f;
    bench_run_with(&p);
    bench_command(DRIVE_MODE_CURRENT, 0.0, 0.0, 10.0);
    bench_currents(0.0, 10.0, 0.0);
    bench_live(2750U); /* heat 0.962: 7.3 A */
    warm(25.0, 65.0);
    const double by_heat = iq_ref();
    TEST_ASSERT_TRUE_MESSAGE((by_heat < 7.5) && (by_heat > 5.0), at("%g A", by_heat));
    warm(25.0, 76.0);
    TEST_ASSERT_DOUBLE_WITHIN(0.05, 2.0, iq_ref());
}

void test_temperature_sensor_that_is_lost_trips_a_running_drive_by_its_name(void)
{
    run_with(0.0f, 140.0f, 0.0f, 80.0f);
    bench.celsius_status[HAL_TEMPERATURE_BRIDGE] = HAL_SENSOR_FAULT;
    bench_live(20U);
    bench_live(PASSES);
    ASSERT_FAULT(FAULT_temperature_sensor, "bridge");
    TEST_ASSERT_EQUAL_UINT16(2U, drive_fault_detail(&drive));
    drive_clear_fault(&drive);
    bench_live(20U);
    ASSERT_NO_FAULT("at rest nothing is heated");
    bench.celsius_status[HAL_TEMPERATURE_BRIDGE] = HAL_OK;
    bench.celsius_status[HAL_TEMPERATURE_MOTOR] = HAL_SENSOR_FAULT;
    drive_start(&drive);
    bench_live(20U);
    bench_live(PASSES);
    ASSERT_FAULT(FAULT_temperature_sensor, "motor");
    TEST_ASSERT_EQUAL_UINT16(1U, drive_fault_detail(&drive));
}

void test_temperature_start_of_a_hot_motor_ends_at_once(void)
{
    run_with(0.0f, 140.0f, 0.0f, 0.0f);
    warm(150.0, 25.0);
    bench_live(PASSES);
    ASSERT_FAULT(FAULT_motor_temperature, "hot");
    drive_clear_fault(&drive);
    bench_live(20U);
    drive_start(&drive);
    bench_live(20U);
    bench_live(PASSES);
    ASSERT_FAULT(FAULT_motor_temperature, "still hot");
}

static uint16_t refused(float derate, float trip)
{
    drive_params_t p = bench_params();
    p.bridge_derate_c = derate;
    p.bridge_trip_c = trip;
    drive_init(&drive, &p);
    return (drive.fault == FAULT_configuration) ? drive.fault_detail : (uint16_t)PARAM_COUNT;
}

void test_temperature_thresholds_that_do_nothing_are_refused(void)
{
    TEST_ASSERT_EQUAL_UINT16(PARAM_COUNT, refused(79.0f, 80.0f));
    TEST_ASSERT_EQUAL_UINT16(PARAM_bridge_derate_c, refused(79.5f, 80.0f));
    TEST_ASSERT_EQUAL_UINT16(PARAM_bridge_derate_c, refused(60.0f, 0.0f));
    bench.celsius_status[HAL_TEMPERATURE_BRIDGE] = HAL_UNSUPPORTED;
    TEST_ASSERT_EQUAL_UINT16(PARAM_bridge_trip_c, refused(0.0f, 80.0f));
    TEST_ASSERT_EQUAL_UINT16(PARAM_COUNT, refused(0.0f, 0.0f));
    bench.celsius_status[HAL_TEMPERATURE_BRIDGE] = HAL_SENSOR_FAULT; /* a plug that is out is no board without a sensor */
    TEST_ASSERT_EQUAL_UINT16(PARAM_COUNT, refused(0.0f, 80.0f));
}

/* A single reading, and a limit that has changed in memory until that is found, switch nothing off. */
void test_temperature_trips_after_seventeen_passes_in_a_row(void)
{
    run_with(0.0f, 140.0f, 0.0f, 0.0f);
    for (int k = 0; k < 5; k++) {
        warm(150.0, 25.0);
        bench_live(130U);
        ASSERT_NO_FAULT("15 passes");
        warm(25.0, 25.0);
    }
    warm(150.0, 25.0);
    bench_live(150U);
    ASSERT_FAULT(FAULT_motor_temperature, "17 passes");
}
