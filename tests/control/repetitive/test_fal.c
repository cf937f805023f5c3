/* control/repetitive/fal.c against decimals; continuity at the knee, odd symmetry, every input. */
#include "tests/support/numeric.h"

#include "control/repetitive/fal.h"
#include "tests/control/golden/fal.h"

static ctl_fal_t fal;

/* Header of fal.h. Fixed: of the larger of 1 and the result. */
static double fal_bound(double y) { return per_numeric(2e-6 * fabs(y), 1e-6 * fmax(1.0, fabs(y))); }

static void start(double alpha, double delta)
{
    const ctl_fal_params_t p = {num_of(alpha), num_of(delta)};
    TEST_ASSERT_EQUAL(CTL_OK, ctl_fal_init(&fal, &p).status);
}

void setUp(void) { start(0.6, 0.4); }
void tearDown(void) {}

void test_ctl_fal_matches_golden(void)
{
    for (size_t i = 0; i < COUNT_OF(GOLDEN_FAL); i++) {
        const golden_fal_t *const g = &GOLDEN_FAL[i];
        start(g->alpha, g->delta);

        ASSERT_NUM_WITHIN_AT(fal_bound(g->y), g->y, ctl_fal(&fal, num_of(g->e)), at("row %u", (unsigned)i));
    }
}

void test_ctl_fal_lambda_matches_golden(void)
{
    for (size_t i = 0; i < COUNT_OF(GOLDEN_FAL); i++) {
        const golden_fal_t *const g = &GOLDEN_FAL[i];
        start(g->alpha, g->delta);

        ASSERT_NUM_WITHIN_AT(fal_bound(g->lambda), g->lambda, ctl_fal_lambda(&fal, num_of(g->e)), at("row %u", (unsigned)i));
    }
}

void test_ctl_fal_matches_golden_over_the_range_of_float(void)
{
    FLOAT_ONLY();
    for (size_t i = 0; i < COUNT_OF(GOLDEN_FAL_WIDE); i++) {
        const double y = GOLDEN_FAL_WIDE[i].y;

        ASSERT_NUM_WITHIN_AT(fal_bound(y), y, ctl_fal(&fal, num_of(GOLDEN_FAL_WIDE[i].e)), at("row %u", (unsigned)i));
    }
}

void test_ctl_fal_keeps_its_bound_over_its_range(void)
{
    static const double ALPHA[] = {0.05, 0.3, 0.6, 0.9, 1.0};
    double              worst = 0.0;
    for (size_t i = 0; i < COUNT_OF(ALPHA); i++) {
        start(ALPHA[i], 0.4);
        const double alpha = value_of(fal.params.alpha);
        for (double e = per_numeric(1e-9, 1.0 / 65536.0); e < per_numeric(1e9, 127.0); e *= per_numeric(1.02, 1.003)) {
            const double given = value_of(num_of(e));
            const double y = (given <= 0.4) ? (given * pow(0.4, alpha - 1.0)) : pow(given, alpha);
            worst = fmax(worst, fabs(value_of(ctl_fal(&fal, num_of(e))) - y) / fal_bound(y));
        }
    }

    TEST_ASSERT_DOUBLE_WITHIN(0.45, 0.55, worst); /* inside the bound, and not suddenly ten times better */
}

void test_ctl_fal_steepest_slope_of_the_paper_is_1_4427(void)
{
    ASSERT_NUM_WITHIN(1e-6, 1.442700, ctl_fal_lambda(&fal, (num_t)0)); /* 0.4^-0.4 = 1.44269991 */
    ASSERT_NUM_WITHIN(0.0, value_of(fal.slope), ctl_fal_lambda(&fal, num_of(0.3)));
}

void test_ctl_fal_is_odd(void)
{
    noise_t noise = {81U};
    for (uint32_t i = 0; i < 1000U; i++) {
        const num_t e = num_of(8.0 * noise_next(&noise));

        /* the linear part in fixed point rounds halves upwards */
        ASSERT_NUM_WITHIN(per_numeric(0.0, FIXED_STEP), -value_of(ctl_fal(&fal, e)), ctl_fal(&fal, num_neg(e)));
        TEST_ASSERT_TRUE(ctl_fal_lambda(&fal, e) == ctl_fal_lambda(&fal, num_neg(e)));
    }
}

void test_ctl_fal_is_continuous_at_the_knee(void)
{
    static const double PAIRS[][2] = {{0.6, 0.4}, {0.3, 0.05}, {0.5, 2.0}, {0.05, 0.25}, {0.875, 0.001}, {1.0, 0.5}, {0.6, 50.0}};
    for (size_t i = 0; i < COUNT_OF(PAIRS); i++) {
        start(PAIRS[i][0], PAIRS[i][1]);
        const num_t  knee = fal.params.delta;
        const num_t  beyond = num_of(value_of(knee) * (1.0 + 1e-7) + per_numeric(0.0, FIXED_STEP));
        const double y = value_of(ctl_fal(&fal, knee));
        const double step = value_of(fal.slope) * (value_of(beyond) - value_of(knee));

        ASSERT_NUM_WITHIN_AT(2.0 * fal_bound(y) + step, y, ctl_fal(&fal, beyond), at("pair %u", (unsigned)i));
        /* lambda falls by 1 - alpha of itself per relative step of the error */
        const double fall = (1.0 - PAIRS[i][0]) * step / value_of(knee);
        ASSERT_NUM_WITHIN_AT(2.0 * fal_bound(y / value_of(knee)) + fall, value_of(fal.slope), ctl_fal_lambda(&fal, beyond),
                             at("pair %u", (unsigned)i));
    }
}

void test_ctl_fal_never_falls_and_lambda_never_rises(void)
{
    num_t y0 = (num_t)0;
    num_t l0 = NUM_MAX;
    for (double e = 0.0; e < 60.0; e += 1.0 / 64.0) { /* coarser than the error of the power */
        const num_t y = ctl_fal(&fal, num_of(e));
        const num_t l = ctl_fal_lambda(&fal, num_of(e));

        TEST_ASSERT_TRUE_MESSAGE(y >= y0, at("fal(%g)", e));
        TEST_ASSERT_TRUE_MESSAGE(l <= l0, at("lambda(%g)", e));
        TEST_ASSERT_TRUE_MESSAGE((l > (num_t)0) && (l <= fal.slope), at("lambda(%g)", e));
        y0 = y;
        l0 = l;
    }
}

void test_ctl_fal_lambda_times_the_error_is_fal(void)
{
    noise_t noise = {82U};
    for (uint32_t i = 0; i < 500U; i++) {
        const num_t  e = num_of(100.0 * noise_next(&noise));
        const double y = value_of(ctl_fal(&fal, e));

        const double bound = fal_bound(y) + (fabs(value_of(e)) * fal_bound(value_of(ctl_fal_lambda(&fal, e))));
        TEST_ASSERT_DOUBLE_WITHIN(bound, y, value_of(ctl_fal_lambda(&fal, e)) * value_of(e));
    }
}

void test_ctl_fal_with_alpha_one_is_the_error_itself(void)
{
    start(1.0, 0.5);

    ASSERT_NUM_WITHIN(0.0, 0.25, ctl_fal(&fal, num_of(0.25)));
    ASSERT_NUM_WITHIN(fal_bound(7.0), -7.0, ctl_fal(&fal, num_of(-7.0)));
}

void test_ctl_fal_of_zero_is_zero(void) { ASSERT_NUM_WITHIN(0.0, 0.0, ctl_fal(&fal, (num_t)0)); }

void test_ctl_fal_of_what_is_not_finite_is_that_of_the_largest_number_or_zero(void)
{
    const double most = value_of(ctl_fal(&fal, NUM_MAX));
#ifdef EVENSPIN_FIXED
    ASSERT_NUM_WITHIN(0.0, -most, ctl_fal(&fal, INT32_MIN));
    ASSERT_NUM_WITHIN(0.0, value_of(ctl_fal_lambda(&fal, NUM_MAX)), ctl_fal_lambda(&fal, INT32_MIN));
#else
    ASSERT_NUM_WITHIN(0.0, most, ctl_fal(&fal, INFINITY));
    ASSERT_NUM_WITHIN(0.0, -most, ctl_fal(&fal, -INFINITY));
    ASSERT_NUM_WITHIN(0.0, 0.0, ctl_fal(&fal, NAN));
    ASSERT_NUM_WITHIN(0.0, value_of(fal.slope), ctl_fal_lambda(&fal, NAN));
#endif
}

void test_ctl_fal_with_any_parameters_of_anything_is_bounded(void)
{
    noise_t noise = {83U};
    for (uint32_t i = 0; i < 4000U; i++) {
        const ctl_fal_params_t p = {noise_nasty(&noise), noise_nasty(&noise)};
        const num_t            e = noise_nasty(&noise);
        if (ctl_fal_init(&fal, &p).status == CTL_OK) {
            ASSERT_BOUNDED_AT(1.000002 * num_max_value(), ctl_fal(&fal, e), at("turn %u", i));
            ASSERT_BOUNDED_AT(value_of(fal.slope), ctl_fal_lambda(&fal, e), at("turn %u", i));
        }
    }
}

/* ---- configuration ---------------------------------------------------------------------------------------------------- */

static void assert_rejected(num_t alpha, num_t delta, ctl_status_t status, uint16_t field, num_t given)
{
    const ctl_fal_params_t p = {alpha, delta};
    const ctl_fal_t        before = fal;

    const ctl_diag_t got = ctl_fal_init(&fal, &p);
    const ctl_diag_t foreseen = ctl_fal_check(&p);

    TEST_ASSERT_EQUAL(got.status, foreseen.status);
    TEST_ASSERT_EQUAL_UINT16(got.field, foreseen.field);
    ASSERT_SAME_BITS(got.given, foreseen.given);
    TEST_ASSERT_EQUAL(status, got.status);
    TEST_ASSERT_EQUAL_UINT16(field, got.field);
    ASSERT_SAME_BITS(given, got.given);
    ASSERT_SAME_BITS(before, fal);
}

void test_ctl_fal_init_rejects_an_exponent_out_of_range(void)
{
    assert_rejected((num_t)0, num_of(0.4), CTL_ERR_RANGE, CTL_FAL_ALPHA, (num_t)0);
    assert_rejected(num_of(-0.5), num_of(0.4), CTL_ERR_RANGE, CTL_FAL_ALPHA, num_of(-0.5));
    assert_rejected(num_of(1.001), num_of(0.4), CTL_ERR_RANGE, CTL_FAL_ALPHA, num_of(1.001));
}

void test_ctl_fal_init_rejects_a_width_that_is_not_positive(void)
{
    assert_rejected(num_of(0.6), (num_t)0, CTL_ERR_RANGE, CTL_FAL_DELTA, (num_t)0);
    assert_rejected(num_of(0.6), num_of(-0.4), CTL_ERR_RANGE, CTL_FAL_DELTA, num_of(-0.4));
}

void test_ctl_fal_init_rejects_what_is_not_finite(void)
{
    for (size_t i = 0; i < COUNT_OF(NOT_FINITE); i++) {
        assert_rejected(NOT_FINITE[i], num_of(0.4), CTL_ERR_RANGE, CTL_FAL_ALPHA, NOT_FINITE[i]);
        assert_rejected(num_of(0.6), NOT_FINITE[i], CTL_ERR_RANGE, CTL_FAL_DELTA, NOT_FINITE[i]);
    }
}

void test_ctl_fal_init_rejects_a_slope_that_the_numeric_cannot_hold(void)
{
    FIXED_ONLY(); /* float holds the slope of the smallest parameters there are */

    /* delta^(alpha-1) = 708 saturates at 128: fal would jump at the knee by half a unit */
    assert_rejected(num_of(0.05), num_of(0.001), CTL_ERR_RELATION, CTL_FAL_DELTA, num_of(0.001));
}

void test_ctl_fal_init_without_a_pointer_says_so(void)
{
    const ctl_fal_params_t p = {num_of(0.6), num_of(0.4)};
    const ctl_fal_t        before = fal;

    ASSERT_DIAG(CTL_ERR_NULL, 0U, 0.0, ctl_fal_init(NULL, &p));
    ASSERT_DIAG(CTL_ERR_NULL, 0U, 0.0, ctl_fal_init(&fal, NULL));
    ASSERT_DIAG(CTL_ERR_NULL, 0U, 0.0, ctl_fal_check(NULL));
    TEST_ASSERT_EQUAL(CTL_OK, ctl_fal_check(&p).status);
    ASSERT_SAME_BITS(before, fal);
}

/* |e|^alpha in double precision at both ends of what the table holds, and in each of its octaves. */
void test_ctl_fal_is_the_power_from_the_smallest_knee_to_the_largest_number(void)
{
    FLOAT_ONLY(); /* fixed point has no table */
    start(0.6, 1.0e-12);
    for (double e = 1.01e-12; e < 0.99 * num_max_value(); e *= 1.37) {
        const double x = value_of(num_of(e)), want = pow(x, value_of(num_of(0.6)));
        ASSERT_NUM_WITHIN_AT(2e-6 * want, want, ctl_fal(&fal, num_of(e)), at("%g", e));
    }
}
