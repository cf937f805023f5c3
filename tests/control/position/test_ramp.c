/* control/position/ramp.c: limits are kept, the target is met exactly and not passed, in the time of a trapezoid or an S curve. */
#include <stdlib.h>

#include "control/position/ramp.h"
#include "tests/support/numeric.h"

void setUp(void) {}
void tearDown(void) {}

/* Samples until the target is reached and left no more, every limit asserted on the way. */
static int travel(int64_t rate, int64_t change, int64_t from, int64_t to)
{
    const ctl_ramp_params_t p = {rate, change};
    ctl_ramp_state_t        s;
    ctl_ramp_reset(&s, from);
    int k = 0;
    while (((s.at != to) || (s.step != 0)) && (k < 100000)) {
        const int64_t before = s.at;
        const int64_t last = s.step;
        const int64_t now = ctl_ramp_step_unchecked(&p, &s, to);
        k++;
        TEST_ASSERT_EQUAL_INT64(now, s.at);
        TEST_ASSERT_EQUAL_INT64(s.step, now - before);
        TEST_ASSERT_TRUE_MESSAGE(llabs(s.step) <= rate, at("step %lld", (long long)s.step));
        TEST_ASSERT_TRUE_MESSAGE((change == 0) || (llabs(s.step - last) <= change), at("change at sample %d", k));
        TEST_ASSERT_TRUE_MESSAGE((to > from) ? ((now >= before) && (now <= to)) : ((now <= before) && (now >= to)),
                                 at("beyond the target, or back, at sample %d", k));
    }
    TEST_ASSERT_EQUAL_INT64(to, s.at);
    return k;
}

/* distance / rate, the last step the rest; one sample more in which it stands */
void test_ramp_with_no_limit_of_the_change_is_a_straight_line(void)
{
    TEST_ASSERT_EQUAL_INT(101, travel(1000, 0, 0, 100000));
    TEST_ASSERT_EQUAL_INT(102, travel(1000, 0, 0, 100001));
    TEST_ASSERT_EQUAL_INT(101, travel(1000, 0, 50000, -50000));
    TEST_ASSERT_EQUAL_INT(2, travel(1000, 0, 7, 6));
}

/* S curve that reaches its rate: distance / rate + rate / change, for a rate that is a multiple of the change exactly: steps
 * change, 2 change, ... rate, ..., rate, ... change take rate / change - 1 samples more than distance / rate. */
void test_ramp_s_curve_takes_distance_over_rate_and_rate_over_change(void)
{
    for (int sign = -1; sign <= 1; sign += 2) {
        TEST_ASSERT_EQUAL_INT(100 + 50 - 1 + 1, travel(1000, 20, 0, sign * 100000));
    }
}

/* Too short to reach its rate: n steps up and n - 1 down cover n^2 change. */
void test_ramp_short_s_curve_takes_twice_the_root_of_distance_over_change(void)
{
    TEST_ASSERT_EQUAL_INT(2 * 30 - 1 + 1, travel(1000, 20, 0, 30 * 30 * 20));
}

void test_ramp_meets_any_target_from_any_rate_limits_kept(void)
{
    uint32_t noise = 1U;
    for (int round = 0; round < 300; round++) {
        noise = (noise * 1664525U) + 1013904223U;
        const int64_t rate = 1 + (int64_t)(noise >> 8) % 100000;
        noise = (noise * 1664525U) + 1013904223U;
        const int64_t change = 1 + (int64_t)(noise >> 8) % rate;
        noise = (noise * 1664525U) + 1013904223U;
        const int64_t to = (int32_t)noise / 64;
        const double  ideal = fabs((double)to) / (double)rate + (double)rate / (double)change;
        const double  shortest = 2.0 * sqrt(fabs((double)to) / (double)change);
        const double  expected = (fabs((double)to) * (double)change > (double)rate * (double)rate) ? ideal : shortest;
        if (expected < 90000.0) {
            /* whole samples at each of three corners, and the last one that stands */
            ASSERT_DOUBLE_WITHIN_AT(4.0, expected, travel(rate, change, 0, to), at("round %d", round));
        }
    }
}

/* A target that moves: never faster than the limits, and back from a target that is now behind without a jump of the rate. */
void test_ramp_turns_back_through_rate_zero_when_the_target_is_behind(void)
{
    const ctl_ramp_params_t p = {1000, 20};
    ctl_ramp_state_t        s;
    ctl_ramp_reset(&s, 0);
    for (int k = 0; k < 60; k++) {
        (void)ctl_ramp_step_unchecked(&p, &s, 1000000);
    }
    TEST_ASSERT_EQUAL_INT64(1000, s.step);
    const int64_t turned_at = s.at;
    int64_t       furthest = 0;
    for (int k = 0; k < 400; k++) {
        const int64_t last = s.step;
        (void)ctl_ramp_step_unchecked(&p, &s, 0);
        TEST_ASSERT_TRUE(llabs(s.step - last) <= 20);
        furthest = (s.at > furthest) ? s.at : furthest;
    }
    TEST_ASSERT_EQUAL_INT64(turned_at + 20 * 49 * 50 / 2, furthest); /* 980 + 960 + ... + 20 */
    TEST_ASSERT_EQUAL_INT64(0, s.at);
    TEST_ASSERT_EQUAL_INT64(0, s.step);
}

void test_ramp_takes_any_state_and_target(void)
{
    const ctl_ramp_params_t p = {CTL_RAMP_STEP_MAX, 1};
    ctl_ramp_state_t        s;
    const int64_t           ends[] = {INT64_MAX, INT64_MIN, 0, -1};
    for (size_t a = 0; a < 4U; a++) {
        for (size_t b = 0; b < 4U; b++) {
            ctl_ramp_reset(&s, ends[a]);
            for (int k = 0; k < 10; k++) {
                (void)ctl_ramp_step_unchecked(&p, &s, ends[b]);
                TEST_ASSERT_TRUE(llabs(s.step) <= 10);
            }
        }
    }
}
