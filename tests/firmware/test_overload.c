/* firmware/app/thermal.c: what the heat does to limits and bridge. */
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

static double motor_heat(void) { return (double)telemetry_read(&drive, SIGNAL_motor_heat); }
static double bridge_heat(void) { return (double)telemetry_read(&drive, SIGNAL_bridge_heat); }
static double iq_ref(void) { return (double)telemetry_read(&drive, SIGNAL_iq_ref_a); }

static drive_params_t overloaded(float motor_a, float bridge_a)
{
    drive_params_t p = bench_params();
    p.motor_continuous_a = motor_a;
    p.motor_thermal_s = 1.0f;
    p.bridge_continuous_a = bridge_a;
    p.bridge_thermal_s = 1.0f;
    return p;
}

/* a vector of 10 A flows whatever the drive does: twice the continuous current. Heat 4 (1 - exp(-t)) */
void test_overload_limit_comes_down_from_nine_tenths_on_and_the_bridge_goes_off_at_eleven(void)
{
    const drive_params_t p = overloaded(5.0f, 0.0f);
    bench_run_with(&p);
    bench_command(DRIVE_MODE_CURRENT, 0.0, 0.0, 10.0);
    bench_currents(0.0, 10.0, 0.0);
    bench_live(2000U);
    TEST_ASSERT_DOUBLE_WITHIN(5e-3, 4.0 * (1.0 - exp(-0.2)), motor_heat());
    TEST_ASSERT_DOUBLE_WITHIN(1e-4, 10.0, iq_ref());
    const double derates_s = -log(1.0 - 0.9 / 4.0); /* 0.255 s */
    bench_live((uint32_t)(1e4 * derates_s) - 2000U - 20U);
    TEST_ASSERT_DOUBLE_WITHIN(1e-4, 10.0, iq_ref());
    bench_live(220U); /* 20 ms later: 0.9 + 0.02 3.1 = 0.962, which allows a load of 1 + 0.38 3 = 2.14 */
    TEST_ASSERT_DOUBLE_WITHIN(0.35, 5.0 * sqrt(2.14), iq_ref());
    ASSERT_NO_FAULT("derated");
    const double trips_s = -log(1.0 - 1.1 / 4.0); /* 0.3216 s */
    bench_live((uint32_t)(1e4 * trips_s) - (uint32_t)(1e4 * derates_s) - 220U);
    ASSERT_NO_FAULT("just before it trips");
    TEST_ASSERT_DOUBLE_WITHIN(0.2, 0.0, iq_ref());
    bench_live(50U);
    ASSERT_FAULT(FAULT_motor_overload, "a current that does not come down");
}

/* A fault that is cleared leaves the heat; the next start is allowed as much as it has cooled. */
void test_overload_heat_outlives_fault_clear_and_start(void)
{
    const drive_params_t p = overloaded(5.0f, 0.0f);
    bench_run_with(&p);
    bench_currents(0.0, 10.0, 0.0);
    bench_live(5000U);
    ASSERT_FAULT(FAULT_motor_overload, "first");
    const double hot = motor_heat();
    bench_currents(0.0, 0.0, 0.0);
    drive_clear_fault(&drive);
    drive_start(&drive);
    bench_live(50U);
    TEST_ASSERT_TRUE(hot > 1.09);
    TEST_ASSERT_DOUBLE_WITHIN(0.02, hot, motor_heat());
    bench_live(10000U);
    TEST_ASSERT_DOUBLE_WITHIN(0.02, hot * exp(-1.0), motor_heat()); /* it cools in fault, at rest and without current */
}

/* Standing on one phase a leg has twice the heat of the mean: the square of the amplitude; turning it has the mean. */
void test_overload_leg_of_a_standing_motor_has_twice_the_heat(void)
{
    drive_params_t p = overloaded(0.0f, 10.0f);
    bench_run_with(&p);
    bench_command(DRIVE_MODE_CURRENT, 0.0, 0.0, 5.0);
    bench_currents(5.0, 0.0, 0.0); /* all on phase a */
    bench_live(5000U);
    TEST_ASSERT_DOUBLE_WITHIN(5e-3, 2.0 * 0.25 * (1.0 - exp(-0.5)), bridge_heat());
    TEST_ASSERT_DOUBLE_WITHIN(1e-6, 0.0, motor_heat());
}

void test_overload_off_is_no_heat_and_no_limit(void)
{
    const drive_params_t p = overloaded(0.0f, 0.0f);
    bench_run_with(&p);
    bench_command(DRIVE_MODE_CURRENT, 0.0, 0.0, 10.0);
    bench_currents(0.0, 15.0, 0.0);
    bench_live(30000U);
    TEST_ASSERT_DOUBLE_WITHIN(0.0, 0.0, motor_heat());
    TEST_ASSERT_DOUBLE_WITHIN(1e-4, 10.0, iq_ref());
}

void test_overload_current_that_no_sample_may_have_is_refused(void)
{
    drive_params_t p = overloaded(20.1f, 0.0f);
    drive_init(&drive, &p);
    TEST_ASSERT_EQUAL_UINT16(PARAM_motor_continuous_a, drive.fault_detail);
    p = overloaded(5.0f, 21.0f);
    drive_init(&drive, &p);
    TEST_ASSERT_EQUAL_UINT16(PARAM_bridge_continuous_a, drive.fault_detail);
}
