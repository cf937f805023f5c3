/* How long the interrupts take: figures, histogram, restart, and the clock of an interrupt that is preempted. */
#include "firmware/app/timing.h"
#include "mock_hal_clock.h"
#include "unity.h"

static timing_t timing;
static uint32_t clock_cyc;
static uint32_t preempting_cyc; /* a current interrupt of this length falls on the next reading of the clock */

static uint32_t read_clock(int calls)
{
    (void)calls;
    clock_cyc += 10U + preempting_cyc;
    timing.used_cyc += preempting_cyc;
    preempting_cyc = 0U;
    return clock_cyc;
}

void setUp(void)
{
    const timing_t nothing = {0};
    timing = nothing;
    clock_cyc = 0U;
    preempting_cyc = 0U;
    timing_restart(&timing);
    hal_clock_cyc_Stub(read_clock);
}
void tearDown(void) {}

static void runs(uint32_t first_cyc, uint32_t second_cyc, uint32_t third_cyc)
{
    timing_note(&timing.current, timing.epoch, first_cyc);
    timing_note(&timing.current, timing.epoch, second_cyc);
    timing_note(&timing.current, timing.epoch, third_cyc);
}

void test_timing_remembers_the_last_the_shortest_and_the_longest_run(void)
{
    runs(900U, 1200U, 1000U);

    TEST_ASSERT_EQUAL_UINT32(1000U, timing.current.last_cyc);
    TEST_ASSERT_EQUAL_UINT32(900U, timing.current.min_cyc);
    TEST_ASSERT_EQUAL_UINT32(1200U, timing.current.max_cyc);
}

void test_timing_counts_runs_in_bins_of_512_cycles(void)
{
    runs(511U, 512U, 1023U);

    TEST_ASSERT_EQUAL_UINT32(1U, timing_bin(&timing.current, 0U));
    TEST_ASSERT_EQUAL_UINT32(2U, timing_bin(&timing.current, 1U));
    TEST_ASSERT_EQUAL_UINT32(0U, timing_bin(&timing.current, 2U));
}

void test_timing_last_bin_takes_everything_longer(void)
{
    runs(8191U, 8192U, UINT32_MAX);

    TEST_ASSERT_EQUAL_UINT32(1U, timing_bin(&timing.current, 15U));
    TEST_ASSERT_EQUAL_UINT32(2U, timing_bin(&timing.current, 16U));
    TEST_ASSERT_EQUAL_UINT32(0U, timing_bin(&timing.current, 17U));
    TEST_ASSERT_EQUAL_UINT32(0U, timing_bin(&timing.current, UINT16_MAX));
}

void test_timing_restart_forgets_what_was_before_it(void)
{
    runs(100U, 9000U, 700U);

    timing_restart(&timing);
    timing_note(&timing.current, timing.epoch, 600U);

    TEST_ASSERT_EQUAL_UINT32(600U, timing.current.min_cyc);
    TEST_ASSERT_EQUAL_UINT32(600U, timing.current.max_cyc);
    TEST_ASSERT_EQUAL_UINT32(1U, timing_bin(&timing.current, 1U));
    TEST_ASSERT_EQUAL_UINT32(0U, timing_bin(&timing.current, 0U));
    TEST_ASSERT_EQUAL_UINT32(0U, timing_bin(&timing.current, 16U));
}

/* 65536 restarts lead back to the same number; 0 belongs to figures that nobody has begun. */
void test_timing_restart_never_asks_for_the_figures_that_nobody_has_begun(void)
{
    for (uint32_t k = 0U; k < 70000U; k++) {
        timing_restart(&timing);
        TEST_ASSERT_TRUE(timing.epoch != 0U);
    }
}

void test_timing_own_clock_stands_still_during_current_interrupts(void)
{
    const uint32_t started = timing_own_clock(&timing);
    clock_cyc += 3000U; /* work */
    clock_cyc += 2500U; /* a current interrupt */
    timing.used_cyc += 2500U;

    TEST_ASSERT_EQUAL_UINT32(3010U, timing_own_clock(&timing) - started); /* 10: the reading of the clock itself */
}

void test_timing_own_clock_is_right_when_it_is_preempted_while_it_is_read(void)
{
    preempting_cyc = 2500U;
    const uint32_t started = timing_own_clock(&timing);
    clock_cyc += 3000U;
    preempting_cyc = 2600U;

    TEST_ASSERT_UINT32_WITHIN(20U, 3020U, timing_own_clock(&timing) - started); /* one or two readings */
}

void test_timing_own_clock_is_right_when_clock_and_sum_wrap(void)
{
    clock_cyc = UINT32_MAX - 100U;
    timing.used_cyc = UINT32_MAX - 5U;
    const uint32_t started = timing_own_clock(&timing);
    clock_cyc += 700U;
    timing.used_cyc += 200U;

    TEST_ASSERT_EQUAL_UINT32(510U, timing_own_clock(&timing) - started);
}
