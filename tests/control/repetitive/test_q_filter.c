/* control/repetitive/q_filter.h: a real, zero-phase frequency response, and the bound that keeps a memory finite. */
#include "tests/support/numeric.h"

#include "control/repetitive/q_filter.h"

static const ctl_q_t *q_of(double side, double centre)
{
    static ctl_q_t q;
    q.side = num_of(side);
    q.centre = num_of(centre);
    return &q;
}

void setUp(void) {}
void tearDown(void) {}

void test_ctl_q_apply_weighs_the_three_neighbours(void)
{
    const ctl_q_t *const q = q_of(0.25, 0.5);

    ASSERT_NUM_WITHIN(0.0, 0.25, ctl_q_apply(q, num_of(1.0), (num_t)0, (num_t)0));
    ASSERT_NUM_WITHIN(0.0, 0.5, ctl_q_apply(q, (num_t)0, num_of(1.0), (num_t)0));
    ASSERT_NUM_WITHIN(0.0, 0.25, ctl_q_apply(q, (num_t)0, (num_t)0, num_of(1.0)));
    ASSERT_NUM_WITHIN(0.0, -0.5, ctl_q_apply(q, num_of(1.0), num_of(-3.0), num_of(3.0)));
}

void test_ctl_q_apply_scales_every_cosine_by_its_magnitude_without_phase(void)
{
    static const double TAPS[][2] = {{0.45, 0.10}, {0.25, 0.5}, {0.05, 0.9}, {0.0, 1.0}, {-0.25, 0.5}};
    for (size_t i = 0; i < COUNT_OF(TAPS); i++) {
        for (double w = 0.0; w <= TWO_PI / 2.0; w += 0.1) {
            const double phase = 0.7;
            const double gain = TAPS[i][1] + (2.0 * TAPS[i][0] * cos(w));

            const num_t y =
                ctl_q_apply(q_of(TAPS[i][0], TAPS[i][1]), num_of(cos(phase - w)), num_of(cos(phase)), num_of(cos(phase + w)));

            /* taps and samples rounded, one product and one sum more: some steps of numbers up to 1 */
            ASSERT_NUM_WITHIN_AT(per_numeric(3e-7, 4.0 * FIXED_STEP), gain * cos(phase), y, at("taps %u, w %g", (unsigned)i, w));
        }
    }
}

void test_ctl_q_is_bounded_up_to_a_sum_of_one(void)
{
    TEST_ASSERT_TRUE(ctl_q_is_bounded(q_of(0.45, 0.10)));
    TEST_ASSERT_TRUE(ctl_q_is_bounded(q_of(0.25, 0.5)));
    TEST_ASSERT_TRUE(ctl_q_is_bounded(q_of(0.0, 1.0)));
    TEST_ASSERT_TRUE(ctl_q_is_bounded(q_of(0.0, -1.0)));
    TEST_ASSERT_TRUE(ctl_q_is_bounded(q_of(-0.5, 0.0)));
    TEST_ASSERT_TRUE(ctl_q_is_bounded(q_of(0.0, 0.0)));
    TEST_ASSERT_TRUE(ctl_q_is_bounded(q_of(1.0 / 3.0, 1.0 / 3.0))); /* rounded upwards in one numeric or the other */
}

void test_ctl_q_is_not_bounded_beyond_a_sum_of_one(void)
{
    TEST_ASSERT_FALSE(ctl_q_is_bounded(q_of(0.0, 1.0001)));
    TEST_ASSERT_FALSE(ctl_q_is_bounded(q_of(0.0, -1.0001)));
    TEST_ASSERT_FALSE(ctl_q_is_bounded(q_of(0.50005, 0.0)));
    TEST_ASSERT_FALSE(ctl_q_is_bounded(q_of(-0.50005, 0.0)));
    TEST_ASSERT_FALSE(ctl_q_is_bounded(q_of(-0.3, 0.5))); /* at Nyquist the signs add up */
    TEST_ASSERT_FALSE(ctl_q_is_bounded(q_of(0.3, -0.5)));
    TEST_ASSERT_FALSE(ctl_q_is_bounded(q_of(127.0, 127.0)));
}

void test_ctl_q_is_not_bounded_with_a_tap_that_is_not_finite(void)
{
    for (size_t i = 0; i < COUNT_OF(NOT_FINITE); i++) {
        const ctl_q_t bad_side = {NOT_FINITE[i], num_of(0.1), (num_t)0};
        const ctl_q_t bad_centre = {num_of(0.1), NOT_FINITE[i], (num_t)0};

        TEST_ASSERT_FALSE(ctl_q_is_bounded(&bad_side));
        TEST_ASSERT_FALSE(ctl_q_is_bounded(&bad_centre));
    }
}

void test_ctl_q_apply_with_bounded_taps_never_enlarges(void)
{
    noise_t noise = {91U};
    for (uint32_t i = 0; i < 3000U; i++) {
        const ctl_q_t q = {num_of(noise_next(&noise)), num_of(noise_next(&noise)), (num_t)0};
        const num_t   a = num_of(60.0 * noise_next(&noise));
        const num_t   b = num_of(60.0 * noise_next(&noise));
        const num_t   c = num_of(60.0 * noise_next(&noise));
        if (ctl_q_is_bounded(&q)) {
            const double most = fmax(fabs(value_of(a)), fmax(fabs(value_of(b)), fabs(value_of(c))));

            ASSERT_BOUNDED_AT(most * 1.00002 + FIXED_STEP, ctl_q_apply(&q, a, b, c), at("turn %u", i));
        }
    }
}

/* Five taps against their sum at 201 frequencies, in double. */
void test_ctl_q_of_five_taps_is_bounded_where_its_magnitude_is_at_every_frequency(void)
{
    static double cosine[401]; /* of 2 pi k / 400: a machine without double takes half a minute for so many in the loop */
    for (int k = 0; k <= 400; k++) {
        cosine[k] = cos(TWO_PI * k / 400.0);
    }
    noise_t noise = {52U};
    int     compared = 0;
    int     bounded = 0;
    int     by_vertex = 0; /* both ends are within 1 */
    for (unsigned i = 0U; i < 3000U; i++) {
        const double  side = noise_next(&noise);
        const double  centre = 2.0 * noise_next(&noise);
        const double  side2 = 0.6 * noise_next(&noise);
        const ctl_q_t q = {num_of(side), num_of(centre), num_of(side2)};
        double        peak = 0.0;
        for (int k = 0; k <= 200; k++) {
            peak = fmax(peak, fabs(centre + (2.0 * side * cosine[k]) + (2.0 * side2 * cosine[2 * k])));
        }
        if (fabs(peak - 1.0) > 1e-3) { /* between two frequencies it is higher by 3e-4 at most */
            TEST_ASSERT_TRUE_MESSAGE((peak < 1.0) == ctl_q_is_bounded(&q), at("%g, %g, %g", side, centre, side2));
            compared++;
            bounded += (peak < 1.0) ? 1 : 0;
            const double ends = centre + (2.0 * side2);
            by_vertex += ((peak > 1.0) && (fabs(ends) + (2.0 * fabs(side)) < 1.0)) ? 1 : 0;
        }
    }
    TEST_ASSERT_TRUE(compared > 2800);
    TEST_ASSERT_TRUE_MESSAGE(bounded > 200, at("%d", bounded));
    TEST_ASSERT_TRUE_MESSAGE(by_vertex > 20, at("%d", by_vertex));
}

void test_ctl_q_of_five_taps_that_sum_up_to_more_than_1_may_be_bounded(void)
{
    const ctl_q_t flat = {num_of(0.2), num_of(0.7), num_of(-0.05)}; /* magnitudes 1.2 together; 1 at zero, 0.2 at Nyquist */
    const ctl_q_t more = {num_of(0.2), num_of(0.701), num_of(-0.05)};
    TEST_ASSERT_TRUE(ctl_q_is_bounded(&flat));
    TEST_ASSERT_FALSE(ctl_q_is_bounded(&more));
    for (size_t i = 0; i < COUNT_OF(NOT_FINITE); i++) {
        const ctl_q_t bad = {num_of(0.2), num_of(0.7), NOT_FINITE[i]};
        TEST_ASSERT_FALSE(ctl_q_is_bounded(&bad));
    }
}
