/* control/position/motion.h: turns and angle in one number, followed and subtracted. */
#include "tests/support/numeric.h"

#include "control/position/motion.h"

#define HALF_TURN (CTL_ONE_TURN / 2)

static double difference(ctl_position_t a, ctl_position_t b) { return value_of(ctl_position_difference(a, b)); }

void setUp(void) {}
void tearDown(void) {}

void test_ctl_position_follow_of_the_same_angle_stays(void)
{
    const ctl_position_t where[] = {0, 1, -1, 5 * CTL_ONE_TURN + 77, -5 * CTL_ONE_TURN - 77, HALF_TURN, -HALF_TURN};
    for (size_t k = 0; k < COUNT_OF(where); k++) {
        TEST_ASSERT_EQUAL_INT64(where[k], ctl_position_follow(where[k], (angle_t)(uint64_t)where[k]));
    }
}

/* a walk of steps below half a turn, kept in 64 bits by the test, seen only as an angle by the block */
static void assert_follows(int64_t bias, int64_t range)
{
    noise_t        noise = {101U};
    ctl_position_t truth = 0;
    ctl_position_t got = 0;
    for (int k = 0; k < 20000; k++) {
        truth += bias + (int64_t)(noise_next(&noise) * (double)range);
        got = ctl_position_follow(got, (angle_t)(uint64_t)truth);
        TEST_ASSERT_EQUAL_INT64_MESSAGE(truth, got, at("step %d", k));
    }
}

void test_ctl_position_follow_counts_turns_forwards_and_backwards(void)
{
    assert_follows(1000000000, 100000);
    assert_follows(-1000000000, 100000);
    assert_follows(0, 2 * HALF_TURN - 2);
    assert_follows(7, 3);
}

void test_ctl_position_follow_takes_the_shorter_way(void)
{
    TEST_ASSERT_EQUAL_INT64(HALF_TURN - 1, ctl_position_follow(0, 0x7FFFFFFFU));
    TEST_ASSERT_EQUAL_INT64(-HALF_TURN, ctl_position_follow(0, 0x80000000U));
    TEST_ASSERT_EQUAL_INT64(-1, ctl_position_follow(0, 0xFFFFFFFFU));
    TEST_ASSERT_EQUAL_INT64(-3 * CTL_ONE_TURN - 5, ctl_position_follow(-3 * CTL_ONE_TURN + 5, (angle_t)-5));
}

void test_ctl_position_wraps_at_the_end_of_its_turns(void)
{
    TEST_ASSERT_EQUAL_INT64(INT64_MIN + 9, ctl_position_follow(INT64_MAX, 9U));
    TEST_ASSERT_EQUAL_INT64(INT64_MAX - 9, ctl_position_follow(INT64_MIN, (angle_t)-10));
    TEST_ASSERT_EQUAL_INT64(INT64_MIN, ctl_position_add(INT64_MAX, 1));
    TEST_ASSERT_EQUAL_INT64(INT64_MAX, ctl_position_sub(INT64_MIN, 1));
    TEST_ASSERT_EQUAL_INT64(7, ctl_position_sub(ctl_position_add(INT64_MAX, 7), INT64_MAX));
}

void test_ctl_position_difference_of_equal_positions_is_zero(void)
{
    const ctl_position_t where[] = {0, INT64_MAX, INT64_MIN, 123456789, -987654321};
    for (size_t k = 0; k < COUNT_OF(where); k++) {
        TEST_ASSERT_EQUAL_DOUBLE(0.0, difference(where[k], where[k]));
    }
}

void test_ctl_position_difference_is_the_way_in_rad_wherever_it_lies(void)
{
    const ctl_position_t base[] = {0, 77, -3 * CTL_ONE_TURN + 5, 100000 * CTL_ONE_TURN, -2000000000 * CTL_ONE_TURN};
    const double         turns[] = {0.0, 1e-6, 0.25, 0.5, 1.0, 3.75, 18.999};
    for (size_t b = 0; b < COUNT_OF(base); b++) {
        for (size_t k = 0; k < COUNT_OF(turns); k++) {
            const ctl_position_t way = (ctl_position_t)(turns[k] * TURN_STEPS);
            const double         rad = TWO_PI / TURN_STEPS * (double)way;
            /* fixed point: half a step, and 2 pi 2^24 as a whole number errs by 7e-10 of itself */
            const double tolerance = per_numeric(1.5 * FLOAT_EPS * rad, 0.5 * FIXED_STEP + 1e-9 * rad);

            ASSERT_DOUBLE_WITHIN_AT(tolerance, rad, difference(base[b] + way, base[b]), at("%g turns", turns[k]));
            ASSERT_DOUBLE_WITHIN_AT(tolerance, -rad, difference(base[b], base[b] + way), at("-%g turns", turns[k]));
        }
    }
}

/* no jump at whole turns: the step of 2^-20 turn is the same everywhere */
void test_ctl_position_difference_has_no_seam_at_a_turn(void)
{
    for (int64_t k = -40; k <= 40; k++) {
        const ctl_position_t x = 2 * CTL_ONE_TURN + k * 4096;
        TEST_ASSERT_DOUBLE_WITHIN(per_numeric(13.0 * FLOAT_EPS, 0.7 * FIXED_STEP), TWO_PI * (2.0 + (double)k / 1048576.0),
                                  difference(x, 0));
    }
}

void test_ctl_float_of_long_is_the_nearest_float(void)
{
    uint64_t seed = 1U;
    for (uint32_t k = 0U; k < 4100U; k++) {
        seed = (seed * UINT64_C(6364136223846793005)) + UINT64_C(1442695040888963407);
        const unsigned bits = k % 41U;
        int64_t        x = (int64_t)((seed >> 20) & ((UINT64_C(1) << bits) - 1U));
        x += (k % 3U) == 0U ? (INT64_C(1) << bits) - x - 1 - (int64_t)((seed >> 17) & 3U) : 0; /* ends and halves */
        x = ((k & 64U) != 0U) ? -x : x;
        const volatile float want = (float)x; /* the compiler's own conversion */
        const volatile float got = ctl_float_of_long(x);
        if (want != got) {
            TEST_FAIL_MESSAGE(at("%ld * 65536 + %u", (long)(x >> 16), (unsigned)(x & 0xFFFF)));
        }
    }
    TEST_ASSERT_EQUAL_FLOAT(1099511627776.0f, ctl_float_of_long(INT64_C(1) << 40));
    TEST_ASSERT_EQUAL_FLOAT(-1099511627776.0f, ctl_float_of_long(-(INT64_C(1) << 40)));
}

void test_ctl_position_difference_is_cut_at_nineteen_turns(void)
{
    const double limit = 19.0 * TWO_PI;
    const double tolerance = per_numeric(limit * FLOAT_EPS, 3e-7);

    TEST_ASSERT_DOUBLE_WITHIN(tolerance, limit, difference(19 * CTL_ONE_TURN, 0));
    TEST_ASSERT_DOUBLE_WITHIN(tolerance, limit, difference(25 * CTL_ONE_TURN, 0));
    TEST_ASSERT_DOUBLE_WITHIN(tolerance, -limit, difference(-25 * CTL_ONE_TURN, 0));
    TEST_ASSERT_DOUBLE_WITHIN(tolerance, limit, difference(INT64_MAX, 0));
    TEST_ASSERT_DOUBLE_WITHIN(tolerance, -limit, difference(INT64_MIN, 0));
    TEST_ASSERT_DOUBLE_WITHIN(tolerance, -limit, difference(-20 * CTL_ONE_TURN, 20 * CTL_ONE_TURN));
    TEST_ASSERT_TRUE(limit < num_max_value());
}
