/* control/motor/pll.c against its transfer function, and how it locks, lags and saturates. */
#include "tests/support/numeric.h"

#include "control/motor/pll.h"
#include "tests/control/golden/pll.h"

static ctl_pll_t pll;

/* The values of golden/pll.h: all exact in both numerics. */
static ctl_pll_params_t valid_params(void)
{
    const ctl_pll_params_t p = {
        .kp_ts = num_of(0.125), .ki_ts = num_of(4.0), .rad_per_speed_ts = num_of(0.0078125), .speed_max = num_of(100.0)};
    return p;
}

static angle_t turns(double t) { return (angle_t)(int64_t)llround((t - floor(t)) * TURN_STEPS); }

void setUp(void)
{
    const ctl_pll_params_t p = valid_params();
    TEST_ASSERT_EQUAL(CTL_OK, ctl_pll_init(&pll, &p).status);
}
void tearDown(void) {}

void test_ctl_pll_matches_golden(void)
{
    for (size_t k = 0; k < COUNT_OF(GOLDEN_PLL); k++) {
        const num_t w = ctl_pll_step(&pll, GOLDEN_PLL[k].theta);

        /* header: 1e-5 of full scale; the loop forgets its roundings, so they do not add up over the run */
        ASSERT_NUM_WITHIN_AT(1e-5 * 100.0, GOLDEN_PLL[k].w, w, at("sample %u", (unsigned)k));
    }
}

static double run_at(double turns_per_sample, int samples)
{
    double position = 0.3;
    num_t  w = (num_t)0;
    for (int k = 0; k < samples; k++) {
        w = ctl_pll_step(&pll, turns(position));
        position += turns_per_sample;
    }
    return value_of(w);
}

void test_ctl_pll_at_constant_speed_settles_on_it_both_ways(void)
{
    static const double RATES[] = {0.05, -0.05, 0.001, -0.001, 1e-6, -1e-6, 0.0};
    for (size_t i = 0; i < COUNT_OF(RATES); i++) {
        setUp();

        const double w = run_at(RATES[i], 600);

        /* steps of the angle (float: 2^-24 of it), divided by the angle of one speed unit */
        const double want = RATES[i] * TWO_PI / 0.0078125;
        ASSERT_DOUBLE_WITHIN_AT(2e-5 + (3e-7 * fabs(want)), want, w, at("%g turns per sample", RATES[i]));
    }
}

void test_ctl_pll_is_as_fine_at_a_creep_backwards_as_forwards(void)
{
    const double forwards = run_at(1e-7, 2000);
    setUp();
    const double backwards = run_at(-1e-7, 2000);

    const double want = 1e-7 * TWO_PI / 0.0078125;
    TEST_ASSERT_DOUBLE_WITHIN(per_numeric(1e-6, 3e-5), want, forwards); /* fixed: steps of angle errors are 6e-8 rad */
    TEST_ASSERT_DOUBLE_WITHIN(per_numeric(1e-6, 3e-5), -want, backwards);
}

void test_ctl_pll_at_constant_speed_knows_the_angle_of_the_next_sample(void)
{
    (void)run_at(0.02, 600); /* the last sample was 0.3 + 599 * 0.02 */

    TEST_ASSERT_DOUBLE_WITHIN(1e-6, 0.0, (double)(int32_t)(pll.state.th - turns(0.3 + (600.0 * 0.02))) / TURN_STEPS);
}

void test_ctl_pll_lags_an_acceleration_by_kp_over_ki(void)
{
    const double acceleration = 2e-5; /* turns per sample^2 */
    double       position = 0.0;
    num_t        w = (num_t)0;
    for (int k = 0; k < 500; k++) {
        w = ctl_pll_step(&pll, turns(position));
        position += acceleration * (k + 0.5);
    }

    /* speed at the last sample is 499 a; a lag of kp/ki in samples: 0.125 / (4 * 0.0078125) = 4 */
    const double want = acceleration * (499.0 - 4.0) * TWO_PI / 0.0078125;
    TEST_ASSERT_DOUBLE_WITHIN(0.6 * acceleration * TWO_PI / 0.0078125, want, value_of(w)); /* half a sample, either way */
}

void test_ctl_pll_across_the_wrap_of_the_angle_has_no_jump(void)
{
    ctl_pll_reset(&pll, turns(0.95));
    ctl_pll_t other = pll;
    ctl_pll_reset(&other, turns(0.45));
    for (int k = 0; k < 100; k++) {
        const num_t w = ctl_pll_step(&pll, turns(0.95 + 0.01 * k));
        const num_t v = ctl_pll_step(&other, turns(0.45 + 0.01 * k));

        ASSERT_NUM_WITHIN_AT(1e-5 * 100.0, value_of(v), w, at("sample %d", k));
    }
}

void test_ctl_pll_error_is_the_shortest_way_to_the_angle(void)
{
    ctl_pll_reset(&pll, turns(0.9));
    (void)ctl_pll_step(&pll, turns(0.1));
    ASSERT_NUM_WITHIN(1e-6, 0.2 * TWO_PI, pll.state.error);

    ctl_pll_reset(&pll, turns(0.1));
    (void)ctl_pll_step(&pll, turns(0.9));
    ASSERT_NUM_WITHIN(1e-6, -0.2 * TWO_PI, pll.state.error);
}

void test_ctl_pll_reset_starts_at_rest_at_the_angle(void)
{
    (void)run_at(0.05, 100);

    ctl_pll_reset(&pll, turns(0.7));

    ASSERT_NUM_WITHIN(0.0, 0.0, pll.state.error);
    ASSERT_NUM_WITHIN(0.0, 0.0, ctl_pll_step(&pll, turns(0.7)));
    ASSERT_NUM_WITHIN(0.0, 0.0, pll.state.error);
}

void test_ctl_pll_init_starts_at_rest_at_angle_zero(void)
{
    const ctl_pll_params_t p = valid_params();
    (void)run_at(0.05, 100);

    TEST_ASSERT_EQUAL(CTL_OK, ctl_pll_init(&pll, &p).status);

    ASSERT_NUM_WITHIN(0.0, 0.0, ctl_pll_step(&pll, 0U));
}

void test_ctl_pll_speed_stops_at_its_limit_and_comes_back(void)
{
    ctl_pll_params_t p = valid_params();
    p.speed_max = num_of(20.0); /* 0.025 turns per sample */
    TEST_ASSERT_EQUAL(CTL_OK, ctl_pll_init(&pll, &p).status);

    TEST_ASSERT_TRUE(run_at(0.05, 300) <= 20.0);
    TEST_ASSERT_TRUE(run_at(-0.05, 300) >= -20.0);
    TEST_ASSERT_DOUBLE_WITHIN(1e-3, 0.01 * TWO_PI / 0.0078125, run_at(0.01, 600));
}

void test_ctl_pll_fed_with_any_angles_stays_within_its_limits(void)
{
    noise_t noise = {61U};
    for (uint32_t k = 0; k < 5000U; k++) {
        const num_t w = ctl_pll_step(&pll, noise_bits(&noise));

        ASSERT_BOUNDED_AT(100.0, w, at("sample %u", k));
        ASSERT_BOUNDED_AT(3.1416, pll.state.error, at("sample %u", k));
    }
}

void test_ctl_pll_with_the_largest_gain_stays_within_its_limits(void)
{
    ctl_pll_params_t p = valid_params();
    p.kp_ts = num_of(1.0);
    p.ki_ts = NUM_MAX;
    noise_t noise = {62U};
    TEST_ASSERT_EQUAL(CTL_OK, ctl_pll_init(&pll, &p).status);
    for (uint32_t k = 0; k < 1000U; k++) {
        ASSERT_BOUNDED_AT(100.0, ctl_pll_step(&pll, noise_bits(&noise)), at("sample %u", k));
    }
}

/* ---- configuration ------------------------------------------------------------------------------------------------------ */

static void assert_rejected(const ctl_pll_params_t *p, ctl_status_t status, uint16_t field, num_t given)
{
    (void)ctl_pll_step(&pll, turns(0.01));
    const ctl_pll_t before = pll;

    const ctl_diag_t got = ctl_pll_init(&pll, p);

    TEST_ASSERT_EQUAL(status, got.status);
    TEST_ASSERT_EQUAL_UINT16(field, got.field);
    ASSERT_SAME_BITS(given, got.given);
    ASSERT_SAME_BITS(before, pll);
}

static void assert_field_rejects(uint16_t field, num_t value)
{
    ctl_pll_params_t p = valid_params();
    num_t *const     place[] = {NULL, &p.kp_ts, &p.ki_ts, &p.rad_per_speed_ts, &p.speed_max};
    *place[field] = value;
    assert_rejected(&p, CTL_ERR_RANGE, field, value);
}

void test_ctl_pll_init_rejects_every_field_that_is_not_positive_or_not_finite(void)
{
    for (uint16_t field = CTL_PLL_KP; field <= CTL_PLL_SPEED_MAX; field++) {
        assert_field_rejects(field, (num_t)0);
        assert_field_rejects(field, num_of(-0.5));
        for (size_t i = 0; i < COUNT_OF(NOT_FINITE); i++) {
            assert_field_rejects(field, NOT_FINITE[i]);
        }
    }
}

void test_ctl_pll_init_rejects_a_proportional_gain_above_one(void)
{
    assert_field_rejects(CTL_PLL_KP, num_of(1.001));

    ctl_pll_params_t p = valid_params();
    p.kp_ts = num_of(1.0);
    TEST_ASSERT_EQUAL(CTL_OK, ctl_pll_init(&pll, &p).status);
}

void test_ctl_pll_init_rejects_a_speed_of_more_than_half_a_turn_per_sample(void)
{
    ctl_pll_params_t p = valid_params();
    p.rad_per_speed_ts = num_of(0.05); /* 100 * 0.05 = 5 rad */
    assert_rejected(&p, CTL_ERR_RELATION, CTL_PLL_SPEED_MAX, p.speed_max);

    p.rad_per_speed_ts = NUM_MAX;
    assert_rejected(&p, CTL_ERR_RELATION, CTL_PLL_SPEED_MAX, p.speed_max);

    p.rad_per_speed_ts = num_of(0.03125); /* 3.125 rad: just inside */
    TEST_ASSERT_EQUAL(CTL_OK, ctl_pll_init(&pll, &p).status);
    p.rad_per_speed_ts = NUM_C(3.14159265f); /* half a turn itself */
    p.speed_max = num_of(1.0);
    TEST_ASSERT_EQUAL(CTL_OK, ctl_pll_init(&pll, &p).status);
}

void test_ctl_pll_init_without_a_pointer_says_so(void)
{
    const ctl_pll_params_t p = valid_params();

    ASSERT_DIAG(CTL_ERR_NULL, 0U, 0.0, ctl_pll_init(NULL, &p));
    assert_rejected(NULL, CTL_ERR_NULL, 0U, (num_t)0);
}
