/* firmware/app/sto.c, and what a trip by the input for safe torque off does to starts. */
#include "firmware/app/internal.h"
#include "mock_hal_clock.h"
#include "mock_hal_encoder.h"
#include "mock_hal_inverter.h"
#include "mock_hal_limits.h"
#include "mock_hal_sample.h"
#include "tests/firmware/support/bench.h"

void setUp(void) { bench_start(); }
void tearDown(void) {}

static uint16_t shown(void) { return drive_fault_detail(&drive); }

static void clear(void)
{
    drive_clear_fault(&drive);
    bench_live(20U);
}

/* Of either channel: in the period in which it asks. */
void test_sto_of_either_channel_switches_off_and_a_new_start_needs_a_clear_and_a_start(void)
{
    for (uint16_t channels = 1U; channels <= HAL_STO_BOTH; channels++) {
        bench_start();
        const drive_params_t p = bench_params();
        bench_run_with(&p);
        bench.sto = channels;
        bench_period();
        ASSERT_FAULT(FAULT_safe_torque_off, at("channels %u", (unsigned)channels));
        bench_live(20U);
        TEST_ASSERT_EQUAL_UINT16(channels, shown());
        drive_start(&drive);
        bench_live(20U);
        clear();
        drive_start(&drive);
        bench_live(20U);
        ASSERT_FAULT(FAULT_safe_torque_off, "as long as it asks");
        TEST_ASSERT_EQUAL_UINT32(1U, bench.arms); /* only the first start */
        bench.sto = 0U;
        bench_live(20U);
        ASSERT_FAULT(FAULT_safe_torque_off, "closed is no command");
        clear();
        TEST_ASSERT_EQUAL_INT(DRIVE_READY, drive.state);
        TEST_ASSERT_FALSE(bench.armed);
        drive_start(&drive);
        bench_live(20U);
        TEST_ASSERT_EQUAL_INT(DRIVE_RUN, drive.state);
    }
}

/* 50 ms are 500 periods. */
void test_sto_channels_may_differ_for_the_time_that_contacts_need(void)
{
    const drive_params_t p = bench_params();
    bench_run_with(&p);
    bench.sto = 1U;
    bench_live(480U);
    bench.sto = HAL_STO_BOTH;
    bench_live(2000U);
    bench.sto = 2U;
    bench_live(480U);
    bench.sto = 0U;
    bench_live(20U);
    TEST_ASSERT_EQUAL_UINT16(0U, shown());
    clear();
    ASSERT_NO_FAULT("both have opened and closed");
}

static void leave_open(uint16_t channels, uint16_t stuck)
{
    bench_start();
    const drive_params_t p = bench_params();
    bench_run_with(&p);
    bench.sto = channels;
    bench_live(530U);
    TEST_ASSERT_EQUAL_UINT16(channels + (4U * stuck), shown());
    bench.sto = 0U;
    bench_live(20U);
    clear();
    ASSERT_FAULT(FAULT_sto_discrepancy, "it is known although the input is closed again");
    TEST_ASSERT_EQUAL_UINT16(stuck, drive_fault_detail(&drive));
    clear();
    ASSERT_FAULT(FAULT_sto_discrepancy, "and does not clear");
    bench.sto = HAL_STO_BOTH;
    bench_live(20U);
    bench.sto = 0U;
    bench_live(20U);
    clear();
    clear(); /* the hardware's own, if it came first */
    ASSERT_NO_FAULT("both have opened");
}

void test_sto_channel_that_does_not_open_is_a_fault_until_both_have_opened(void)
{
    leave_open(1U, 2U);
    leave_open(2U, 1U);
}

void test_sto_is_not_counted_as_a_start_after_a_trip(void)
{
    drive_params_t p = bench_params();
    p.restart_limit = 1U;
    bench_run_with(&p);
    for (int k = 0; k < 4; k++) {
        bench.sto = HAL_STO_BOTH;
        bench_live(20U);
        bench.sto = 0U;
        bench_live(20U);
        clear();
        drive_start(&drive);
        bench_live(20U);
        TEST_ASSERT_EQUAL_INT(DRIVE_RUN, drive.state);
    }
}

/* What is wrong with the input does not take the place of another fault's detail. */
void test_sto_discrepancy_leaves_another_fault_as_it_is(void)
{
    const drive_params_t p = bench_params();
    bench_run_with(&p);
    drive.sto.stuck = 1U;
    bench.inverter_fault = HAL_INVERTER_CLOCK;
    bench_period();
    bench_live(20U);
    ASSERT_FAULT(FAULT_processor_clock, "first");
    TEST_ASSERT_EQUAL_UINT16(0U, shown());
}
