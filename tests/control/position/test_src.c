/* control/position/src.c: the low-pass of the way, the delay of the way, and the two in a loop. */
#include "tests/support/numeric.h"

#include "control/position/src.h"
#include "tests/control/golden/src.h"

#define CELLS 64U
#define STEP (UINT32_C(0x80000000) / (CELLS / 2U))
#define SPEED 2.0

static num_t     memory[4000];
static ctl_src_t src;

static ctl_src_params_t valid_params(void) /* W T / 2 = 1/4 at the speed 2 */
{
    const ctl_src_params_t p = {.omega_half_ts = num_of(0.125), .lambda = 11U * STEP, .limit = num_of(50.0)};
    return p;
}

static void start_with(const ctl_src_params_t *p, uint16_t cells)
{
    TEST_ASSERT_EQUAL(CTL_OK, ctl_src_init(&src, p, memory, cells).status);
}

static double step(angle_t theta, double speed, double err)
{
    return value_of(ctl_src_step(&src, theta, num_of(speed), num_of(err)));
}

void setUp(void)
{
    const ctl_src_params_t p = valid_params();
    start_with(&p, CELLS);
}
void tearDown(void) {}

/* ---- the filter ----------------------------------------------------------------------------------------------------------- */

void test_ctl_src_filter_matches_golden(void)
{
    for (size_t i = 0; i < COUNT_OF(GOLDEN_SRC_FILTER); i++) {
        const golden_src_filter_t *const g = &GOLDEN_SRC_FILTER[i];
        const ctl_src_filter_t           f = ctl_src_filter(num_of(g->k));
        const double                     tolerance = per_numeric(5e-7, 4.0 * FIXED_STEP);

        ASSERT_NUM_WITHIN_AT(tolerance, g->b0, f.b0, at("k %g", g->k));
        ASSERT_NUM_WITHIN_AT(tolerance, g->a1, f.a1, at("k %g", g->k));
        ASSERT_NUM_WITHIN_AT(tolerance, g->a2, f.a2, at("k %g", g->k));
    }
}

void test_ctl_src_filter_lets_a_constant_through(void)
{
    for (double k = 0.01; k <= 1.0; k += 0.03) {
        const ctl_src_filter_t f = ctl_src_filter(num_of(k));
        const double           sum = 1.0 + value_of(f.a1) + value_of(f.a2);
        TEST_ASSERT_DOUBLE_WITHIN(per_numeric(1e-6, 10.0 * FIXED_STEP), sum, 4.0 * value_of(f.b0));
    }
}

void test_ctl_src_filter_is_cut_to_its_range(void)
{
    const ctl_src_filter_t one = ctl_src_filter(num_of(1.0));
    const ctl_src_filter_t zero = ctl_src_filter((num_t)0);
    const double           high[] = {1.5, 100.0};
    for (size_t i = 0; i < COUNT_OF(high); i++) {
        const ctl_src_filter_t f = ctl_src_filter(num_of(high[i]));
        ASSERT_SAME_BITS(one, f);
    }
    const ctl_src_filter_t below = ctl_src_filter(num_of(-1.0));
    ASSERT_SAME_BITS(zero, below);
    for (size_t i = 0; i < COUNT_OF(NASTY); i++) {
        const ctl_src_filter_t f = ctl_src_filter(NASTY[i]);
        ASSERT_BOUNDED_AT(0.3, f.b0, at("value %u", (unsigned)i));
        ASSERT_BOUNDED_AT(2.001, f.a1, at("value %u", (unsigned)i));
        ASSERT_BOUNDED_AT(1.001, f.a2, at("value %u", (unsigned)i));
    }
}

/* ---- the loop at constant speed ---------------------------------------------------------------------------------------------- */

/* a cell per sample: the grid is a delay of whole samples and the whole controller one fraction */
static void assert_golden(angle_t one, double speed)
{
    noise_t noise = {81U};
    (void)step(0U - one, speed, 0.0); /* a point is written when it is reached: from somewhere */
    for (uint32_t k = 0U; k < COUNT_OF(GOLDEN_SRC_Y); k++) {
        const double y = step(k * one, speed, noise_next(&noise));
        ASSERT_DOUBLE_WITHIN_AT(per_numeric(5e-6, 1e-5), GOLDEN_SRC_Y[k], y, at("sample %u", (unsigned)k));
    }
}

void test_ctl_src_matches_golden_forwards(void) { assert_golden(STEP, SPEED); }

void test_ctl_src_matches_golden_backwards(void) { assert_golden((angle_t)(0U - STEP), -SPEED); }

/* amplitude of the answer to sin(order theta) in the memory, the loop open: the memory is restored in every sample */
static double gain_at(double order, double speed, uint32_t samples_per_turn)
{
    enum { WAVE = 1000 };
    static num_t  wave[WAVE];
    const angle_t one = (angle_t)(TURN_STEPS / samples_per_turn);
    double        i = 0.0;
    double        q = 0.0;
    for (int k = 0; k < WAVE; k++) {
        wave[k] = num_of(sin(order * TWO_PI * k / WAVE));
    }
    for (uint32_t k = 0U; k < 2U * samples_per_turn; k++) {
        (void)memcpy(memory, wave, sizeof wave);
        const double y = step(k * one, speed, 0.0);
        if (k >= samples_per_turn) {
            i += 2.0 / samples_per_turn * y * sin(order * TWO_PI * k / samples_per_turn);
            q += 2.0 / samples_per_turn * y * cos(order * TWO_PI * k / samples_per_turn);
        }
    }
    return hypot(i, q);
}

/* |Q| = 1/sqrt(2) at the corner, which lies at a fixed order whatever the speed */
void test_ctl_src_corner_is_fixed_over_the_way(void)
{
    const uint32_t per_turn[] = {2000U, 8000U};
    for (size_t n = 0; n < COUNT_OF(per_turn); n++) {
        const double     speed = 8000.0 / per_turn[n];
        ctl_src_params_t p = valid_params();
        p.lambda = ANGLE_QUARTER;
        p.omega_half_ts = num_of(20.0 * TWO_PI / 8000.0 / 2.0); /* corner at order 20; speed 1 makes 2 pi / 8000 rad per sample */
        start_with(&p, 1000U);
        ASSERT_DOUBLE_WITHIN_AT(0.02, sqrt(0.5), gain_at(20.0, speed, per_turn[n]), at("%u per turn", (unsigned)per_turn[n]));
        start_with(&p, 1000U);
        TEST_ASSERT_DOUBLE_WITHIN(0.02, 1.0, gain_at(4.0, speed, per_turn[n]));
        start_with(&p, 1000U);
        TEST_ASSERT_DOUBLE_WITHIN(0.02, 1.0 / sqrt(1.0 + 16.0), gain_at(40.0, speed, per_turn[n]));
    }
}

/* half of a step shows lambda + sqrt(2) / Omega later: the delay of a Butterworth filter of second order at low orders */
void test_ctl_src_step_comes_back_after_lambda_and_the_delay_of_the_filter(void)
{
    for (int direction = -1; direction <= 1; direction += 2) {
        ctl_src_params_t p = valid_params();
        p.lambda = ANGLE_QUARTER;
        p.omega_half_ts = num_of(60.0 * TWO_PI / 4000.0 / 2.0);
        start_with(&p, 4000U); /* a point per sample, and the first at -1 */
        const angle_t one = (angle_t)(int64_t)((double)direction * TURN_STEPS / 4000.0);
        double        area = 0.0;
        double        y = step(0U - one, direction, 0.0);
        for (uint32_t k = 0U; k < 1800U; k++) { /* the first answer only */
            y = step(k * one, direction, 1.0);
            area += 1.0 - y;
        }
        const double delay = area * TWO_PI / 4000.0;
        TEST_ASSERT_DOUBLE_WITHIN(1e-3, 1.0, y);
        TEST_ASSERT_DOUBLE_WITHIN(TWO_PI / 4000.0, TWO_PI / 4.0 + sqrt(2.0) / 60.0, delay); /* a sample */
    }
}

/* the internal model: an error of the period lambda + sqrt(2) / Omega goes away, one of another stays */
static double left_over(double order)
{
    const uint32_t per_turn = 4000U;
    double         y = 0.0;
    double         sum = 0.0;
    for (uint32_t k = 0U; k < 20U * per_turn; k++) {
        const double e = sin(order * TWO_PI * k / per_turn) - y; /* what is wrong, less what was corrected */
        if (k >= 19U * per_turn) {
            sum += e * e;
        }
        y = step(k * (angle_t)(TURN_STEPS / per_turn), 1.0, e);
    }
    return sqrt(2.0 * sum / per_turn);
}

void test_ctl_src_learns_what_repeats_after_lambda_and_the_delay_of_the_filter(void)
{
    ctl_src_params_t p = valid_params();
    p.omega_half_ts = num_of(60.0 * TWO_PI / 4000.0 / 2.0);
    p.lambda = (angle_t)((0.25 - sqrt(2.0) / 60.0 / TWO_PI - 1.0 / 4000.0) * TURN_STEPS); /* and a sample of delay */
    start_with(&p, 720U);
    TEST_ASSERT_TRUE(left_over(4.0) < 0.03);
    start_with(&p, 720U);
    TEST_ASSERT_TRUE(left_over(24.0) < 0.15); /* the filter is 0.99 there */
    start_with(&p, 720U);
    TEST_ASSERT_TRUE(left_over(6.0) > 0.5); /* half a period off */
}

/* ---- the way, not the time ------------------------------------------------------------------------------------------------------ */

void test_ctl_src_at_standstill_holds_its_output(void)
{
    noise_t noise = {139U};
    for (uint32_t k = 0U; k < 40U; k++) {
        (void)step(k * STEP, SPEED, 1.0 + noise_next(&noise));
    }
    const double y = step(39U * STEP, 0.0, 0.3);
    TEST_ASSERT_TRUE(fabs(y) > 0.1);
    for (int k = 0; k < 1000; k++) {
        ASSERT_DOUBLE_WITHIN_AT(1e-6, y, step(39U * STEP, 0.0, 0.3), at("sample %d", k));
    }
}

/* the same error over the way, passed at half the speed, or with a stop on the way, gives the same output over the way */
void test_ctl_src_output_over_the_way_does_not_depend_on_the_speed(void)
{
    static double    fast[6000];
    ctl_src_params_t p = valid_params();
    p.lambda = ANGLE_QUARTER;
    p.omega_half_ts = num_of(30.0 * TWO_PI / 2000.0 / 2.0);
    const angle_t one = (angle_t)(TURN_STEPS / 2000.0);
    start_with(&p, 1000U);
    for (uint32_t k = 0U; k < COUNT_OF(fast); k++) {
        fast[k] = step(k * one, 1.0, sin(0.013 * k));
    }
    start_with(&p, 1000U);
    for (uint32_t k = 0U; k < COUNT_OF(fast); k++) {
        const uint32_t parts = ((k / 500U) % 2U == 0U) ? 1U : 8U; /* every other stretch at an eighth of the speed */
        double         y = 0.0;
        for (uint32_t part = 1U; part <= parts; part++) {
            const double at_k = (double)k - 1.0 + (double)part / parts;
            y = step((angle_t)(int64_t)(at_k * (double)one), 1.0 / parts, sin(0.013 * at_k));
        }
        if (k % 777U == 0U) {
            for (int stop = 0; stop < 300; stop++) {
                y = step(k * one, 0.0, sin(0.013 * k));
            }
        }
        ASSERT_DOUBLE_WITHIN_AT(0.03, fast[k], y, at("sample %u", (unsigned)k));
    }
}

void test_ctl_src_delay_lies_behind_whichever_way_it_turns(void)
{
    memory[20] = num_of(1.0);
    (void)step((20U + 11U) * STEP, SPEED, 0.0);
    TEST_ASSERT_TRUE(step((20U + 11U) * STEP, SPEED, 0.0) > 0.01);

    setUp();
    memory[20] = num_of(1.0);
    (void)step((20U - 11U) * STEP, -SPEED, 0.0);
    TEST_ASSERT_TRUE(step((20U - 11U) * STEP, -SPEED, 0.0) > 0.01);

    setUp();
    memory[20] = num_of(1.0);
    (void)step((20U - 11U) * STEP, SPEED, 0.0);
    TEST_ASSERT_EQUAL_DOUBLE(0.0, step((20U - 11U) * STEP, SPEED, 0.0));
}

void test_ctl_src_jump_of_more_than_a_quarter_turn_writes_nothing(void)
{
    const uint32_t jumps[] = {17U, 32U, 47U};
    for (size_t n = 0; n < COUNT_OF(jumps); n++) {
        setUp();
        (void)step(0U, SPEED, 1.0);
        (void)step(jumps[n] * STEP, SPEED, 1.0);
        for (uint32_t cell = 0U; cell < CELLS; cell++) {
            TEST_ASSERT_EQUAL_DOUBLE(0.0, value_of(memory[cell]));
        }
        (void)step((jumps[n] + 1U) * STEP, SPEED, 1.0);
        ASSERT_NUM_WITHIN(1e-6, 1.0, memory[(jumps[n] + 1U) % CELLS]);
    }
}

void test_ctl_src_steps_below_a_quarter_turn_are_motions(void)
{
    (void)step(0U, SPEED, 1.0);
    (void)step(15U * STEP, SPEED, 1.0);
    ASSERT_NUM_WITHIN(1e-6, 1.0, memory[7]);
    setUp();
    (void)step(0U, -SPEED, 1.0);
    (void)step(0U - 15U * STEP, -SPEED, 1.0);
    ASSERT_NUM_WITHIN(1e-6, 1.0, memory[57]);
}

/* ---- limits, not a number, reset ---------------------------------------------------------------------------------------------------- */

void test_ctl_src_output_stops_at_the_limit_and_comes_back(void)
{
    for (int sign = -1; sign <= 1; sign += 2) {
        ctl_src_params_t p = valid_params();
        p.limit = num_of(2.0);
        start_with(&p, CELLS);
        double y = 0.0;
        for (uint32_t k = 0U; k < 500U; k++) {
            y = step(k * STEP, SPEED, sign);
            TEST_ASSERT_TRUE(fabs(y) <= 2.0);
        }
        TEST_ASSERT_DOUBLE_WITHIN(1e-6, 2.0 * sign, y);
        for (uint32_t k = 0U; k < 100U; k++) {
            y = step(k * STEP, SPEED, -sign);
        }
        TEST_ASSERT_TRUE(y * sign < 1.0);
    }
}

void test_ctl_src_memory_stays_within_twice_the_limit(void)
{
    ctl_src_params_t p = valid_params();
    p.limit = num_of(2.0);
    start_with(&p, CELLS);
    for (uint32_t k = 0U; k < 100U; k++) {
        (void)step(k * STEP, SPEED, (k < 50U) ? 100.0 : -100.0);
    }
    for (uint32_t cell = 0U; cell < CELLS; cell++) {
        ASSERT_BOUNDED_AT(4.0, memory[cell], at("cell %u", (unsigned)cell));
    }
}

void test_ctl_src_input_that_is_not_a_number_counts_as_nothing_and_is_counted(void)
{
    for (size_t n = 0; n < COUNT_OF(NOT_FINITE); n++) {
        setUp();
        (void)step(0U, SPEED, 1.0);
        (void)ctl_src_step(&src, STEP, num_of(SPEED), NOT_FINITE[n]);
        ASSERT_NUM_WITHIN(1e-6, 0.0, memory[1]);
        TEST_ASSERT_EQUAL_UINT32(1U, src.state.rejected);
        ASSERT_BOUNDED_AT(50.0, ctl_src_step(&src, 2U * STEP, NOT_FINITE[n], num_of(1.0)), "output");
        TEST_ASSERT_EQUAL_UINT32(2U, src.state.rejected);
    }
}

void test_ctl_src_output_is_bounded_for_any_input(void)
{
    noise_t noise = {149U};
    for (int k = 0; k < 20000; k++) {
        ASSERT_BOUNDED_AT(50.0, ctl_src_step(&src, noise_bits(&noise), noise_nasty(&noise), noise_nasty(&noise)),
                          at("sample %d", k));
    }
    TEST_ASSERT_TRUE(src.state.rejected > 100U);
}

void test_ctl_src_on_hold_writes_nothing_and_goes_on_acting(void)
{
    angle_t theta = 0U;
    for (int k = 0; k < 3 * (int)CELLS; k++, theta += STEP) {
        (void)step(theta, SPEED, sin(TWO_PI * k / 16.0));
    }
    num_t kept[CELLS];
    for (uint16_t i = 0U; i < CELLS; i++) {
        kept[i] = memory[i];
    }
    ctl_src_params_t p = src.params;
    p.hold = true;
    src.params = p;
    double largest = 0.0;
    for (int k = 0; k < 3 * (int)CELLS; k++, theta += STEP) {
        largest = fmax(largest, fabs(step(theta, SPEED, 1.0)));
    }
    TEST_ASSERT_TRUE(largest > 0.01);
    for (uint16_t i = 0U; i < CELLS; i++) {
        ASSERT_NUM_WITHIN_AT(0.0, value_of(kept[i]), memory[i], at("cell %u", (unsigned)i));
    }
}

void test_ctl_src_reset_forgets_all_but_the_count(void)
{
    for (uint32_t k = 0U; k < 200U; k++) {
        (void)step(k * STEP, SPEED, 1.0);
    }
    (void)ctl_src_step(&src, 0U, num_of(SPEED), NOT_FINITE[0]);

    ctl_src_reset(&src);

    TEST_ASSERT_EQUAL_UINT32(1U, src.state.rejected);
    assert_golden(STEP, SPEED);
}

/* ---- refused -------------------------------------------------------------------------------------------------------------------------- */

static void assert_refused(const ctl_src_params_t *p, num_t *cells, uint16_t count, ctl_status_t status, uint16_t field)
{
    const ctl_src_t  before = src;
    const ctl_diag_t got = ctl_src_init(&src, p, cells, count);

    TEST_ASSERT_EQUAL(status, got.status);
    TEST_ASSERT_EQUAL(field, got.field);
    TEST_ASSERT_EQUAL_MEMORY(&before, &src, sizeof src);
}

void test_ctl_src_init_without_object_parameters_or_memory_is_null(void)
{
    const ctl_src_params_t p = valid_params();

    ASSERT_DIAG(CTL_ERR_NULL, 0U, 0.0, ctl_src_init(NULL, &p, memory, CELLS));
    assert_refused(NULL, memory, CELLS, CTL_ERR_NULL, 0U);
    assert_refused(&p, NULL, CELLS, CTL_ERR_NULL, CTL_SRC_CELLS);
    assert_refused(&p, memory, 3U, CTL_ERR_MEMORY, CTL_SRC_CELLS);
}

void test_ctl_src_init_rejects_no_corner_no_way_and_no_limit(void)
{
    ctl_src_params_t p = valid_params();
    p.omega_half_ts = (num_t)0;
    assert_refused(&p, memory, CELLS, CTL_ERR_RANGE, CTL_SRC_OMEGA);
    p = valid_params();
    p.lambda = 0U;
    assert_refused(&p, memory, CELLS, CTL_ERR_RANGE, CTL_SRC_LAMBDA);
    p = valid_params();
    p.limit = num_of(-1.0);
    assert_refused(&p, memory, CELLS, CTL_ERR_RANGE, CTL_SRC_LIMIT);
    for (size_t k = 0; k < COUNT_OF(NOT_FINITE); k++) {
        p = valid_params();
        p.omega_half_ts = NOT_FINITE[k];
        assert_refused(&p, memory, CELLS, CTL_ERR_RANGE, CTL_SRC_OMEGA);
        p = valid_params();
        p.limit = NOT_FINITE[k];
        assert_refused(&p, memory, CELLS, CTL_ERR_RANGE, CTL_SRC_LIMIT);
    }
}
