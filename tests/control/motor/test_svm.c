/* control/motor/svm.c against sector times, and the vector limit against complex numbers. */
#include "tests/support/numeric.h"

#include "control/motor/svm.h"
#include "tests/control/golden/svm.h"

/* Float: 6 roundings of numbers up to 1. Fixed: three constants and the scale, each half a step, times up to 1.4. */
#define DUTY_BOUND per_numeric(3e-7, 6.0 * FIXED_STEP)

void setUp(void) {}
void tearDown(void) {}

/* ---- modulation ----------------------------------------------------------------------------------------------------- */

void test_ctl_svm_matches_golden(void)
{
    for (size_t i = 0; i < COUNT_OF(GOLDEN_SVM); i++) {
        const golden_svm_t *const g = &GOLDEN_SVM[i];
        const ctl_ab_t            v = {num_of(g->alpha), num_of(g->beta)};
        ctl_abc_t                 duty = {NUM_MAX, NUM_MAX, NUM_MAX};

        TEST_ASSERT_TRUE(ctl_svm(&v, num_of(g->v_dc), &duty));

        ASSERT_NUM_WITHIN_AT(DUTY_BOUND, g->a, duty.a, at("row %u, a", (unsigned)i));
        ASSERT_NUM_WITHIN_AT(DUTY_BOUND, g->b, duty.b, at("row %u, b", (unsigned)i));
        ASSERT_NUM_WITHIN_AT(DUTY_BOUND, g->c, duty.c, at("row %u, c", (unsigned)i));
    }
}

void test_ctl_svm_gives_the_phase_to_phase_voltages_asked_for_up_to_the_inscribed_circle(void)
{
    noise_t noise = {51U};
    for (uint32_t i = 0; i < 1000U; i++) {
        const double   v_dc = 0.5 + fabs(noise_next(&noise));
        const double   length = 0.9999 * v_dc / sqrt(3.0) * sqrt(fabs(2.0 * noise_next(&noise)));
        const double   phi = TWO_PI * noise_next(&noise);
        const ctl_ab_t v = {num_of(length * cos(phi)), num_of(length * sin(phi))};
        ctl_abc_t      duty;

        TEST_ASSERT_TRUE(ctl_svm(&v, num_of(v_dc), &duty));

        const double v_b = (-0.5 * value_of(v.alpha)) + (sqrt(0.75) * value_of(v.beta));
        const double v_c = (-0.5 * value_of(v.alpha)) - (sqrt(0.75) * value_of(v.beta));
        TEST_ASSERT_DOUBLE_WITHIN(2.0 * DUTY_BOUND, (value_of(v.alpha) - v_b) / v_dc, value_of(duty.a) - value_of(duty.b));
        TEST_ASSERT_DOUBLE_WITHIN(2.0 * DUTY_BOUND, (v_b - v_c) / v_dc, value_of(duty.b) - value_of(duty.c));
    }
}

void test_ctl_svm_centres_the_active_time(void)
{
    noise_t noise = {52U};
    for (uint32_t i = 0; i < 300U; i++) {
        const ctl_ab_t v = {num_of(0.7 * noise_next(&noise)), num_of(0.7 * noise_next(&noise))};
        ctl_abc_t      duty;

        (void)ctl_svm(&v, num_of(1.0), &duty);

        const double high = fmax(value_of(duty.a), fmax(value_of(duty.b), value_of(duty.c)));
        const double low = fmin(value_of(duty.a), fmin(value_of(duty.b), value_of(duty.c)));
        TEST_ASSERT_DOUBLE_WITHIN(2.0 * DUTY_BOUND, 1.0, high + low); /* both zero vectors take the same time */
    }
}

void test_ctl_svm_beyond_the_hexagon_clips_and_stays_usable(void)
{
    const ctl_ab_t v = {num_of(5.0), num_of(0.0)};
    ctl_abc_t      duty;

    TEST_ASSERT_TRUE(ctl_svm(&v, num_of(1.0), &duty));

    ASSERT_NUM_WITHIN(0.0, 1.0, duty.a);
    ASSERT_NUM_WITHIN(0.0, 0.0, duty.b);
    ASSERT_NUM_WITHIN(0.0, 0.0, duty.c);
}

static void assert_zero_voltage(const ctl_ab_t *v, num_t v_dc)
{
    ctl_abc_t duty = {NUM_MAX, NUM_MAX, NUM_MAX};

    TEST_ASSERT_FALSE(ctl_svm(v, v_dc, &duty));

    ASSERT_NUM_WITHIN(0.0, 0.5, duty.a);
    ASSERT_NUM_WITHIN(0.0, 0.5, duty.b);
    ASSERT_NUM_WITHIN(0.0, 0.5, duty.c);
}

void test_ctl_svm_without_a_usable_input_gives_zero_voltage_and_says_so(void)
{
    const ctl_ab_t good = {num_of(0.25), num_of(0.125)};
    assert_zero_voltage(&good, (num_t)0);
    assert_zero_voltage(&good, num_of(-1.0));
    for (size_t i = 0; i < COUNT_OF(NOT_FINITE); i++) {
        const ctl_ab_t bad_alpha = {NOT_FINITE[i], num_of(0.125)};
        const ctl_ab_t bad_beta = {num_of(0.25), NOT_FINITE[i]};
        assert_zero_voltage(&bad_alpha, num_of(1.0));
        assert_zero_voltage(&bad_beta, num_of(1.0));
        assert_zero_voltage(&good, NOT_FINITE[i]);
    }
}

void test_ctl_svm_of_anything_gives_duties_between_zero_and_one(void)
{
    noise_t noise = {53U};
    for (uint32_t i = 0; i < 5000U; i++) {
        const ctl_ab_t v = {noise_nasty(&noise), noise_nasty(&noise)};
        ctl_abc_t      duty = {NUM_MAX, NUM_MAX, NUM_MAX};

        (void)ctl_svm(&v, noise_nasty(&noise), &duty);

        TEST_ASSERT_TRUE_MESSAGE((duty.a >= (num_t)0) && (duty.a <= num_of(1.0)), at("turn %u", i));
        TEST_ASSERT_TRUE_MESSAGE((duty.b >= (num_t)0) && (duty.b <= num_of(1.0)), at("turn %u", i));
        TEST_ASSERT_TRUE_MESSAGE((duty.c >= (num_t)0) && (duty.c <= num_of(1.0)), at("turn %u", i));
    }
}

/* ---- limit ------------------------------------------------------------------------------------------------------------ */

void test_ctl_vector_limit_matches_golden(void)
{
    for (size_t i = 0; i < COUNT_OF(GOLDEN_VECTOR_LIMIT); i++) {
        const golden_vector_limit_t *const g = &GOLDEN_VECTOR_LIMIT[i];
        const ctl_dq_t                     v = {num_of(g->d), num_of(g->q)};
        ctl_dq_t                           out = {NUM_MAX, NUM_MAX};

        const bool unchanged = ctl_vector_limit(&v, num_of(g->limit), &out);

        /* two quotients, a root and two products, of numbers up to `limit` */
        const double bound = g->limit * per_numeric(4e-7, 4.0 * FIXED_STEP) + per_numeric(0.0, 2.0 * FIXED_STEP);
        ASSERT_NUM_WITHIN_AT(bound, g->out_d, out.d, at("row %u", (unsigned)i));
        ASSERT_NUM_WITHIN_AT(bound, g->out_q, out.q, at("row %u", (unsigned)i));
        TEST_ASSERT_EQUAL_MESSAGE((g->out_d == g->d) && (g->out_q == g->q), unchanged, at("row %u", (unsigned)i));
    }
}

void test_ctl_vector_limit_leaves_a_short_vector_bit_for_bit(void)
{
    noise_t noise = {54U};
    for (uint32_t i = 0; i < 1000U; i++) {
        const ctl_dq_t v = {num_of(2.0 * noise_next(&noise)), num_of(2.0 * noise_next(&noise))};
        const double   length = hypot(value_of(v.d), value_of(v.q));
        ctl_dq_t       out;

        TEST_ASSERT_TRUE(ctl_vector_limit(&v, num_of((length * 1.000002) + 1e-6), &out)); /* closer than its own error */

        ASSERT_SAME_BITS(v, out);
    }
}

void test_ctl_vector_limit_keeps_the_direction_and_never_the_length(void)
{
    noise_t noise = {55U};
    for (uint32_t i = 0; i < 1000U; i++) {
        const ctl_dq_t v = {num_of(60.0 * noise_next(&noise)), num_of(60.0 * noise_next(&noise))};
        const double   length = hypot(value_of(v.d), value_of(v.q));
        const double   limit = value_of(num_of(length * (0.05 + (0.9 * fabs(noise_next(&noise)) * 2.0))));
        ctl_dq_t       out;

        TEST_ASSERT_FALSE(ctl_vector_limit(&v, num_of(limit), &out));

        const double bound = (limit * 4e-7) + per_numeric(0.0, 2.0 * FIXED_STEP);
        TEST_ASSERT_DOUBLE_WITHIN(bound, limit, hypot(value_of(out.d), value_of(out.q)));
        const double across = ((value_of(v.d) * value_of(out.q)) - (value_of(v.q) * value_of(out.d))) / length;
        TEST_ASSERT_DOUBLE_WITHIN(bound, 0.0, across);
    }
}

void test_ctl_vector_limit_of_zero_leaves_nothing(void)
{
    const ctl_dq_t v = {num_of(3.0), num_of(-4.0)};
    const ctl_dq_t none = {(num_t)0, (num_t)0};
    ctl_dq_t       out;

    TEST_ASSERT_FALSE(ctl_vector_limit(&v, (num_t)0, &out));
    ASSERT_NUM_WITHIN(0.0, 0.0, out.d);
    ASSERT_NUM_WITHIN(0.0, 0.0, out.q);
    TEST_ASSERT_TRUE(ctl_vector_limit(&none, (num_t)0, &out));
    ASSERT_NUM_WITHIN(0.0, 0.0, out.d);
}

void test_ctl_vector_limit_of_the_largest_vectors_does_not_overflow(void)
{
    const ctl_dq_t v = {NUM_MAX, -NUM_MAX};
    ctl_dq_t       out;

    TEST_ASSERT_FALSE(ctl_vector_limit(&v, num_of(10.0), &out));

    ASSERT_NUM_WITHIN(10.0 * 4e-7 + per_numeric(0.0, 2.0 * FIXED_STEP), 10.0 / sqrt(2.0), out.d);
    ASSERT_NUM_WITHIN(10.0 * 4e-7 + per_numeric(0.0, 2.0 * FIXED_STEP), -10.0 / sqrt(2.0), out.q);
}

static void assert_replaced(ctl_dq_t v, num_t limit)
{
    ctl_dq_t out = {NUM_MAX, NUM_MAX};

    TEST_ASSERT_FALSE(ctl_vector_limit(&v, limit, &out));

    ASSERT_NUM_WITHIN(0.0, 0.0, out.d);
    ASSERT_NUM_WITHIN(0.0, 0.0, out.q);
}

void test_ctl_vector_limit_replaces_what_it_cannot_use_by_zero(void)
{
    const ctl_dq_t good = {num_of(0.25), num_of(0.5)};
    assert_replaced(good, num_of(-1.0));
    for (size_t i = 0; i < COUNT_OF(NOT_FINITE); i++) {
        assert_replaced((ctl_dq_t){NOT_FINITE[i], num_of(0.5)}, num_of(1.0));
        assert_replaced((ctl_dq_t){num_of(0.25), NOT_FINITE[i]}, num_of(1.0));
    }
#ifdef EVENSPIN_FIXED
    assert_replaced(good, INT32_MIN);
#else
    assert_replaced(good, NAN);
    assert_replaced(good, -INFINITY);
#endif
}

void test_ctl_vector_limit_of_anything_is_bounded_by_the_limit(void)
{
    noise_t noise = {56U};
    for (uint32_t i = 0; i < 5000U; i++) {
        const ctl_dq_t v = {noise_nasty(&noise), noise_nasty(&noise)};
        const num_t    limit = noise_nasty(&noise);
        ctl_dq_t       out = {NUM_MAX, NUM_MAX};

        (void)ctl_vector_limit(&v, limit, &out);

        const double allowed = (limit >= (num_t)0) ? fmin(value_of(limit), 2.0 * num_max_value()) : 0.0;
        const double length = hypot(value_of(out.d), value_of(out.q));
        const double rounding = (allowed * 5e-7) + per_numeric(1e-44, 2.0 * FIXED_STEP); /* steps below FLT_MIN: 1.4e-45 */
        TEST_ASSERT_TRUE_MESSAGE(length <= allowed + rounding, at("turn %u", i));
    }
}

/* ---- without looking ------------------------------------------------------------------------------------------------------ */

void test_ctl_svm_unchecked_is_the_same_but_for_the_clip(void)
{
    noise_t noise = {57U};
    for (uint32_t i = 0; i < 1000U; i++) {
        const ctl_ab_t v = {num_of(1.5 * noise_next(&noise)), num_of(1.5 * noise_next(&noise))};
        const num_t    v_dc = num_of(0.5 + fabs(noise_next(&noise)));
        ctl_abc_t      want;
        TEST_ASSERT_TRUE(ctl_svm(&v, v_dc, &want));

        const ctl_abc_t open = ctl_svm_unchecked(v, v_dc);
        const ctl_abc_t got = {num_clamp(open.a, (num_t)0, num_of(1.0)), num_clamp(open.b, (num_t)0, num_of(1.0)),
                               num_clamp(open.c, (num_t)0, num_of(1.0))};

        ASSERT_SAME_BITS(want, got);
    }
}

void test_ctl_vector_limit_raw_cuts_to_the_length_and_leaves_what_is_shorter(void)
{
    noise_t noise = {59U};
    for (uint32_t i = 0; i < 2000U; i++) {
        const ctl_dq_t v = {num_of(60.0 * noise_next(&noise)), num_of(60.0 * noise_next(&noise))};
        const double   length = hypot(value_of(v.d), value_of(v.q));
        const double   share = 0.1 + (3.0 * fabs(noise_next(&noise)));
        const double   limit = value_of(num_of(length * share));
        ctl_dq_t       out;
        if (fabs(share - 1.0) < 1e-5) {
            continue; /* closer than the rounding of the squares */
        }

        TEST_ASSERT_TRUE_MESSAGE((share > 1.0) == ctl_vector_limit_unchecked(v, num_of(limit), &out), at("turn %u", i));

        const double cut = (share > 1.0) ? 1.0 : (limit / length);
        const double bound = (limit * 4e-7) + per_numeric(0.0, 2.0 * FIXED_STEP);
        ASSERT_NUM_WITHIN_AT(bound, cut * value_of(v.d), out.d, at("turn %u", i));
        ASSERT_NUM_WITHIN_AT(bound, cut * value_of(v.q), out.q, at("turn %u", i));
    }
}

/* Lengths and limits over the whole range that the header states, drawn evenly over their powers of ten, and their ends. The
 * expected length is calculated in double. */
void test_ctl_vector_limit_raw_keeps_its_contract_over_the_whole_range(void)
{
    FLOAT_ONLY();
    const double lengths[] = {1e-20, 1e-19, 9e-19, 1.1e-18, 1e-12, 1.0, 3e6, 1e9, 1e12};
    const double limits[] = {0.0, 1e-30, 1e-18, 1e-9, 12.0, 1e6, 1e12};
    noise_t      noise = {61U};
    for (uint32_t i = 0; i < 20000U; i++) {
        const bool     ends = i < (9U * 7U * 8U);
        const double   length = ends ? lengths[i % 9U] : pow(10.0, 32.0 * noise_next(&noise) - 4.0);
        const double   limit = value_of(num_of(ends ? limits[(i / 9U) % 7U] : pow(10.0, 32.0 * noise_next(&noise) - 4.0)));
        const double   angle = ends ? (double)(i / 63U) * 0.78539816339744831 : 6.2831853 * noise_next(&noise);
        const ctl_dq_t v = {(num_t)(length * cos(angle)), (num_t)(length * sin(angle))};
        const double   is = hypot((double)v.d, (double)v.q);
        ctl_dq_t       out = {(num_t)-1, (num_t)-1};
        const bool     whole = ctl_vector_limit_unchecked(v, (num_t)limit, &out);
        const double   got = hypot((double)out.d, (double)out.q);

        TEST_ASSERT_TRUE_MESSAGE(isfinite(got), at("turn %u", i));
        if (whole) {
            TEST_ASSERT_TRUE_MESSAGE((out.d == v.d) && (out.q == v.q), at("turn %u", i));
            TEST_ASSERT_TRUE_MESSAGE((is <= limit * 1.000001) || (is <= 1.000001e-18), at("turn %u: too long", i));
        } else {
            TEST_ASSERT_TRUE_MESSAGE(is > limit * 0.999999, at("turn %u: cut without need", i));
            const double least = (limit < 1e-18) ? 1e-18 : limit * 1e-6; /* three roundings and the root's 2e-7 */
            ASSERT_DOUBLE_WITHIN_AT(least, limit, got, at("turn %u", i));
            ASSERT_DOUBLE_WITHIN_AT(((limit < 1e-18) ? 1e-18 : limit) * is * 4e-6 + 1e-37, 0.0,
                                    (double)out.d * (double)v.q - (double)out.q * (double)v.d, at("turn %u", i));
        }
    }
}

/* Every length that the numeric has, with every limit: never longer than the limit by more than two steps of each axis. */
void test_ctl_vector_limit_raw_in_fixed_point_keeps_to_any_limit(void)
{
    FIXED_ONLY();
    noise_t noise = {67U};
    for (uint32_t i = 0; i < 20000U; i++) {
        const ctl_dq_t v = {num_of(255.9 * noise_next(&noise)), num_of(255.9 * noise_next(&noise))};
        const double   part = fabs(noise_next(&noise)) * 2.0;
        const double   limit = value_of(num_of(180.0 * part * part * part));
        ctl_dq_t       out;
        (void)ctl_vector_limit_unchecked(v, num_of(limit), &out);
        const double got = hypot(value_of(out.d), value_of(out.q));
        TEST_ASSERT_TRUE_MESSAGE(got <= value_of(num_of(limit)) * (1.0 + 4e-7) + 3.0 * FIXED_STEP, at("turn %u", i));
    }
}
