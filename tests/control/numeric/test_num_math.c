/* control/numeric/num_math.c against decimals of 40 digits, and at its edges. */
#include "tests/support/numeric.h"

#include "control/numeric/num_math.h"
#include "tests/control/golden/num_math.h"

void setUp(void) {}
void tearDown(void) {}

static double larger(double a, double b) { return (a > b) ? a : b; }

/* Bounds of the header, as it states them. */
static double log2_bound(double y) { return per_numeric((fabs(y) <= 2.0) ? 2e-7 : 1.5e-7 * fabs(y), 3e-7); }
static double exp2_bound(double y) { return per_numeric(3e-7 * y, 4.0 * FIXED_STEP * larger(1.0, y)); }
static double pow_bound(double y) { return per_numeric(2e-6 * y, 1e-6 * larger(1.0, y)); }
static double sqrt_bound(double y) { return per_numeric(2e-7 * y, 0.5001 * FIXED_STEP); }

void test_num_log2_matches_golden(void)
{
    for (size_t i = 0; i < COUNT_OF(GOLDEN_LOG2); i++) {
        const double x = GOLDEN_LOG2[i].x;

        ASSERT_NUM_WITHIN_AT(log2_bound(GOLDEN_LOG2[i].y), GOLDEN_LOG2[i].y, num_log2(num_of(x)), at("log2(%g)", x));
    }
}

void test_num_exp2_matches_golden(void)
{
    for (size_t i = 0; i < COUNT_OF(GOLDEN_EXP2); i++) {
        const double x = GOLDEN_EXP2[i].x;

        ASSERT_NUM_WITHIN_AT(exp2_bound(GOLDEN_EXP2[i].y), GOLDEN_EXP2[i].y, num_exp2(num_of(x)), at("2^%g", x));
    }
}

void test_num_pow_matches_golden(void)
{
    for (size_t i = 0; i < COUNT_OF(GOLDEN_POW); i++) {
        const double base = GOLDEN_POW[i].base;
        const double exponent = GOLDEN_POW[i].exponent;
        const double y = GOLDEN_POW[i].y;

        ASSERT_NUM_WITHIN_AT(pow_bound(y), y, num_pow(num_of(base), num_of(exponent)), at("%g^%g", base, exponent));
    }
}

void test_num_pow_matches_golden_over_the_range_of_float(void)
{
    FLOAT_ONLY();
    for (size_t i = 0; i < COUNT_OF(GOLDEN_POW_WIDE); i++) {
        const double base = GOLDEN_POW_WIDE[i].base;
        const double exponent = GOLDEN_POW_WIDE[i].exponent;
        const double y = GOLDEN_POW_WIDE[i].y;

        ASSERT_NUM_WITHIN_AT(pow_bound(y), y, num_pow(num_of(base), num_of(exponent)), at("%g^%g", base, exponent));
    }
}

void test_num_sqrt_matches_golden(void)
{
    for (size_t i = 0; i < COUNT_OF(GOLDEN_SQRT); i++) {
        const double x = GOLDEN_SQRT[i].x;

        ASSERT_NUM_WITHIN_AT(sqrt_bound(GOLDEN_SQRT[i].y), GOLDEN_SQRT[i].y, num_sqrt(num_of(x)), at("sqrt(%g)", x));
    }
}

/* Golden vectors are few; the header's bounds hold everywhere, so sweep with the host's libm as the judge. */
void test_num_log2_keeps_its_bound_over_its_range(void)
{
    const double first = per_numeric(1.2e-38, FIXED_STEP);
    const double last = per_numeric(0.999e12, 127.9);
    double       worst = 0.0;
    for (double x = first; x < last; x *= per_numeric(1.009, 1.0021)) {
        const num_t  given = num_of(x);
        const double y = log2(value_of(given));
        worst = larger(worst, fabs(value_of(num_log2(given)) - y) / log2_bound(y));
    }

    TEST_ASSERT_DOUBLE_WITHIN(0.45, 0.55, worst); /* within the bound, and not suddenly ten times better than stated */
}

void test_num_exp2_keeps_its_bound_over_its_range(void)
{
    double worst = 0.0;
    for (double x = per_numeric(-126.0, -27.0); x < per_numeric(39.8, 6.99); x += per_numeric(0.0101, 0.0021)) {
        const num_t  given = num_of(x);
        const double y = exp2(value_of(given));
        worst = larger(worst, fabs(value_of(num_exp2(given)) - y) / exp2_bound(y));
    }

    TEST_ASSERT_DOUBLE_WITHIN(0.45, 0.55, worst);
}

void test_num_pow_keeps_its_bound_over_its_range(void)
{
    const double first = per_numeric(1e-9, 1.0 / 65536.0);
    const double last = per_numeric(1e9, 127.0);
    double       worst = 0.0;
    for (double exponent = -1.0; exponent <= 1.0; exponent += 0.043) {
        for (double base = first; base < last; base *= per_numeric(1.05, 1.017)) {
            const num_t  b = num_of(base);
            const num_t  e = num_of(exponent);
            const double y = pow(value_of(b), value_of(e));
            if (y < per_numeric(1e9, 127.0)) {
                worst = larger(worst, fabs(value_of(num_pow(b, e)) - y) / pow_bound(y));
            }
        }
    }

    TEST_ASSERT_DOUBLE_WITHIN(0.45, 0.55, worst);
}

void test_num_sqrt_keeps_its_bound_over_its_range(void)
{
    const double first = per_numeric(1.2e-38, FIXED_STEP);
    const double last = per_numeric(0.999e12, 127.9);
    double       worst = 0.0;
    for (double x = first; x < last; x *= per_numeric(1.009, 1.0021)) {
        const num_t  given = num_of(x);
        const double y = sqrt(value_of(given));
        worst = larger(worst, fabs(value_of(num_sqrt(given)) - y) / sqrt_bound(y));
    }

    TEST_ASSERT_DOUBLE_WITHIN(0.45, 0.55, worst);
}

void test_num_log2_is_continuous_where_it_changes_the_exponent(void)
{
    const double knee = 1.41421356237;
    for (int k = -6; k <= 5; k++) {
        const num_t  below = num_of(ldexp(knee - 1e-6, k));
        const num_t  above = num_of(ldexp(knee + 1e-6, k));
        const double rise = log2(value_of(above)) - log2(value_of(below));

        ASSERT_NUM_WITHIN_AT(per_numeric(1e-6, 6e-7), rise, num_sub(num_log2(above), num_log2(below)), at("2^%d", k));
    }
}

void test_num_exp2_is_continuous_where_it_changes_the_exponent(void)
{
    for (int k = -5; k <= 5; k++) {
        const num_t  below = num_of(k + 0.5 - 1e-6);
        const num_t  above = num_of(k + 0.5 + 1e-6);
        const double y = exp2(k + 0.5);

        ASSERT_NUM_WITHIN_AT(2.0 * exp2_bound(y) + 2e-6 * y, 0.0, num_sub(num_exp2(above), num_exp2(below)), at("%d", k));
    }
}

void test_num_exp2_of_whole_numbers_is_a_power_of_two(void)
{
    for (int k = -20; k <= 6; k++) {
        ASSERT_NUM_WITHIN_AT(0.0, ldexp(1.0, k), num_exp2(num_of(k)), at("2^%d", k));
    }
}

void test_num_log2_of_what_has_none_is_that_of_the_smallest_number(void)
{
    const double smallest = per_numeric(-126.0, -24.0);

    ASSERT_NUM_WITHIN(0.0, smallest, num_log2((num_t)0));
    ASSERT_NUM_WITHIN(0.0, smallest, num_log2(num_of(-1.0)));
    ASSERT_NUM_WITHIN(0.0, smallest, num_log2(-NUM_MAX));
#ifdef EVENSPIN_FIXED
    ASSERT_NUM_WITHIN(0.0, smallest, num_log2(INT32_MIN));
#else
    ASSERT_NUM_WITHIN(0.0, smallest, num_log2(NAN));
    ASSERT_NUM_WITHIN(0.0, smallest, num_log2(1e-42f));
    ASSERT_NUM_WITHIN(0.0, smallest, num_log2(-INFINITY));
    ASSERT_NUM_WITHIN(log2_bound(39.0), 39.86313713864835, num_log2(INFINITY)); /* counts as NUM_MAX */
#endif
}

void test_num_exp2_saturates_upwards_and_ends_in_zero_downwards(void)
{
    const num_t high[] = {num_of(per_numeric(40.0, 7.0)), num_of(127.0), NUM_MAX};
    for (size_t i = 0; i < COUNT_OF(high); i++) {
        TEST_ASSERT_TRUE_MESSAGE(num_exp2(high[i]) == NUM_MAX, at("case %u", (unsigned)i));
    }
    ASSERT_NUM_WITHIN(0.0, 0.0, num_exp2(num_of(-127.5)));
    ASSERT_NUM_WITHIN(0.0, 0.0, num_exp2(-NUM_MAX));
#ifdef EVENSPIN_FIXED
    ASSERT_NUM_WITHIN(0.0, 0.0, num_exp2(num_of(-26.0)));
    ASSERT_NUM_WITHIN(0.0, 0.0, num_exp2(INT32_MIN));
#else
    TEST_ASSERT_TRUE(num_exp2(INFINITY) == NUM_MAX);
    ASSERT_NUM_WITHIN(0.0, 0.0, num_exp2(-INFINITY));
    ASSERT_NUM_WITHIN(0.0, 0.0, num_exp2(NAN));
#endif
}

void test_num_exp2_never_falls_up_to_its_limit(void)
{
    num_t before = (num_t)0;
    for (double x = per_numeric(36.0, 3.0); x < per_numeric(42.0, 9.0); x += 1.0 / 64.0) {
        const num_t y = num_exp2(num_of(x));

        TEST_ASSERT_TRUE_MESSAGE(y >= before, at("x = %g", x));
        TEST_ASSERT_TRUE_MESSAGE(value_of(y) <= exp2(x) * 1.000001, at("x = %g", x)); /* no jump ahead of the curve */
        TEST_ASSERT_TRUE_MESSAGE(y <= NUM_MAX, at("x = %g", x));
        before = y;
    }
}

void test_num_pow_of_a_base_without_a_power_is_zero(void)
{
    const num_t half = num_of(0.5);

    ASSERT_NUM_WITHIN(0.0, 0.0, num_pow((num_t)0, half));
    ASSERT_NUM_WITHIN(0.0, 0.0, num_pow(num_of(-4.0), half));
#ifdef EVENSPIN_FIXED
    ASSERT_NUM_WITHIN(0.0, 0.0, num_pow(INT32_MIN, half));
#else
    ASSERT_NUM_WITHIN(0.0, 0.0, num_pow(NAN, half));
    ASSERT_NUM_WITHIN(0.0, 0.0, num_pow(num_of(2.0), NAN));
#endif
}

void test_num_pow_of_extremes_is_within_the_range(void)
{
    for (size_t i = 0; i < COUNT_OF(NASTY); i++) {
        for (size_t j = 0; j < COUNT_OF(NASTY); j++) {
            const num_t y = num_pow(NASTY[i], NASTY[j]);

            TEST_ASSERT_TRUE_MESSAGE((y >= (num_t)0) && (y <= NUM_MAX), at("%u to the %u", (unsigned)i, (unsigned)j));
        }
    }
}

void test_num_sqrt_of_what_has_none_is_zero(void)
{
    ASSERT_NUM_WITHIN(0.0, 0.0, num_sqrt((num_t)0));
    ASSERT_NUM_WITHIN(0.0, 0.0, num_sqrt(num_of(-1.0)));
    ASSERT_NUM_WITHIN(0.0, 0.0, num_sqrt(-NUM_MAX));
#ifdef EVENSPIN_FIXED
    ASSERT_NUM_WITHIN(0.0, 0.0, num_sqrt(INT32_MIN));
#else
    ASSERT_NUM_WITHIN(0.0, 0.0, num_sqrt(NAN));
    ASSERT_NUM_WITHIN(0.0, 0.0, num_sqrt(1e-42f));
    ASSERT_NUM_WITHIN(1.0, 1e6, num_sqrt(INFINITY)); /* counts as NUM_MAX */
#endif
}

void test_num_sqrt_of_squares_is_exact(void)
{
    for (int i = 1; i <= 11; i++) {
        ASSERT_NUM_WITHIN_AT(per_numeric(FLOAT_EPS * i, 0.0), (double)i, num_sqrt(num_of((double)(i * i))), at("%d", i));
    }
}

/* ---- without looking ------------------------------------------------------------------------------------------------------ */

void test_num_math_raw_forms_keep_the_bounds_where_they_are_allowed(void)
{
    for (double x = 2e-7; x < 100.0; x *= 1.31) {
        const num_t  given = num_of(x);
        const double value = value_of(given);
        if (value > 0.0) {
            ASSERT_NUM_WITHIN_AT(log2_bound(log2(value)), log2(value), num_log2_unchecked(given), at("log2(%g)", x));
            ASSERT_NUM_WITHIN_AT(pow_bound(pow(value, 0.625)) + per_numeric(0.0, 1e-6), pow(value, 0.625),
                                 num_pow_unchecked(given, num_of(0.625)), at("%g^0.625", x));
            ASSERT_NUM_WITHIN_AT(sqrt_bound(sqrt(value)), sqrt(value), num_sqrt_unchecked(given), at("sqrt(%g)", x));
        }
    }
    for (double x = -20.0; x < 6.5; x += 0.37) {
        const double value = value_of(num_of(x));

        ASSERT_NUM_WITHIN_AT(exp2_bound(exp2(value)), exp2(value), num_exp2_unchecked(num_of(x)), at("2^%g", x));
    }
}

void test_num_exp2_raw_is_cut_to_its_range(void)
{
    TEST_ASSERT_TRUE(num_exp2_unchecked(-NUM_MAX) >= (num_t)0);
    ASSERT_BOUNDED_AT(1e-30, num_exp2_unchecked(-NUM_MAX), "far below");
    ASSERT_BOUNDED_AT(1.1 * num_max_value(), num_exp2_unchecked(NUM_MAX), "far above");
}
