/* control/numeric/tmu.h: the way through the chip's unit and the portable way keep the same contract. The unit is played by
 * the C library, correctly rounded: its own last bits are the chip's affair. */
#define EVENSPIN_TMU_MARKED
#include "tests/support/numeric.h"

#include "control/numeric/angle.h"
#include "control/numeric/num_math.h"

void setUp(void) {}
void tearDown(void) {}

static float largest_turns; /* of what the unit was asked for */

#ifdef CTL_HAS_TMU

float fpu_min(float a, float b) { return fminf(a, b); }
float fpu_max(float a, float b) { return fmaxf(a, b); }
float tmu_sin_turns(float x)
{
    largest_turns = fmaxf(largest_turns, fabsf(x));
    return (float)sin(TWO_PI * (double)x);
}
float tmu_cos_turns(float x)
{
    largest_turns = fmaxf(largest_turns, fabsf(x));
    return (float)cos(TWO_PI * (double)x);
}
float tmu_sqrt(float x)
{
    TEST_ASSERT_TRUE_MESSAGE((x > 0.0f) && (x <= NUM_MAX), "the unit takes positive numbers");
    return (float)sqrt((double)x);
}

#endif

void test_tmu_sincos_keeps_the_bound_of_angle_sincos_all_around(void)
{
    FLOAT_ONLY();
    double worst = 0.0;
    double apart = 0.0;
    largest_turns = 0.0f;
    for (uint32_t i = 0U; i < 20000U; i++) {
        const angle_t angle = i * UINT32_C(214753);
        const double  rad = (double)angle * (TWO_PI / TURN_STEPS);
        num_t         sine, cosine, sine_twin, cosine_twin;
        angle_sincos(angle, &sine, &cosine);
        angle_sincos_portable(angle, &sine_twin, &cosine_twin);
        worst = fmax(worst, fmax(fabs(value_of(sine) - sin(rad)), fabs(value_of(cosine) - cos(rad))));
        apart = fmax(apart, fmax(fabs(value_of(sine) - value_of(sine_twin)), fabs(value_of(cosine) - value_of(cosine_twin))));
    }

    /* half of 2^-23 of half a turn is 9.4e-8 rad, and half a step of the result 3e-8; the header adds the unit's own error */
    TEST_ASSERT_DOUBLE_WITHIN(0.3e-7, 1.0e-7, worst);
    TEST_ASSERT_TRUE(apart <= 3.0e-7);
    TEST_ASSERT_TRUE((largest_turns <= 0.5f) && (largest_turns > 0.4999f));
}

void test_tmu_sincos_of_a_lead_keeps_the_bound_within_a_turn_either_way(void)
{
    FLOAT_ONLY();
    largest_turns = 0.0f;
    for (uint32_t i = 0U; i < 20000U; i++) {
        const angle_t angle = i * UINT32_C(214753);
        const num_t   lead = num_of(0.49 * sin((double)i));
        const double  rad = ((double)angle * (TWO_PI / TURN_STEPS)) + (TWO_PI * value_of(lead));
        num_t         sine, cosine;
        angle_sincos_lead(angle, lead, &sine, &cosine);

        /* two roundings of up to a turn, 2^-25 each, and that of the result */
        ASSERT_NUM_WITHIN_AT(4.1e-7, sin(rad), sine, at("angle %u", (unsigned)i));
        ASSERT_NUM_WITHIN_AT(4.1e-7, cos(rad), cosine, at("angle %u", (unsigned)i));
    }
    TEST_ASSERT_TRUE((largest_turns <= 1.0f) && (largest_turns > 0.9f));
}

void test_fpu_choices_are_the_portable_ones_for_numbers(void)
{
    FLOAT_ONLY();
    static const double SOME[] = {-1.0e12, -3.5, -1.0, -0.0, 0.0, 1.0e-12, 1.0, 2.5, 1.0e12};
    for (size_t i = 0; i < COUNT_OF(SOME); i++) {
        for (size_t k = 0; k < COUNT_OF(SOME); k++) {
            const num_t a = num_of(SOME[i]);
            const num_t b = num_of(SOME[k]);
            TEST_ASSERT_TRUE(num_min(a, b) == ((a < b) ? a : b));
            TEST_ASSERT_TRUE(num_max(a, b) == ((a > b) ? a : b));
            TEST_ASSERT_TRUE(num_clamp(a, num_of(-2.0), num_of(1.5)) == ((a > -2.0f) ? ((a < 1.5f) ? a : 1.5f) : -2.0f));
        }
        TEST_ASSERT_TRUE(num_abs(num_of(SOME[i])) == fabsf((float)SOME[i]));
    }
}

void test_tmu_sincos_at_the_quarters_is_exact(void)
{
    static const double SINE[] = {0.0, 1.0, 0.0, -1.0};
    for (uint16_t quarter = 0U; quarter < 4U; quarter++) {
        num_t sine, cosine;
        angle_sincos(ANGLE_QUARTER * quarter, &sine, &cosine);

        ASSERT_NUM_WITHIN_AT(1e-15, SINE[quarter], sine, at("%u quarters", quarter)); /* the fake's 2 pi is rounded */
        ASSERT_NUM_WITHIN_AT(1e-15, SINE[(quarter + 1U) % 4U], cosine, at("%u quarters", quarter));
    }
}

void test_tmu_sqrt_agrees_with_the_portable_one(void)
{
    FLOAT_ONLY();
    for (double x = 1.2e-38; x < 1.0e12; x *= 1.37) {
        const num_t  given = num_of(x);
        const double want = sqrt(value_of(given));

        ASSERT_DOUBLE_WITHIN_AT(2e-7 * want, want, value_of(num_sqrt(given)), at("%g", x));
        ASSERT_DOUBLE_WITHIN_AT(2e-7 * want, want, value_of(num_sqrt_portable(given)), at("%g", x));
    }
}

void test_tmu_sqrt_of_what_has_no_root_is_that_of_the_portable_one(void)
{
    FLOAT_ONLY();
    static const float ODD[] = {0.0f, -0.0f, -1.0f, NAN, -INFINITY, 1e-42f, FLT_MIN, INFINITY, FLT_MAX, 1.1e12f, 1.0e12f};
    for (size_t i = 0; i < COUNT_OF(ODD); i++) {
        const double twin = value_of(num_sqrt_portable((num_t)ODD[i]));

        ASSERT_DOUBLE_WITHIN_AT(4e-7 * twin, twin, value_of(num_sqrt((num_t)ODD[i])), at("case %u", (unsigned)i));
    }
    TEST_ASSERT_TRUE(num_sqrt((num_t)ODD[3]) == (num_t)0);
    TEST_ASSERT_DOUBLE_WITHIN(0.2, 1e6, value_of(num_sqrt((num_t)ODD[7])));
}

void test_tmu_is_not_used_in_fixed_point(void)
{
    FIXED_ONLY();
    num_t sine, cosine, sine_twin, cosine_twin;
    angle_sincos(UINT32_C(123456789), &sine, &cosine);
    angle_sincos_portable(UINT32_C(123456789), &sine_twin, &cosine_twin);

    TEST_ASSERT_TRUE((sine == sine_twin) && (cosine == cosine_twin));
    TEST_ASSERT_TRUE(num_sqrt(num_of(2.0)) == num_sqrt_portable(num_of(2.0)));
}
