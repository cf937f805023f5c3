/* What may switch the bridge on: a client that has armed and started, or auto_run out of the storage; nothing else. */
#include "firmware/app/telemetry.h"
#include "firmware/services/internal.h"
#include "mock_hal_clock.h"
#include "mock_hal_encoder.h"
#include "mock_hal_inverter.h"
#include "mock_hal_link.h"
#include "mock_hal_sample.h"
#include "mock_hal_storage.h"
#include "tests/firmware/support/bench.h"
#include "tests/firmware/support/flash.h"
#include "tests/firmware/support/line.h"

#define TEN_SECONDS 100000U

void setUp(void) { line_start(); }
void tearDown(void) {}

static void with_alignment(void)
{
    line_defaults.align_periods = BENCH_ALIGN_PERIODS;
    line_defaults.offset_calibration_periods = 100U;
    line_restart();
}

static void store_auto_run(void)
{
    line_hello(services.schema);
    line_set(PARAM_auto_run, 1.0f);
    line_run(2U);
    line_command(LINK_CMD_save);
    bench.arms = 0U;
}

static void assert_stays_off(const char *after)
{
    const uint32_t arms = bench.arms;
    line_run(TEN_SECONDS);
    TEST_ASSERT_FALSE_MESSAGE(bench.armed, after);
    TEST_ASSERT_EQUAL_UINT32_MESSAGE(arms, bench.arms, after);
    TEST_ASSERT_EQUAL_INT_MESSAGE(DRIVE_READY, drive.state, after);
}

/* ---- without arm and start ----------------------------------------------------------------------------------------------- */

void test_permission_power_up_and_every_reset_leave_the_bridge_off(void)
{
    for (int cause = HAL_RESET_UNKNOWN; cause <= HAL_RESET_OTHER; cause++) {
        line_reset = (hal_reset_t)cause;
        with_alignment();
        assert_stays_off(at("cause %d", cause));
    }
}

void test_permission_clear_of_a_fault_by_a_client_that_may_not_even_write_starts_nothing(void)
{
    with_alignment();
    line_run(200U);
    bench.sample_status = HAL_SENSOR_FAULT;
    line_run(1U);
    bench.sample_status = HAL_OK;
    TEST_ASSERT_EQUAL_INT(FAULT_encoder_error, drive.fault);
    line_hello(0U);
    line_command(LINK_CMD_clear_fault);
    line_run(10U);
    assert_stays_off("clear_fault");
}

void test_permission_set_of_a_parameter_starts_nothing(void)
{
    const uint16_t param[] = {PARAM_pole_pairs, PARAM_encoder_reversed, PARAM_auto_run, PARAM_encoder_offset_rad};
    with_alignment();
    line_run(200U);
    line_hello(services.schema);
    for (size_t k = 0; k < COUNT_OF(param); k++) {
        line_set(param[k], 1.0f);
        line_run(10U);
        assert_stays_off(params_info(param[k])->name);
    }
}

void test_permission_auto_run_of_the_board_s_defaults_does_not_count(void)
{
    line_defaults.auto_run = 1U;
    line_restart();
    assert_stays_off("not stored");
}

void test_permission_auto_run_that_was_set_counts_from_the_next_power_up_on_only(void)
{
    store_auto_run();
    assert_stays_off("set and saved");
    line_restart();
    line_run(10U);
    TEST_ASSERT_EQUAL_INT(DRIVE_RUN, drive.state);
}

void test_permission_stored_auto_run_does_not_survive_a_watchdog_reset(void)
{
    store_auto_run();
    line_reset = HAL_RESET_WATCHDOG;
    line_restart();
    TEST_ASSERT_EQUAL_UINT16(1U, drive.params->auto_run);
    assert_stays_off("watchdog");
    line_reset = HAL_RESET_PIN;
    line_restart();
    line_run(10U);
    TEST_ASSERT_EQUAL_INT(DRIVE_RUN, drive.state);
}

/* ---- auto_run and the timeout --------------------------------------------------------------------------------------------- */

void test_permission_auto_run_without_a_client_ends_with_the_timeout(void)
{
    store_auto_run();
    line_restart();
    line_run(4980U);
    TEST_ASSERT_TRUE(bench.armed);
    line_run(30U);
    TEST_ASSERT_FALSE(bench.armed);
    assert_stays_off("timeout");
    TEST_ASSERT_TRUE(services.session.timed_out);
}

void test_permission_auto_run_goes_on_as_long_as_a_client_lives_and_its_timeout_cannot_be_switched_off(void)
{
    store_auto_run();
    line_restart();
    line_hello(services.schema);
    for (int k = 0; k < 10; k++) {
        line_run(4900U);
        (void)line_begin(LINK_alive);
        (void)line_ask();
        TEST_ASSERT_EQUAL_INT(DRIVE_RUN, drive.state);
    }
    codec_put_u16(line_begin(LINK_timeout), 0U);
    TEST_ASSERT_EQUAL_UINT16(LINK_NO_range, line_refusal(LINK_timeout));
    codec_put_u16(line_begin(LINK_timeout), 1000U);
    TEST_ASSERT_EQUAL_HEX16(LINK_timeout + LINK_ANSWER, line_ask());
    line_run(10010U);
    TEST_ASSERT_FALSE(bench.armed);
}

void test_permission_timeout_stops_an_alignment_too(void)
{
    store_auto_run();
    line_hello(services.schema);
    line_set(PARAM_align_periods, (float)BENCH_ALIGN_PERIODS);
    line_run(2U);
    line_command(LINK_CMD_save);
    line_restart();
    line_run(1500U);
    TEST_ASSERT_EQUAL_INT(DRIVE_ALIGN, drive.state);
    TEST_ASSERT_TRUE(bench.armed);
    line_run(3600U);
    TEST_ASSERT_FALSE(bench.armed);
    TEST_ASSERT_EQUAL_INT(DRIVE_READY, drive.state);
}

/* ---- what the client learns ----------------------------------------------------------------------------------------------- */

void test_permission_flags_tell_why_the_board_started_and_whether_the_zero_is_known(void)
{
    for (uint16_t cause = HAL_RESET_UNKNOWN; cause <= (uint16_t)HAL_RESET_OTHER; cause++) {
        line_reset = (hal_reset_t)cause;
        line_defaults.align_periods = 0U;
        line_restart();
        (void)line_begin(LINK_alive);
        TEST_ASSERT_EQUAL_HEX16(LINK_alive + LINK_ANSWER, line_ask());
        line.in.at = 7U;
        const uint16_t flags = codec_get_u16(&line.in);
        TEST_ASSERT_EQUAL_UINT16(cause, (uint16_t)(flags >> 9U));
        TEST_ASSERT_EQUAL_HEX16(2U, flags & 2U);
    }
    with_alignment();
    line_run(200U);
    (void)line_begin(LINK_alive);
    (void)line_ask();
    line.in.at = 7U;
    TEST_ASSERT_EQUAL_HEX16(0U, codec_get_u16(&line.in) & 2U);
}
