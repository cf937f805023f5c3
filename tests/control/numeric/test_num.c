/* control/numeric/num.h: the arithmetic that every block is written on. */
#include "tests/support/numeric.h"

#include "control/numeric/diag.h"

void setUp(void) {}
void tearDown(void) {}

/* Pairs that are exact in both numerics, so that sums and products have one right answer. */
static const double OPERAND[] = {0.0, 1.0, -1.0, 0.5, -0.75, 3.25, -7.125, 0.0625, 11.0, -10.5};

void test_num_add_and_sub_are_exact_where_the_result_fits(void)
{
    for (size_t i = 0; i < COUNT_OF(OPERAND); i++) {
        for (size_t j = 0; j < COUNT_OF(OPERAND); j++) {
            const num_t a = num_of(OPERAND[i]);
            const num_t b = num_of(OPERAND[j]);

            ASSERT_NUM_WITHIN_AT(0.0, OPERAND[i] + OPERAND[j], num_add(a, b), at("%g + %g", OPERAND[i], OPERAND[j]));
            ASSERT_NUM_WITHIN_AT(0.0, OPERAND[i] - OPERAND[j], num_sub(a, b), at("%g - %g", OPERAND[i], OPERAND[j]));
        }
    }
}

void test_num_mul_and_mac_are_exact_where_the_result_fits(void)
{
    for (size_t i = 0; i < COUNT_OF(OPERAND); i++) {
        for (size_t j = 0; j < COUNT_OF(OPERAND); j++) {
            const num_t  a = num_of(OPERAND[i]);
            const num_t  b = num_of(OPERAND[j]);
            const double product = OPERAND[i] * OPERAND[j];

            ASSERT_NUM_WITHIN_AT(0.0, product, num_mul(a, b), at("%g * %g", OPERAND[i], OPERAND[j]));
            if (fabs(product - 2.5) < 127.0) {
                ASSERT_NUM_WITHIN_AT(0.0, product - 2.5, num_mac(num_of(-2.5), a, b), at("mac %g %g", OPERAND[i], OPERAND[j]));
            }
        }
    }
}

void test_num_mul_rounds_to_the_nearest_step(void)
{
    noise_t noise = {1U};
    for (uint32_t i = 0; i < 2000U; i++) {
        const num_t  a = num_of(20.0 * noise_next(&noise));
        const num_t  b = num_of(noise_next(&noise) / 3.0);
        const double want = value_of(a) * value_of(b);
        /* half a step of either numeric; a float's step is 2^-23 of the power of two below it */
        const double half_step = per_numeric(0.5 * FLOAT_EPS * fabs(want), 0.5 * FIXED_STEP);

        ASSERT_NUM_WITHIN_AT(half_step, want, num_mul(a, b), at("turn %u", i));
    }
}

void test_num_mac_rounds_once(void)
{
    noise_t noise = {2U};
    for (uint32_t i = 0; i < 2000U; i++) {
        const num_t  a = num_of(20.0 * noise_next(&noise));
        const num_t  b = num_of(noise_next(&noise) / 3.0);
        const num_t  c = num_of(noise_next(&noise));
        const double want = value_of(c) + (value_of(a) * value_of(b));
        /* fixed: half a step for the whole; float: product and sum each round */
        const double bound = per_numeric(FLOAT_EPS * (fabs(want) + fabs(value_of(c))), 0.5 * FIXED_STEP);

        ASSERT_NUM_WITHIN_AT(bound, want, num_mac(c, a, b), at("turn %u", i));
    }
}

void test_num_div_gives_the_quotient(void)
{
    noise_t noise = {3U};
    for (uint32_t i = 0; i < 2000U; i++) {
        const num_t a = num_of(20.0 * noise_next(&noise));
        num_t       b = num_of(noise_next(&noise));
        if (fabs(value_of(b)) < 0.2) {
            b = num_of(0.25);
        }
        const double want = value_of(a) / value_of(b);
        const double bound = per_numeric(0.5 * FLOAT_EPS * fabs(want), FIXED_STEP); /* fixed: cut, not rounded */

        ASSERT_NUM_WITHIN_AT(bound, want, num_div(a, b), at("turn %u", i));
    }
}

void test_num_div_by_zero_gives_the_limit_with_the_sign_of_the_dividend(void)
{
    TEST_ASSERT_TRUE(num_div(num_of(2.0), (num_t)0) == NUM_MAX);
    TEST_ASSERT_TRUE(num_div(num_of(-2.0), (num_t)0) == -NUM_MAX);
    TEST_ASSERT_TRUE(num_div((num_t)0, (num_t)0) == NUM_MAX);
}

void test_num_div_of_large_by_small_saturates(void)
{
    TEST_ASSERT_TRUE(num_div(NUM_MAX, NUM_EPS) == NUM_MAX);
    TEST_ASSERT_TRUE(num_div(-NUM_MAX, NUM_EPS) == -NUM_MAX);
    TEST_ASSERT_TRUE(num_div(NUM_MAX, -NUM_EPS) == -NUM_MAX);
}

void test_num_operations_on_extremes_stay_finite(void)
{
    const num_t  extreme[] = {NUM_MAX, -NUM_MAX, NUM_EPS, -NUM_EPS, (num_t)0, num_of(1.0), num_of(-1.0)};
    const double bound = per_numeric((double)FLT_MAX, num_max_value());
    for (size_t i = 0; i < COUNT_OF(extreme); i++) {
        for (size_t j = 0; j < COUNT_OF(extreme); j++) {
            const num_t       a = extreme[i];
            const num_t       b = extreme[j];
            const char *const text = at("operands %u and %u", (unsigned)i, (unsigned)j);

            ASSERT_BOUNDED_AT(bound, num_add(a, b), text);
            ASSERT_BOUNDED_AT(bound, num_sub(a, b), text);
            ASSERT_BOUNDED_AT(bound, num_mul(a, num_mul(a, b)), text); /* two products in a chain are promised */
            ASSERT_BOUNDED_AT(bound, num_mac(num_mul(a, b), a, b), text);
            ASSERT_BOUNDED_AT(num_max_value(), num_div(a, b), text);
        }
    }
}

void test_num_neg_and_abs_of_every_extreme_are_symmetric(void)
{
    const num_t extreme[] = {NUM_MAX, -NUM_MAX, NUM_EPS, (num_t)0, num_of(-3.5)};
    for (size_t i = 0; i < COUNT_OF(extreme); i++) {
        TEST_ASSERT_TRUE(num_neg(num_neg(extreme[i])) == extreme[i]);
        TEST_ASSERT_TRUE(num_abs(extreme[i]) >= (num_t)0);
        TEST_ASSERT_TRUE(num_abs(num_neg(extreme[i])) == num_abs(extreme[i]));
    }
}

void test_num_operations_in_fixed_point_saturate_instead_of_wrapping(void)
{
    FIXED_ONLY();
    const num_t lowest = (num_t)INT32_MIN;

    TEST_ASSERT_TRUE(num_add(NUM_MAX, NUM_EPS) == NUM_MAX);
    TEST_ASSERT_TRUE(num_add(-NUM_MAX, -NUM_EPS) == -NUM_MAX);
    TEST_ASSERT_TRUE(num_sub(-NUM_MAX, NUM_MAX) == -NUM_MAX);
    TEST_ASSERT_TRUE(num_sub(NUM_MAX, -NUM_EPS) == NUM_MAX);
    TEST_ASSERT_TRUE(num_mul(num_of(100.0), num_of(2.0)) == NUM_MAX);
    TEST_ASSERT_TRUE(num_mul(num_of(-100.0), num_of(2.0)) == -NUM_MAX);
    TEST_ASSERT_TRUE(num_mac(num_of(100.0), num_of(10.0), num_of(10.0)) == NUM_MAX);
    TEST_ASSERT_TRUE(num_mac(num_of(-100.0), num_of(10.0), num_of(-10.0)) == -NUM_MAX);
    TEST_ASSERT_TRUE(num_neg(lowest) == NUM_MAX);
    TEST_ASSERT_TRUE(num_abs(lowest) == NUM_MAX);
    TEST_ASSERT_TRUE(num_mul(lowest, lowest) == NUM_MAX);
    TEST_ASSERT_TRUE(num_from_int(128) == NUM_MAX);
    TEST_ASSERT_TRUE(num_from_int(-128) == -NUM_MAX);
}

void test_num_is_finite_knows_what_cannot_be_calculated_with(void)
{
    for (size_t i = 0; i < COUNT_OF(NOT_FINITE); i++) {
        TEST_ASSERT_FALSE_MESSAGE(num_is_finite(NOT_FINITE[i]), at("case %u", (unsigned)i));
    }
    TEST_ASSERT_TRUE(num_is_finite(NUM_MAX));
    TEST_ASSERT_TRUE(num_is_finite(-NUM_MAX));
    TEST_ASSERT_TRUE(num_is_finite((num_t)0));
    TEST_ASSERT_TRUE(num_is_finite(NUM_EPS));
}

void test_num_guard_replaces_and_counts_what_is_not_finite(void)
{
    uint32_t rejected = 0U;
    for (size_t i = 0; i < COUNT_OF(NOT_FINITE); i++) {
        const num_t got = num_guard(NOT_FINITE[i], num_of(-1.5), &rejected);

        ASSERT_NUM_WITHIN(0.0, -1.5, got);
        TEST_ASSERT_EQUAL_UINT32(i + 1U, rejected);
    }
}

void test_num_guard_passes_numbers_uncounted(void)
{
    uint32_t rejected = 7U;

    ASSERT_NUM_WITHIN(0.0, 2.5, num_guard(num_of(2.5), (num_t)0, &rejected));
    TEST_ASSERT_TRUE(num_guard(NUM_MAX, (num_t)0, &rejected) == NUM_MAX);
    TEST_ASSERT_EQUAL_UINT32(7U, rejected);
}

void test_num_count_stops_at_its_end(void)
{
    uint32_t counter = UINT32_MAX - 1U;

    num_count(&counter);
    TEST_ASSERT_EQUAL_UINT32(UINT32_MAX, counter);
    num_count(&counter);
    TEST_ASSERT_EQUAL_UINT32(UINT32_MAX, counter);
}

void test_num_min_max_and_clamp_choose(void)
{
    const num_t lo = num_of(-2.0);
    const num_t hi = num_of(3.0);

    ASSERT_NUM_WITHIN(0.0, -2.0, num_min(lo, hi));
    ASSERT_NUM_WITHIN(0.0, -2.0, num_min(hi, lo));
    ASSERT_NUM_WITHIN(0.0, 3.0, num_max(lo, hi));
    ASSERT_NUM_WITHIN(0.0, 3.0, num_max(hi, lo));
    ASSERT_NUM_WITHIN(0.0, -2.0, num_clamp(num_of(-2.5), lo, hi));
    ASSERT_NUM_WITHIN(0.0, 3.0, num_clamp(num_of(3.5), lo, hi));
    ASSERT_NUM_WITHIN(0.0, 0.5, num_clamp(num_of(0.5), lo, hi));
}

void test_num_from_float_takes_the_nearest_value(void)
{
    noise_t noise = {4U};
    for (uint32_t i = 0; i < 4000U; i++) {
        /* all sizes from 2^-24 to 100; just below 1 a float has exactly the steps of Q7.24 */
        const float  x = (float)(ldexp(1.0 + noise_next(&noise), -(int)(i % 26U)) * ((i % 2U != 0U) ? 60.0 : -60.0));
        const double half_step = per_numeric(0.0, 0.5 * FIXED_STEP);

        ASSERT_NUM_WITHIN_AT(half_step, (double)x, num_from_float(x), at("x = %.9g", (double)x));
    }
}

void test_num_from_float_of_the_largest_float_below_one_is_exact(void)
{
    ASSERT_NUM_WITHIN(0.0, 16777215.0 / 16777216.0, num_from_float(16777215.0f / 16777216.0f));
    ASSERT_NUM_WITHIN(0.0, -16777213.0 / 16777216.0, num_from_float(-16777213.0f / 16777216.0f));
}

void test_num_from_float_saturates_and_turns_nan_into_zero(void)
{
    ASSERT_NUM_WITHIN(0.0, -127.5, num_from_float(-127.5f));
    ASSERT_NUM_WITHIN(0.0, 127.5, num_from_float(127.5f));
    TEST_ASSERT_TRUE(num_from_float(1e30f) == NUM_MAX);
    TEST_ASSERT_TRUE(num_from_float(-1e30f) == -NUM_MAX);
    TEST_ASSERT_TRUE(num_from_float(INFINITY) == NUM_MAX);
    TEST_ASSERT_TRUE(num_from_float(-INFINITY) == -NUM_MAX);
    TEST_ASSERT_TRUE(num_from_float(NAN) == (num_t)0);
}

void test_num_to_float_gives_the_value_back(void)
{
    for (size_t i = 0; i < COUNT_OF(OPERAND); i++) {
        TEST_ASSERT_EQUAL_DOUBLE(OPERAND[i], (double)num_to_float(num_from_float((float)OPERAND[i])));
    }
}

void test_num_constants_are_the_nearest_step(void)
{
    /* the float itself is off by up to 2^-25 of the value, its conversion by half a step */
    ASSERT_NUM_WITHIN(3.0e-8, 0.57735026919, NUM_C(0.57735026919f));
    ASSERT_NUM_WITHIN(3.0e-8, -0.57735026919, NUM_C(-0.57735026919f));
    ASSERT_NUM_WITHIN(3.0e-8, 0.86602540378, NUM_C(0.86602540378f));
    ASSERT_NUM_WITHIN(3.0e-8, 0.99999994, NUM_C(0.99999994f));
    ASSERT_NUM_WITHIN(3.0e-8, 0.1, NUM_C(0.1f));
    ASSERT_NUM_WITHIN(3.0e-8, -0.1, NUM_C(-0.1f));
    ASSERT_NUM_WITHIN(0.0, 100.0, NUM_C(100.0f));
}

void test_num_from_int_is_exact_within_the_range(void)
{
    ASSERT_NUM_WITHIN(0.0, 127.0, num_from_int(127));
    ASSERT_NUM_WITHIN(0.0, -127.0, num_from_int(-127));
    ASSERT_NUM_WITHIN(0.0, 0.0, num_from_int(0));
}

void test_num_floor_is_the_largest_whole_number_not_above(void)
{
    TEST_ASSERT_EQUAL_INT32(3, num_floor(num_of(3.99)));
    TEST_ASSERT_EQUAL_INT32(3, num_floor(num_of(3.0)));
    TEST_ASSERT_EQUAL_INT32(0, num_floor(num_of(0.25)));
    TEST_ASSERT_EQUAL_INT32(-1, num_floor(num_of(-0.25)));
    TEST_ASSERT_EQUAL_INT32(-4, num_floor(num_of(-4.0)));
    TEST_ASSERT_EQUAL_INT32(-5, num_floor(num_of(-4.01)));
}

void test_num_floor_beyond_32_bits_gives_the_limit(void)
{
    FLOAT_ONLY();

    TEST_ASSERT_EQUAL_INT32(INT32_MAX, num_floor(num_of(3e9)));
    TEST_ASSERT_EQUAL_INT32(INT32_MAX, num_floor(num_of(2147483648.0)));
    TEST_ASSERT_EQUAL_INT32(INT32_MIN, num_floor(num_of(-3e9)));
    TEST_ASSERT_EQUAL_INT32(INT32_MIN, num_floor(num_of(-2147483648.0)));
    TEST_ASSERT_EQUAL_INT32(INT32_MAX, num_floor(NOT_FINITE[0])); /* NaN */
}

void test_ctl_diag_range_takes_both_ends_and_names_the_field_outside(void)
{
    const num_t lo = num_of(-1.0);
    const num_t hi = num_of(2.0);

    TEST_ASSERT_EQUAL(CTL_OK, ctl_diag_range(lo, lo, hi, 5U).status);
    TEST_ASSERT_EQUAL(CTL_OK, ctl_diag_range(hi, lo, hi, 5U).status);
    const ctl_diag_t below = ctl_diag_range(num_of(-1.5), lo, hi, 5U);
    const ctl_diag_t above = ctl_diag_range(num_of(2.5), lo, hi, 6U);
    TEST_ASSERT_EQUAL(CTL_ERR_RANGE, below.status);
    TEST_ASSERT_EQUAL_UINT16(5U, below.field);
    ASSERT_NUM_WITHIN(0.0, -1.5, below.given);
    TEST_ASSERT_EQUAL(CTL_ERR_RANGE, above.status);
    TEST_ASSERT_EQUAL_UINT16(6U, above.field);
    ASSERT_NUM_WITHIN(0.0, 2.5, above.given);
}

void test_ctl_diag_range_has_no_place_for_what_is_not_finite(void)
{
    for (size_t i = 0; i < COUNT_OF(NOT_FINITE); i++) {
        TEST_ASSERT_EQUAL(CTL_ERR_RANGE, ctl_diag_range(NOT_FINITE[i], -NUM_MAX, NUM_MAX, 1U).status);
    }
}

void test_ctl_diag_count_shows_the_whole_number_as_far_as_it_can(void)
{
    const ctl_diag_t small = ctl_diag_count(CTL_ERR_MEMORY, 3U, 100U);
    const ctl_diag_t high = ctl_diag_count(CTL_ERR_RANGE, 3U, 32766U);
    const ctl_diag_t large = ctl_diag_count(CTL_ERR_RANGE, 3U, 40000U);

    TEST_ASSERT_EQUAL(CTL_ERR_MEMORY, small.status);
    TEST_ASSERT_EQUAL_UINT16(3U, small.field);
    ASSERT_NUM_WITHIN(0.0, 100.0, small.given);
    ASSERT_NUM_WITHIN(per_numeric(0.0, FIXED_STEP), per_numeric(32766.0, 128.0), high.given);
    ASSERT_NUM_WITHIN(per_numeric(0.0, FIXED_STEP), per_numeric(32767.0, 128.0), large.given);
}

void test_num_clamp_of_what_is_not_a_number_is_the_lower_end(void)
{
    FLOAT_ONLY();
    TEST_ASSERT_TRUE(num_clamp(NOT_FINITE[0], num_of(-2.0), num_of(3.0)) == num_of(-2.0));
}

void test_num_raw_forms_are_the_same_for_ordinary_numbers(void)
{
    noise_t noise = {9U};
    for (uint32_t i = 0; i < 500U; i++) {
        const num_t a = num_of(20.0 * noise_next(&noise));
        const num_t b = num_of(1.0 + noise_next(&noise));
        const float x = (float)(40.0 * noise_next(&noise));

        TEST_ASSERT_TRUE(num_quotient(a, b) == num_div(a, b));
        TEST_ASSERT_TRUE(num_from_finite(x) == num_from_float(x));
    }
}
