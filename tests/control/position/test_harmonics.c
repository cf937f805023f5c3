/* control/position/harmonics.c: sines over the angle, whole cycles per turn and others, over very many turns. */
#include "tests/support/numeric.h"

#include "control/position/harmonics.h"
#include "tests/control/golden/harmonics.h"

static ctl_harmonics_t one_line(uint32_t cycles_q20, double amplitude, angle_t phase)
{
    const ctl_harmonics_t h = {1U, {{cycles_q20, num_of(amplitude), phase}}};
    return h;
}

static double torque(const ctl_harmonics_t *h, ctl_position_t x) { return value_of(ctl_harmonics(h, x)); }

void setUp(void) {}
void tearDown(void) {}

/* a sine within 2.5e-7 of the amplitude, and its phase cut to 2^-32 of a cycle */
void test_ctl_harmonics_matches_golden_over_two_billion_turns_both_ways(void)
{
    for (size_t k = 0; k < COUNT_OF(GOLDEN_HARMONICS); k++) {
        const golden_harmonics_t *const g = &GOLDEN_HARMONICS[k];
        const ctl_harmonics_t           h = one_line(g->cycles_q20, g->amplitude, g->phase);
        const ctl_position_t            x = (ctl_position_t)(((uint64_t)g->turn << 32) + g->part);

        ASSERT_DOUBLE_WITHIN_AT(4e-7 * g->amplitude + FIXED_STEP, g->torque, torque(&h, x), at("row %u", (unsigned)k));
    }
}

void test_ctl_harmonics_whole_cycles_repeat_every_turn_to_the_bit(void)
{
    const ctl_harmonics_t h = one_line(ctl_cycles_q20(24.0f), 0.14, 123456789U);
    noise_t               noise = {107U};
    for (int k = 0; k < 500; k++) {
        const ctl_position_t x = (ctl_position_t)noise_bits(&noise);
        const ctl_position_t away = ((ctl_position_t)noise_pick(&noise, 100000U) - 50000) * CTL_ONE_TURN;
        TEST_ASSERT_EQUAL_DOUBLE(torque(&h, x), torque(&h, x + away));
    }
}

/* 24.008 against 24: after 125 turns a whole cycle more, after 62.5 the opposite sign */
void test_ctl_harmonics_broken_cycles_drift_against_the_turn(void)
{
    const ctl_harmonics_t h = one_line(24U * 1048576U + 8192U, 1.0, 0U); /* 24 + 1/128 */
    const ctl_position_t  x = CTL_ONE_TURN / 96;                         /* a quarter cycle */

    TEST_ASSERT_DOUBLE_WITHIN(1e-3, 1.0, torque(&h, x));
    TEST_ASSERT_DOUBLE_WITHIN(1e-3, -1.0, torque(&h, x + 64 * CTL_ONE_TURN));
    TEST_ASSERT_DOUBLE_WITHIN(1e-3, 1.0, torque(&h, x + 128 * CTL_ONE_TURN));
    TEST_ASSERT_DOUBLE_WITHIN(1e-3, -1.0, torque(&h, x - 64 * CTL_ONE_TURN));
}

void test_ctl_harmonics_has_no_seam_at_position_zero(void)
{
    const ctl_harmonics_t h = one_line(ctl_cycles_q20(24.008f), 1.0, 0x30000000U);
    for (ctl_position_t x = -2000000; x < 2000000; x += 40000) { /* 40000 2^-32 turns of 24 cycles: 0.0014 rad */
        ASSERT_DOUBLE_WITHIN_AT(0.0015, torque(&h, x), torque(&h, x + 40000), at("at %d", (int)x));
    }
}

void test_ctl_harmonics_lines_add_up(void)
{
    ctl_harmonics_t all = {CTL_HARMONICS_MAX, {{0U, (num_t)0, 0U}}};
    for (uint16_t i = 0U; i < CTL_HARMONICS_MAX; i++) {
        const ctl_line_t l = {(i + 1U) * 1300000U, num_of(0.25 * (i + 1.0)), i * 700000000U};
        all.line[i] = l;
    }
    for (ctl_position_t x = -3 * CTL_ONE_TURN; x < 3 * CTL_ONE_TURN; x += CTL_ONE_TURN / 7) {
        double sum = 0.0;
        for (uint16_t i = 0U; i < CTL_HARMONICS_MAX; i++) {
            const ctl_harmonics_t single = {1U, {all.line[i]}};
            sum += torque(&single, x);
        }
        TEST_ASSERT_DOUBLE_WITHIN(per_numeric(2e-6, 7.0 * FIXED_STEP), sum, torque(&all, x));
    }
}

void test_ctl_harmonics_without_lines_is_nothing(void)
{
    ctl_harmonics_t h = one_line(1048576U, 5.0, 0x40000000U);
    h.lines = 0U;

    TEST_ASSERT_EQUAL_DOUBLE(0.0, torque(&h, 12345));
}

void test_ctl_harmonics_line_of_zero_cycles_is_a_constant(void)
{
    const ctl_harmonics_t h = one_line(0U, 2.0, ANGLE_QUARTER);
    for (ctl_position_t x = -5 * CTL_ONE_TURN; x < 5 * CTL_ONE_TURN; x += CTL_ONE_TURN / 3) {
        TEST_ASSERT_DOUBLE_WITHIN(1e-6, 2.0, torque(&h, x));
    }
}

void test_ctl_harmonics_of_any_position_is_bounded_by_its_amplitude(void)
{
    const ctl_harmonics_t h = one_line(UINT32_MAX, 1.5, UINT32_MAX);
    const ctl_position_t  where[] = {INT64_MIN, INT64_MAX, -1, 0, 1};
    for (size_t k = 0; k < COUNT_OF(where); k++) {
        ASSERT_BOUNDED_AT(1.5 * 1.000001, ctl_harmonics(&h, where[k]), at("position %u", (unsigned)k));
    }
}

/* ---- cycles ------------------------------------------------------------------------------------------------------------ */

void test_ctl_cycles_q20_is_the_nearest_whole_number(void)
{
    const struct {
        float    cycles;
        uint32_t q20;
    } row[] = {{1.0f, 1048576U}, {24.0f, 25165824U}, {0.5f, 524288U},        {4.0625f, 4259840U},   {9.5367431640625e-7f, 1U},
               {4.0e-7f, 0U},    {6.0e-7f, 1U},      {2048.0f, 2147483648U}, {4094.0f, 4292870144U}};
    for (size_t k = 0; k < COUNT_OF(row); k++) {
        TEST_ASSERT_EQUAL_UINT32_MESSAGE(row[k].q20, ctl_cycles_q20(row[k].cycles), at("%g", (double)row[k].cycles));
    }
}

void test_ctl_cycles_q20_is_cut_to_its_range(void)
{
    const float high[] = {4095.0f, 4096.0f, 1e30f, INFINITY};
    const float low[] = {0.0f, -0.0f, -1.0f, -INFINITY, NAN};
    for (size_t k = 0; k < COUNT_OF(high); k++) {
        TEST_ASSERT_EQUAL_UINT32(4095U * 1048576U, ctl_cycles_q20(high[k]));
    }
    for (size_t k = 0; k < COUNT_OF(low); k++) {
        TEST_ASSERT_EQUAL_UINT32(0U, ctl_cycles_q20(low[k]));
    }
}

/* ---- refused ------------------------------------------------------------------------------------------------------------ */

void test_ctl_harmonics_check_without_parameters_is_null(void) { ASSERT_DIAG(CTL_ERR_NULL, 0U, 0.0, ctl_harmonics_check(NULL)); }

void test_ctl_harmonics_check_rejects_too_many_lines(void)
{
    ctl_harmonics_t h = {CTL_HARMONICS_MAX, {{0U, (num_t)0, 0U}}};
    TEST_ASSERT_EQUAL(CTL_OK, ctl_harmonics_check(&h).status);
    h.lines = CTL_HARMONICS_MAX + 1U;

    const ctl_diag_t got = ctl_harmonics_check(&h);

    TEST_ASSERT_EQUAL(CTL_ERR_RANGE, got.status);
    TEST_ASSERT_EQUAL(CTL_HARMONICS_LINES, got.field);
    ASSERT_NUM_WITHIN(1e-6, 7.0, got.given);
}

void test_ctl_harmonics_check_rejects_an_amplitude_that_is_not_a_number(void)
{
    for (size_t k = 0; k < COUNT_OF(NOT_FINITE); k++) {
        ctl_harmonics_t h = {3U, {{1U, (num_t)0, 0U}}};
        h.line[2].amplitude = NOT_FINITE[k];
        h.line[3].amplitude = NOT_FINITE[k];

        const ctl_diag_t got = ctl_harmonics_check(&h);

        TEST_ASSERT_EQUAL(CTL_ERR_RANGE, got.status);
        TEST_ASSERT_EQUAL(CTL_HARMONICS_AMPLITUDE, got.field);
        h.lines = 2U; /* what is not used is not looked at */
        TEST_ASSERT_EQUAL(CTL_OK, ctl_harmonics_check(&h).status);
    }
}
