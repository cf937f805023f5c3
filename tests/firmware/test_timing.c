/* How long the interrupts take: figures, histogram, restart, and the clock of an interrupt that is preempted. */
#include "firmware/app/timing.h"

#include <string.h>

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

/* As the current interrupt notes itself. @return whether it took too long. */
static bool current_took(timing_t *t, uint32_t cyc, uint32_t period_cyc)
{
    if (timing_is_nominal(t, cyc)) {
        timing_note_nominal(&t->current, cyc);
        return false;
    }
    return timing_note_abnormal(t, cyc, period_cyc);
}

static timing_t plain; /* the same runs, each looked at from all sides */

static void both_took(uint32_t cyc, uint32_t period_cyc)
{
    const bool too_long = current_took(&timing, cyc, period_cyc);
    timing_note(&plain.current, timing.epoch, cyc);
    TEST_ASSERT_EQUAL(cyc > period_cyc, too_long);
    TEST_ASSERT_EQUAL_MEMORY(&plain.current, &timing.current, sizeof plain.current);
}

/* Lengths of all kinds, beyond the period among them, and a restart now and then. */
void test_timing_of_nominal_runs_has_the_figures_and_the_overruns_of_all_runs(void)
{
    uint32_t seed = 5U;
    uint32_t nominal = 0U;
    (void)memset(&plain, 0, sizeof plain);
    for (uint32_t k = 0U; k < 20000U; k++) {
        seed = (seed * 1664525U) + 1013904223U;
        const uint32_t kind = (seed >> 8) % 100U;
        const uint32_t cyc = 700U + ((seed >> 16) % 300U);
        if (kind == 0U) {
            timing_restart(&timing);
        }
        nominal += timing_is_nominal(&timing, cyc) ? 1U : 0U;
        both_took((kind == 1U) ? (cyc + 20000U) : ((kind == 2U) ? UINT32_MAX : ((kind == 3U) ? 0U : cyc)), 20000U);
    }
    TEST_ASSERT_TRUE(nominal > 15000U);
}

void test_timing_takes_no_run_for_nominal_before_the_first_and_after_a_restart(void)
{
    const timing_t nothing = {0};
    TEST_ASSERT_FALSE(timing_is_nominal(&nothing, 0U));
    (void)current_took(&timing, 800U, 20000U);
    (void)current_took(&timing, 900U, 20000U);
    TEST_ASSERT_TRUE(timing_is_nominal(&timing, 800U));
    TEST_ASSERT_TRUE(timing_is_nominal(&timing, 900U));
    TEST_ASSERT_FALSE(timing_is_nominal(&timing, 799U));
    TEST_ASSERT_FALSE(timing_is_nominal(&timing, 901U));

    timing_restart(&timing);

    TEST_ASSERT_FALSE(timing_is_nominal(&timing, 850U));
}

void test_timing_of_a_period_is_nominal_and_a_cycle_more_never(void)
{
    TEST_ASSERT_TRUE(current_took(&timing, 20001U, 20000U));
    TEST_ASSERT_FALSE(timing_is_nominal(&timing, 20000U)); /* none was so short */
    TEST_ASSERT_FALSE(current_took(&timing, 20000U, 20000U));
    TEST_ASSERT_TRUE(timing_is_nominal(&timing, 20000U));
    TEST_ASSERT_FALSE(timing_is_nominal(&timing, 20001U));
    TEST_ASSERT_TRUE(current_took(&timing, 20001U, 20000U)); /* each of them */
}

/* Any bit of the two words that say what is nominal: behind a pass of the main loop nothing beyond the period is. */
void test_timing_check_leaves_no_damaged_word_behind_which_an_overrun_is_nominal(void)
{
    for (uint32_t bit = 0U; bit < 64U; bit++) {
        timing_restart(&timing);
        (void)current_took(&timing, 800U, 20000U);
        (void)current_took(&timing, 19000U, 20000U);
        timing_check(&timing, 20000U);
        TEST_ASSERT_TRUE(timing_is_nominal(&timing, 19000U)); /* a whole one stays */

        if (bit < 32U) {
            timing.span_cyc ^= UINT32_C(1) << bit;
        } else {
            timing.least_cyc ^= UINT32_C(1) << (bit - 32U);
        }
        timing_check(&timing, 20000U);

        TEST_ASSERT_FALSE(timing_is_nominal(&timing, 20001U));
        TEST_ASSERT_FALSE(timing_is_nominal(&timing, 40000U));
        TEST_ASSERT_FALSE(timing_is_nominal(&timing, UINT32_MAX));
    }
}

/* The main loop is interrupted between its two stores: whichever the interrupt sees, the next one begins, or has begun, the new epoch. */
void test_timing_restart_is_seen_when_an_interrupt_comes_within_it(void)
{
    for (uint32_t abnormal = 0U; abnormal < 2U; abnormal++) {
        const timing_t nothing = {0};
        timing = nothing;
        timing_restart(&timing);
        (void)current_took(&timing, 800U, 20000U);
        (void)current_took(&timing, 900U, 20000U);

        timing.epoch++; /* first store */
        (void)current_took(&timing, (abnormal != 0U) ? 1000U : 850U, 20000U);
        timing.span_cyc = 0U; /* second store */
        (void)current_took(&timing, 870U, 20000U);

        TEST_ASSERT_EQUAL_UINT16(timing.epoch, timing.current.epoch);
        TEST_ASSERT_EQUAL_UINT32(870U, timing.current.min_cyc);
        TEST_ASSERT_EQUAL_UINT32((abnormal != 0U) ? 1000U : 870U, timing.current.max_cyc);
    }
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
