/* control/numeric/angle.c: binary angles, radians, sine and cosine. */
#include "tests/support/numeric.h"

#include "control/numeric/angle.h"
#include "tests/control/golden/angle.h"

#define SINCOS_BOUND per_numeric(1.2e-7, 2.5e-7) /* header of angle.h */

void setUp(void) {}
void tearDown(void) {}

void test_angle_sincos_matches_golden(void)
{
    for (size_t i = 0; i < COUNT_OF(GOLDEN_SINCOS); i++) {
        num_t sine = NUM_MAX;
        num_t cosine = NUM_MAX;

        angle_sincos(GOLDEN_SINCOS[i].angle, &sine, &cosine);

        ASSERT_NUM_WITHIN_AT(SINCOS_BOUND, GOLDEN_SINCOS[i].sine, sine, at("sine, row %u", (unsigned)i));
        ASSERT_NUM_WITHIN_AT(SINCOS_BOUND, GOLDEN_SINCOS[i].cosine, cosine, at("cosine, row %u", (unsigned)i));
    }
}

void test_angle_sincos_keeps_its_bound_all_around(void)
{
    double worst = 0.0;
    for (uint32_t i = 0; i < 20000U; i++) {
        const angle_t angle = i * UINT32_C(214753);
        const double  rad = (double)angle * (TWO_PI / TURN_STEPS);
        num_t         sine;
        num_t         cosine;
        angle_sincos(angle, &sine, &cosine);
        worst = fmax(worst, fmax(fabs(value_of(sine) - sin(rad)), fabs(value_of(cosine) - cos(rad))));
    }

    TEST_ASSERT_DOUBLE_WITHIN(0.45 * SINCOS_BOUND, 0.55 * SINCOS_BOUND, worst);
}

void test_angle_sincos_at_the_quarters_is_exact(void)
{
    static const double SINE[] = {0.0, 1.0, 0.0, -1.0};
    for (uint16_t quarter = 0; quarter < 4U; quarter++) {
        num_t sine;
        num_t cosine;

        angle_sincos(ANGLE_QUARTER * quarter, &sine, &cosine);

        ASSERT_NUM_WITHIN_AT(0.0, SINE[quarter], sine, at("%u quarters", quarter));
        ASSERT_NUM_WITHIN_AT(0.0, SINE[(quarter + 1U) % 4U], cosine, at("%u quarters", quarter));
    }
}

void test_angle_sincos_of_opposite_angles_is_mirrored(void)
{
    noise_t noise = {5U};
    for (uint32_t i = 0; i < 500U; i++) {
        const angle_t angle = noise_bits(&noise);
        num_t         s0, c0, s1, c1, s2, c2;

        angle_sincos(angle, &s0, &c0);
        angle_sincos(angle + (2U * ANGLE_QUARTER), &s1, &c1);
        angle_sincos(0U - angle, &s2, &c2);

        TEST_ASSERT_TRUE((s1 == num_neg(s0)) && (c1 == num_neg(c0))); /* half a turn on: exact in both numerics */
        /* mirrored: fixed point cuts the angle downwards to its step, a quarter turn in 2^24 */
        ASSERT_NUM_WITHIN(per_numeric(0.0, 3.0 * FIXED_STEP), -value_of(s0), s2);
        ASSERT_NUM_WITHIN(per_numeric(0.0, 3.0 * FIXED_STEP), value_of(c0), c2);
    }
}

void test_angle_sincos_never_leaves_the_range_of_a_sine(void)
{
    for (uint32_t i = 0; i < 4000U; i++) {
        num_t sine;
        num_t cosine;

        angle_sincos((ANGLE_QUARTER * (i % 4U)) + (i - 2000U), &sine, &cosine); /* close to the peaks */

        ASSERT_BOUNDED_AT(1.0 + SINCOS_BOUND, sine, at("turn %u", i));
        ASSERT_BOUNDED_AT(1.0 + SINCOS_BOUND, cosine, at("turn %u", i));
    }
}

void test_angle_to_rad_matches_golden(void)
{
    /* float: half a step of 2 pi; fixed: cut to its step, twice */
    const double bound = per_numeric(6.0e-7, 3.0 * FIXED_STEP);
    for (size_t i = 0; i < COUNT_OF(GOLDEN_SINCOS); i++) {
        const angle_t angle = GOLDEN_SINCOS[i].angle;

        ASSERT_NUM_WITHIN_AT(bound, GOLDEN_SINCOS[i].rad, angle_to_rad(angle), at("row %u", (unsigned)i));
        ASSERT_NUM_WITHIN_AT(bound, GOLDEN_SINCOS[i].rad_signed, angle_to_rad_signed(angle), at("row %u", (unsigned)i));
    }
}

void test_angle_to_rad_stays_within_one_turn(void)
{
    const double  rounding = per_numeric(3e-7, FIXED_STEP);
    const angle_t edge[] = {0U, 1U, UINT32_MAX, 2U * ANGLE_QUARTER, (2U * ANGLE_QUARTER) - 1U, (2U * ANGLE_QUARTER) + 1U};
    for (size_t i = 0; i < COUNT_OF(edge); i++) {
        const double rad = value_of(angle_to_rad(edge[i]));

        TEST_ASSERT_TRUE((rad >= 0.0) && (rad <= TWO_PI + rounding));
        ASSERT_BOUNDED_AT((TWO_PI / 2.0) + rounding, angle_to_rad_signed(edge[i]), at("edge %u", (unsigned)i));
    }
}

/* The header's promise: 1.5e-9 rad, and in float 2^-24 of the angle; the product rounds once more. */
static double from_rad_bound(double rad) { return 1.6e-9 + per_numeric(2.0 * fabs(rad) / 16777216.0, fabs(rad) * 1e-9); }

static double distance_rad(angle_t angle, double rad)
{
    const double turns = ((double)angle / TURN_STEPS) - (rad / TWO_PI);
    return (turns - rint(turns)) * TWO_PI;
}

void test_angle_from_rad_matches_golden(void)
{
    for (size_t i = 0; i < COUNT_OF(GOLDEN_FROM_RAD); i++) {
        const double  rad = GOLDEN_FROM_RAD[i].rad;
        const angle_t got = angle_from_rad(num_of(rad));
        const double  error = (double)(int32_t)(got - GOLDEN_FROM_RAD[i].angle) * (TWO_PI / TURN_STEPS);

        ASSERT_DOUBLE_WITHIN_AT(from_rad_bound(rad), 0.0, error, at("%g rad", rad));
    }
}

void test_angle_from_rad_is_as_fine_for_small_angles_backwards_as_forwards(void)
{
    for (double size = 1e-8; size < 1.0; size *= 1.07) {
        const double forwards = value_of(num_of(size));

        ASSERT_DOUBLE_WITHIN_AT(from_rad_bound(size), 0.0, distance_rad(angle_from_rad(num_of(size)), forwards),
                                at("%g rad", size));
        ASSERT_DOUBLE_WITHIN_AT(from_rad_bound(size), 0.0, distance_rad(angle_from_rad(num_neg(num_of(size))), -forwards),
                                at("-%g rad", size));
    }
}

void test_angle_from_rad_keeps_its_bound_over_its_range(void)
{
    for (double rad = -100.0; rad <= 100.0; rad += 0.0193) {
        const double given = value_of(num_of(rad));

        ASSERT_DOUBLE_WITHIN_AT(from_rad_bound(rad), 0.0, distance_rad(angle_from_rad(num_of(rad)), given), at("%g rad", rad));
    }
}

void test_angle_from_rad_of_half_a_turn_is_half_a_turn_from_both_sides(void)
{
    const double half = TWO_PI / 2.0;

    TEST_ASSERT_DOUBLE_WITHIN(from_rad_bound(half), 0.0, distance_rad(angle_from_rad(num_of(half)), value_of(num_of(half))));
    TEST_ASSERT_DOUBLE_WITHIN(from_rad_bound(half), 0.0, distance_rad(angle_from_rad(num_of(-half)), value_of(num_of(-half))));
}

void test_angle_from_rad_and_back_is_the_same_angle(void)
{
    noise_t noise = {6U};
    for (uint32_t i = 0; i < 500U; i++) {
        const angle_t angle = noise_bits(&noise);
        const angle_t there = angle_from_rad(angle_to_rad(angle));
        const angle_t there_signed = angle_from_rad(angle_to_rad_signed(angle));

        /* two roundings of up to 2 pi in float, of a step in fixed point */
        const double bound = per_numeric(1.5e-6, 4.0 * FIXED_STEP);
        TEST_ASSERT_DOUBLE_WITHIN(bound, 0.0, (double)(int32_t)(there - angle) * (TWO_PI / TURN_STEPS));
        TEST_ASSERT_DOUBLE_WITHIN(bound, 0.0, (double)(int32_t)(there_signed - angle) * (TWO_PI / TURN_STEPS));
    }
}

void test_angle_from_rad_takes_both_ends_of_its_range(void)
{
    TEST_ASSERT_DOUBLE_WITHIN(from_rad_bound(100.0), 0.0, distance_rad(angle_from_rad(num_of(100.0)), 100.0));
    TEST_ASSERT_DOUBLE_WITHIN(from_rad_bound(100.0), 0.0, distance_rad(angle_from_rad(num_of(-100.0)), -100.0));
}

void test_angle_from_rad_beyond_its_range_is_zero(void)
{
    TEST_ASSERT_EQUAL_UINT32(0U, angle_from_rad(num_of(100.5)));
    TEST_ASSERT_EQUAL_UINT32(0U, angle_from_rad(num_of(-100.5)));
    TEST_ASSERT_EQUAL_UINT32(0U, angle_from_rad(NUM_MAX));
    TEST_ASSERT_EQUAL_UINT32(0U, angle_from_rad(-NUM_MAX));
    for (size_t i = 0; i < COUNT_OF(NOT_FINITE); i++) {
        TEST_ASSERT_EQUAL_UINT32_MESSAGE(0U, angle_from_rad(NOT_FINITE[i]), at("case %u", (unsigned)i));
    }
}

/* ---- the short form ------------------------------------------------------------------------------------------------- */

void test_angle_from_rad_short_keeps_its_bound_within_half_a_turn(void)
{
    for (double size = 1e-8; size < 3.1415; size *= 1.03) {
        for (int sign = -1; sign <= 1; sign += 2) {
            const double given = value_of(num_of(sign * size));

            ASSERT_DOUBLE_WITHIN_AT(from_rad_bound(size), 0.0, distance_rad(angle_step_from_rad(num_of(sign * size)), given),
                                    at("%g rad", given));
        }
    }
}

/* The cut is 2e-7 rad inside of half a turn, so that no rounding reaches 2^31 steps; float rounds it once more. */
#define CUT_BOUND per_numeric(4e-7, 3e-7)

void test_angle_from_rad_short_beyond_half_a_turn_is_half_a_turn(void)
{
    static const double BEYOND[] = {3.14159265, 3.1416, 4.0, 50.0, 127.0, 1e30};
    const double        half = TWO_PI / 2.0;
    for (size_t i = 0; i < COUNT_OF(BEYOND); i++) {
        TEST_ASSERT_DOUBLE_WITHIN(CUT_BOUND, half, value_of(angle_to_rad_signed(angle_step_from_rad(num_of(BEYOND[i])))));
        TEST_ASSERT_DOUBLE_WITHIN(CUT_BOUND, -half, value_of(angle_to_rad_signed(angle_step_from_rad(num_of(-BEYOND[i])))));
    }
}

void test_angle_from_rad_short_of_anything_is_an_angle(void)
{
    const double half = TWO_PI / 2.0;
#ifdef EVENSPIN_FIXED
    TEST_ASSERT_DOUBLE_WITHIN(CUT_BOUND, -half, value_of(angle_to_rad_signed(angle_step_from_rad(INT32_MIN))));
#else
    TEST_ASSERT_EQUAL_UINT32(0U, angle_step_from_rad(NAN));
    TEST_ASSERT_DOUBLE_WITHIN(CUT_BOUND, half, value_of(angle_to_rad_signed(angle_step_from_rad(INFINITY))));
    TEST_ASSERT_DOUBLE_WITHIN(CUT_BOUND, -half, value_of(angle_to_rad_signed(angle_step_from_rad(-INFINITY))));
#endif
    TEST_ASSERT_EQUAL_UINT32(0U, angle_step_from_rad((num_t)0));
}

/* ---- without looking, sizes, turns ------------------------------------------------------------------------------------ */

void test_angle_raw_forms_are_the_same_within_their_range(void)
{
    noise_t noise = {8U};
    for (uint32_t i = 0; i < 1000U; i++) {
        const num_t far = num_of(180.0 * noise_next(&noise));
        const num_t near = num_of(6.0 * noise_next(&noise));

        TEST_ASSERT_EQUAL_UINT32(angle_from_rad(far), angle_from_rad_unchecked(far));
        TEST_ASSERT_EQUAL_UINT32(angle_step_from_rad(near), angle_step_from_rad_unchecked(near));
    }
}

void test_angle_from_rad_short_raw_of_what_is_not_a_number_is_half_a_turn_back(void)
{
    FLOAT_ONLY();
    TEST_ASSERT_DOUBLE_WITHIN(CUT_BOUND, -TWO_PI / 2.0,
                              value_of(angle_to_rad_signed(angle_step_from_rad_unchecked(NOT_FINITE[0]))));
}

void test_angle_size_is_the_shortest_way(void)
{
    TEST_ASSERT_EQUAL_UINT32(0U, angle_size(0U));
    TEST_ASSERT_EQUAL_UINT32(5U, angle_size(5U));
    TEST_ASSERT_EQUAL_UINT32(5U, angle_size(0U - 5U));
    TEST_ASSERT_EQUAL_UINT32(UINT32_C(0x80000000), angle_size(UINT32_C(0x80000000)));
    TEST_ASSERT_EQUAL_UINT32(UINT32_C(0x7FFFFFFF), angle_size(UINT32_C(0x80000001)));
}

void test_angle_to_turns_is_the_part_of_a_turn(void)
{
    noise_t noise = {7U};
    for (uint32_t i = 0; i < 500U; i++) {
        const angle_t angle = noise_bits(&noise);

        ASSERT_NUM_WITHIN_AT(per_numeric(1.0 / 33554432.0, FIXED_STEP), (double)angle / TURN_STEPS, angle_to_turns(angle),
                             at("turn %u", i));
    }
}

void test_angle_from_turns_short_keeps_its_bound_and_cuts_at_half_a_turn(void)
{
    for (double turns = -0.5; turns < 0.5; turns += 0.00390625) { /* exact in both numerics */
        TEST_ASSERT_EQUAL_UINT32((uint32_t)(int32_t)(turns * TURN_STEPS), angle_step_from_turns(num_of(turns)));
    }
    /* the largest float below a half is 2^-25 below it; fixed point is cut one step and some below */
    TEST_ASSERT_UINT32_WITHIN(per_numeric(130, 1000), UINT32_C(0x7FFFFFFF), angle_step_from_turns(num_of(0.7)));
    TEST_ASSERT_EQUAL_UINT32(UINT32_C(0x80000000), angle_step_from_turns(num_of(-0.7)));
}

void test_angle_sincos_lead_is_that_of_the_sum_of_both(void)
{
    for (uint32_t i = 0U; i < 5000U; i++) {
        const angle_t angle = i * UINT32_C(858993);
        const num_t   lead = num_of(0.45 * sin((double)i));
        const double  rad = ((double)angle * (TWO_PI / TURN_STEPS)) + (TWO_PI * value_of(lead));
        num_t         sine, cosine;
        angle_sincos_lead(angle, lead, &sine, &cosine);

        /* that of angle_sincos, and the lead cut to a step of 2^-24 turns (fixed) or of 2^-26 (float) */
        ASSERT_NUM_WITHIN_AT(per_numeric(2e-7, 6.5e-7), sin(rad), sine, at("angle %u", (unsigned)i));
        ASSERT_NUM_WITHIN_AT(per_numeric(2e-7, 6.5e-7), cos(rad), cosine, at("angle %u", (unsigned)i));
    }
}
