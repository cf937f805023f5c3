/* control/motor/frames.c against complex numbers; what is not finite is replaced and reported. */
#include "tests/support/numeric.h"

#include "control/motor/frames.h"
#include "control/numeric/angle.h"
#include "tests/control/golden/frames.h"

/* Values within +-16: float, three roundings of up to 16; fixed, constants within half a step times 16, and the sine. */
#define BOUND per_numeric(6e-6, 1e-6 + (8.0 * 2.5e-7))

void setUp(void) {}
void tearDown(void) {}

static ctl_rotor_t rotor_at(angle_t angle)
{
    ctl_rotor_t r;
    angle_sincos(angle, &r.sine, &r.cosine);
    return r;
}

void test_ctl_clarke_matches_golden(void)
{
    for (size_t i = 0; i < COUNT_OF(GOLDEN_FRAMES); i++) {
        const golden_frames_t *const g = &GOLDEN_FRAMES[i];
        const ctl_abc_t              in = {num_of(g->a), num_of(g->b), num_of(g->c)};
        ctl_ab_t                     out = {NUM_MAX, NUM_MAX};

        TEST_ASSERT_TRUE(ctl_clarke(&in, &out));

        ASSERT_NUM_WITHIN_AT(BOUND, g->alpha, out.alpha, at("row %u", (unsigned)i));
        ASSERT_NUM_WITHIN_AT(BOUND, g->beta, out.beta, at("row %u", (unsigned)i));
    }
}

void test_ctl_inverse_clarke_matches_golden(void)
{
    for (size_t i = 0; i < COUNT_OF(GOLDEN_FRAMES); i++) {
        const golden_frames_t *const g = &GOLDEN_FRAMES[i];
        const ctl_ab_t               in = {num_of(g->alpha), num_of(g->beta)};
        ctl_abc_t                    out = {NUM_MAX, NUM_MAX, NUM_MAX};

        TEST_ASSERT_TRUE(ctl_inverse_clarke(&in, &out));

        ASSERT_NUM_WITHIN_AT(BOUND, g->back_a, out.a, at("row %u", (unsigned)i));
        ASSERT_NUM_WITHIN_AT(BOUND, g->back_b, out.b, at("row %u", (unsigned)i));
        ASSERT_NUM_WITHIN_AT(BOUND, g->back_c, out.c, at("row %u", (unsigned)i));
    }
}

void test_ctl_park_matches_golden(void)
{
    for (size_t i = 0; i < COUNT_OF(GOLDEN_FRAMES); i++) {
        const golden_frames_t *const g = &GOLDEN_FRAMES[i];
        const ctl_ab_t               in = {num_of(g->alpha), num_of(g->beta)};
        const ctl_rotor_t            rotor = rotor_at(g->angle);
        ctl_dq_t                     out = {NUM_MAX, NUM_MAX};

        TEST_ASSERT_TRUE(ctl_park(&in, &rotor, &out));

        ASSERT_NUM_WITHIN_AT(BOUND, g->d, out.d, at("row %u", (unsigned)i));
        ASSERT_NUM_WITHIN_AT(BOUND, g->q, out.q, at("row %u", (unsigned)i));
    }
}

void test_ctl_inverse_park_matches_golden(void)
{
    for (size_t i = 0; i < COUNT_OF(GOLDEN_FRAMES); i++) {
        const golden_frames_t *const g = &GOLDEN_FRAMES[i];
        const ctl_dq_t               in = {num_of(g->d), num_of(g->q)};
        const ctl_rotor_t            rotor = rotor_at(g->angle);
        ctl_ab_t                     out = {NUM_MAX, NUM_MAX};

        TEST_ASSERT_TRUE(ctl_inverse_park(&in, &rotor, &out));

        ASSERT_NUM_WITHIN_AT(BOUND, g->alpha, out.alpha, at("row %u", (unsigned)i));
        ASSERT_NUM_WITHIN_AT(BOUND, g->beta, out.beta, at("row %u", (unsigned)i));
    }
}

void test_ctl_clarke_does_not_see_a_common_part(void)
{
    const ctl_abc_t plain = {num_of(1.0), num_of(-2.5), num_of(1.5)};
    const ctl_abc_t lifted = {num_of(8.0), num_of(4.5), num_of(8.5)};
    ctl_ab_t        first;
    ctl_ab_t        second;

    (void)ctl_clarke(&plain, &first);
    (void)ctl_clarke(&lifted, &second);

    ASSERT_NUM_WITHIN(0.0, value_of(first.alpha), second.alpha);
    ASSERT_NUM_WITHIN(0.0, value_of(first.beta), second.beta);
}

void test_ctl_clarke_keeps_the_amplitude_of_a_three_phase_set(void)
{
    for (int i = 0; i < 24; i++) {
        const double    phi = TWO_PI * i / 24.0;
        const ctl_abc_t in = {num_of(2.0 * cos(phi)), num_of(2.0 * cos(phi - TWO_PI / 3.0)),
                              num_of(2.0 * cos(phi + TWO_PI / 3.0))};
        ctl_ab_t        out;

        (void)ctl_clarke(&in, &out);

        ASSERT_NUM_WITHIN_AT(1e-6, 2.0 * cos(phi), out.alpha, at("step %d", i)); /* rounding of inputs and of three sums */
        ASSERT_NUM_WITHIN_AT(1e-6, 2.0 * sin(phi), out.beta, at("step %d", i));
    }
}

void test_ctl_park_of_a_turning_vector_stands_still_on_q(void)
{
    for (uint32_t i = 0; i < 50U; i++) {
        const angle_t     angle = i * UINT32_C(98765432);
        const ctl_rotor_t rotor = rotor_at(angle);
        /* i_a = -I sin(theta): a current on +q turns a motor forwards */
        const ctl_ab_t in = {num_neg(num_mul(num_of(3.0), rotor.sine)), num_mul(num_of(3.0), rotor.cosine)};
        ctl_dq_t       out;

        (void)ctl_park(&in, &rotor, &out);

        ASSERT_NUM_WITHIN_AT(2e-6, 0.0, out.d, at("step %u", i)); /* 3 times the error of sine and cosine, twice */
        ASSERT_NUM_WITHIN_AT(2e-6, 3.0, out.q, at("step %u", i));
    }
}

void test_ctl_frames_there_and_back_give_the_phases_without_their_common_part(void)
{
    noise_t noise = {15U};
    for (uint32_t i = 0; i < 300U; i++) {
        const ctl_rotor_t rotor = rotor_at(noise_bits(&noise));
        const ctl_abc_t   in = {num_of(8.0 * noise_next(&noise)), num_of(8.0 * noise_next(&noise)),
                                num_of(8.0 * noise_next(&noise))};
        const double      common = (value_of(in.a) + value_of(in.b) + value_of(in.c)) / 3.0;
        ctl_ab_t          ab;
        ctl_dq_t          dq;
        ctl_abc_t         out;

        TEST_ASSERT_TRUE(ctl_clarke(&in, &ab));
        TEST_ASSERT_TRUE(ctl_park(&ab, &rotor, &dq));
        TEST_ASSERT_TRUE(ctl_inverse_park(&dq, &rotor, &ab));
        TEST_ASSERT_TRUE(ctl_inverse_clarke(&ab, &out));

        const double bound = per_numeric(4e-6, 4e-6); /* 4 times sin^2 + cos^2 - 1, and the roundings on the way */
        ASSERT_NUM_WITHIN_AT(bound, value_of(in.a) - common, out.a, at("turn %u", i));
        ASSERT_NUM_WITHIN_AT(bound, value_of(in.b) - common, out.b, at("turn %u", i));
        ASSERT_NUM_WITHIN_AT(bound, value_of(in.c) - common, out.c, at("turn %u", i));
    }
}

void test_ctl_clarke_replaces_each_component_that_is_not_finite_by_zero(void)
{
    for (size_t i = 0; i < COUNT_OF(NOT_FINITE); i++) {
        for (int which = 0; which < 3; which++) {
            ctl_abc_t in = {num_of(1.0), num_of(2.0), num_of(3.0)};
            ctl_abc_t clean = in;
            ctl_ab_t  out;
            ctl_ab_t  want;
            *((which == 0) ? &in.a : ((which == 1) ? &in.b : &in.c)) = NOT_FINITE[i];
            *((which == 0) ? &clean.a : ((which == 1) ? &clean.b : &clean.c)) = (num_t)0;

            TEST_ASSERT_FALSE(ctl_clarke(&in, &out));
            TEST_ASSERT_TRUE(ctl_clarke(&clean, &want));

            ASSERT_SAME_BITS(want, out);
        }
    }
}

void test_ctl_inverse_clarke_replaces_each_component_that_is_not_finite_by_zero(void)
{
    for (size_t i = 0; i < COUNT_OF(NOT_FINITE); i++) {
        const ctl_ab_t bad_alpha = {NOT_FINITE[i], num_of(2.0)};
        const ctl_ab_t bad_beta = {num_of(1.0), NOT_FINITE[i]};
        ctl_abc_t      out;

        TEST_ASSERT_FALSE(ctl_inverse_clarke(&bad_alpha, &out));
        ASSERT_NUM_WITHIN(0.0, 0.0, out.a);
        ASSERT_NUM_WITHIN(1e-6, sqrt(3.0), out.b);
        ASSERT_NUM_WITHIN(1e-6, -sqrt(3.0), out.c);
        TEST_ASSERT_FALSE(ctl_inverse_clarke(&bad_beta, &out));
        ASSERT_NUM_WITHIN(0.0, 1.0, out.a);
        ASSERT_NUM_WITHIN(0.0, -0.5, out.b);
        ASSERT_NUM_WITHIN(0.0, -0.5, out.c);
    }
}

void test_ctl_park_and_inverse_replace_each_component_that_is_not_finite_by_zero(void)
{
    const ctl_rotor_t good = {num_of(0.75), num_of(0.5)};
    for (size_t i = 0; i < COUNT_OF(NOT_FINITE); i++) {
        const ctl_ab_t    bad_alpha = {NOT_FINITE[i], num_of(2.0)};
        const ctl_ab_t    bad_beta = {num_of(4.0), NOT_FINITE[i]};
        const ctl_ab_t    fine = {num_of(4.0), num_of(2.0)};
        const ctl_dq_t    bad_d = {NOT_FINITE[i], num_of(2.0)};
        const ctl_dq_t    bad_q = {num_of(4.0), NOT_FINITE[i]};
        const ctl_dq_t    fine_dq = {num_of(4.0), num_of(2.0)};
        const ctl_rotor_t bad_sine = {NOT_FINITE[i], num_of(0.5)};
        const ctl_rotor_t bad_cosine = {num_of(0.75), NOT_FINITE[i]};
        ctl_dq_t          dq;
        ctl_ab_t          ab;

        TEST_ASSERT_FALSE(ctl_park(&bad_alpha, &good, &dq));
        ASSERT_NUM_WITHIN(0.0, 1.5, dq.d);
        ASSERT_NUM_WITHIN(0.0, 1.0, dq.q);
        TEST_ASSERT_FALSE(ctl_park(&bad_beta, &good, &dq));
        ASSERT_NUM_WITHIN(0.0, 2.0, dq.d);
        ASSERT_NUM_WITHIN(0.0, -3.0, dq.q);
        TEST_ASSERT_FALSE(ctl_park(&fine, &bad_sine, &dq));
        ASSERT_NUM_WITHIN(0.0, 2.0, dq.d);
        ASSERT_NUM_WITHIN(0.0, 1.0, dq.q);
        TEST_ASSERT_FALSE(ctl_park(&fine, &bad_cosine, &dq));
        ASSERT_NUM_WITHIN(0.0, 1.5, dq.d);
        ASSERT_NUM_WITHIN(0.0, -3.0, dq.q);

        TEST_ASSERT_FALSE(ctl_inverse_park(&bad_d, &good, &ab));
        ASSERT_NUM_WITHIN(0.0, -1.5, ab.alpha);
        ASSERT_NUM_WITHIN(0.0, 1.0, ab.beta);
        TEST_ASSERT_FALSE(ctl_inverse_park(&bad_q, &good, &ab));
        ASSERT_NUM_WITHIN(0.0, 2.0, ab.alpha);
        ASSERT_NUM_WITHIN(0.0, 3.0, ab.beta);
        TEST_ASSERT_FALSE(ctl_inverse_park(&fine_dq, &bad_sine, &ab));
        ASSERT_NUM_WITHIN(0.0, 2.0, ab.alpha);
        ASSERT_NUM_WITHIN(0.0, 1.0, ab.beta);
        TEST_ASSERT_FALSE(ctl_inverse_park(&fine_dq, &bad_cosine, &ab));
        ASSERT_NUM_WITHIN(0.0, -1.5, ab.alpha);
        ASSERT_NUM_WITHIN(0.0, 3.0, ab.beta);
    }
}

void test_ctl_park_cuts_a_sine_beyond_one(void)
{
    const ctl_rotor_t outside = {num_of(3.0), num_of(-7.0)};
    const ctl_ab_t    in = {num_of(4.0), num_of(2.0)};
    ctl_dq_t          out;

    TEST_ASSERT_TRUE(ctl_park(&in, &outside, &out));

    ASSERT_NUM_WITHIN(0.0, -2.0, out.d);
    ASSERT_NUM_WITHIN(0.0, -6.0, out.q);
}

void test_ctl_frames_of_anything_are_bounded(void)
{
    noise_t      noise = {16U};
    const double bound = 2.0 * num_max_value();
    for (uint32_t i = 0; i < 3000U; i++) {
        const ctl_abc_t   abc = {noise_nasty(&noise), noise_nasty(&noise), noise_nasty(&noise)};
        const ctl_ab_t    ab = {noise_nasty(&noise), noise_nasty(&noise)};
        const ctl_dq_t    dq = {noise_nasty(&noise), noise_nasty(&noise)};
        const ctl_rotor_t rotor = {noise_nasty(&noise), noise_nasty(&noise)};
        ctl_ab_t          out_ab;
        ctl_dq_t          out_dq;
        ctl_abc_t         out_abc;

        (void)ctl_clarke(&abc, &out_ab);
        ASSERT_BOUNDED_AT(bound, out_ab.alpha, at("turn %u", i));
        ASSERT_BOUNDED_AT(bound, out_ab.beta, at("turn %u", i));
        (void)ctl_inverse_clarke(&ab, &out_abc);
        ASSERT_BOUNDED_AT(bound, out_abc.a, at("turn %u", i));
        ASSERT_BOUNDED_AT(bound, out_abc.b, at("turn %u", i));
        ASSERT_BOUNDED_AT(bound, out_abc.c, at("turn %u", i));
        (void)ctl_park(&ab, &rotor, &out_dq);
        ASSERT_BOUNDED_AT(bound, out_dq.d, at("turn %u", i));
        ASSERT_BOUNDED_AT(bound, out_dq.q, at("turn %u", i));
        (void)ctl_inverse_park(&dq, &rotor, &out_ab);
        ASSERT_BOUNDED_AT(bound, out_ab.alpha, at("turn %u", i));
        ASSERT_BOUNDED_AT(bound, out_ab.beta, at("turn %u", i));
    }
}

/* ---- without looking ------------------------------------------------------------------------------------------------------ */

void test_ctl_frames_raw_are_the_same_for_numbers(void)
{
    noise_t noise = {25U};
    for (uint32_t i = 0; i < 500U; i++) {
        const ctl_abc_t   abc = {num_of(30.0 * noise_next(&noise)), num_of(30.0 * noise_next(&noise)),
                                 num_of(30.0 * noise_next(&noise))};
        const ctl_ab_t    ab = {abc.b, abc.c};
        const ctl_dq_t    dq = {abc.a, abc.c};
        const ctl_rotor_t r = rotor_at(noise_bits(&noise));
        ctl_ab_t          ab_want;
        ctl_abc_t         abc_want;
        ctl_dq_t          dq_want;

        const ctl_ab_t clarke = ctl_clarke_unchecked(abc);
        TEST_ASSERT_TRUE(ctl_clarke(&abc, &ab_want));
        ASSERT_SAME_BITS(ab_want, clarke);
        const ctl_abc_t back = ctl_inverse_clarke_unchecked(ab);
        TEST_ASSERT_TRUE(ctl_inverse_clarke(&ab, &abc_want));
        ASSERT_SAME_BITS(abc_want, back);
        const ctl_dq_t park = ctl_park_unchecked(ab, r);
        TEST_ASSERT_TRUE(ctl_park(&ab, &r, &dq_want));
        TEST_ASSERT_DOUBLE_WITHIN(BOUND, value_of(dq_want.d), value_of(park.d)); /* the other one cuts the sine to 1 */
        TEST_ASSERT_DOUBLE_WITHIN(BOUND, value_of(dq_want.q), value_of(park.q));
        const ctl_ab_t out = ctl_inverse_park_unchecked(dq, r);
        TEST_ASSERT_TRUE(ctl_inverse_park(&dq, &r, &ab_want));
        TEST_ASSERT_DOUBLE_WITHIN(BOUND, value_of(ab_want.alpha), value_of(out.alpha));
        TEST_ASSERT_DOUBLE_WITHIN(BOUND, value_of(ab_want.beta), value_of(out.beta));
    }
}
