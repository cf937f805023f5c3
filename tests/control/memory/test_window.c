/* control/memory/window.h: the newest samples in a row, wherever the head is. */
#include "tests/support/numeric.h"

#include "control/memory/window.h"

static ctl_window_t window;

void setUp(void) { ctl_window_fill(&window, num_of(7.0)); }
void tearDown(void) {}

void test_ctl_window_filled_shows_that_value_everywhere(void)
{
    for (int i = -(int)CTL_WINDOW_MARGIN; i < (int)CTL_WINDOW_SIZE; i++) {
        ASSERT_NUM_WITHIN_AT(0.0, 7.0, ctl_window_newest(&window)[i], at("place %d", i));
    }
}

void test_ctl_window_shows_the_newest_samples_in_a_row_over_many_rounds(void)
{
    for (int k = 0; k < 100; k++) {
        const num_t *const newest = ctl_window_push(&window, num_of(k));

        TEST_ASSERT_TRUE(newest == ctl_window_newest(&window));
        for (int i = 0; i < (int)CTL_WINDOW_SIZE; i++) {
            ASSERT_NUM_WITHIN_AT(0.0, (k >= i) ? (double)(k - i) : 7.0, newest[i], at("sample %d, %d before it", k, i));
        }
    }
}

void test_ctl_window_before_the_newest_there_is_something_finite(void)
{
    for (int k = 0; k < 40; k++) {
        const num_t *const newest = ctl_window_push(&window, num_of(k));
        for (int i = 1; i <= (int)CTL_WINDOW_MARGIN; i++) {
            ASSERT_BOUNDED_AT(100.0, newest[-i], at("sample %d, %d after it", k, i));
        }
    }
}

void test_ctl_long_window_shows_the_newest_32_samples_in_a_row_over_many_rounds(void)
{
    static ctl_long_window_t twice_as_long;
    ctl_long_window_fill(&twice_as_long, num_of(7.0));
    for (int k = 0; k < 120; k++) {
        const num_t *const newest = ctl_long_window_push(&twice_as_long, num_of(k));

        TEST_ASSERT_TRUE(newest == ctl_long_window_newest(&twice_as_long));
        for (int i = 0; i < (int)CTL_LONG_WINDOW_SIZE; i++) {
            ASSERT_NUM_WITHIN_AT(0.0, (k >= i) ? (double)(k - i) : 7.0, newest[i], at("sample %d, %d before it", k, i));
        }
        for (int i = 1; i <= (int)CTL_LONG_WINDOW_MARGIN; i++) {
            ASSERT_BOUNDED_AT(120.0, newest[-i], at("sample %d, %d after it", k, i));
        }
    }
}
