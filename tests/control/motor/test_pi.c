/* control/motor/pi.c: proposal and commitment, both kinds of anti-windup, and a bounded integrator. */
#include "tests/support/numeric.h"

#include "control/motor/pi.h"
#include "tests/control/golden/pi.h"

static ctl_pi_t pi;

static ctl_pi_params_t valid_params(void)
{
    const ctl_pi_params_t p = {
        .kp = num_of(1.25), .ki_ts = num_of(0.125), .out_min = num_of(-3.0), .out_max = num_of(3.0), .anti_windup = CTL_PI_HOLD};
    return p;
}

static void start(ctl_pi_anti_windup_t anti_windup)
{
    ctl_pi_params_t p = valid_params();
    p.anti_windup = anti_windup;
    TEST_ASSERT_EQUAL(CTL_OK, ctl_pi_init(&pi, &p).status);
}

/* One sample with an actuator that does what is commanded up to +-able. */
static double sample(double err, double able)
{
    const num_t u = ctl_pi_output(&pi, num_of(err));
    ctl_pi_commit(&pi, num_clamp(u, num_of(-able), num_of(able)));
    return value_of(u);
}

void setUp(void) { start(CTL_PI_HOLD); }
void tearDown(void) {}

/* ---- golden --------------------------------------------------------------------------------------------------------- */

static void assert_golden(const double *golden, size_t count)
{
    noise_t noise = {31U};
    for (size_t k = 0; k < count; k++) {
        const double err = (2.0 * noise_next(&noise)) + (((k / 50U) % 2U == 0U) ? 0.75 : -0.75);
        const double able = ((k / 20U) % 3U != 0U) ? 2.0 : 1.0;

        /* every product is a whole multiple of 2^-21, so both numerics are exact; the header has 13 digits */
        ASSERT_DOUBLE_WITHIN_AT(1e-11, golden[k], sample(err, able), at("sample %u", (unsigned)k));
    }
}

void test_ctl_pi_with_hold_matches_golden(void) { assert_golden(GOLDEN_PI_HOLD, COUNT_OF(GOLDEN_PI_HOLD)); }

void test_ctl_pi_with_outward_hold_matches_golden(void)
{
    start(CTL_PI_HOLD_OUTWARD);

    assert_golden(GOLDEN_PI_OUTWARD, COUNT_OF(GOLDEN_PI_OUTWARD));
}

/* k_i T_s e of a tenth of a step of fixed point: cut or rounded in every sample it would come to nothing. */
void test_ctl_pi_integrates_errors_that_are_less_than_a_step_in_a_sample(void)
{
    const double    err = 0.8 * 5.9604644775390625e-8 * 16.0; /* 12.8 steps of fixed point, held as 12 or 13 */
    ctl_pi_params_t p = valid_params();
    p.ki_ts = num_of(1.0 / 128.0);
    for (int sign = -1; sign <= 1; sign += 2) {
        TEST_ASSERT_EQUAL(CTL_OK, ctl_pi_init(&pi, &p).status);
        for (int k = 0; k < 12800; k++) {
            (void)sample(sign * err, 3.0);
        }
        TEST_ASSERT_DOUBLE_WITHIN_MESSAGE(5e-6, sign * 100.0 * value_of(num_of(err)), value_of(pi.state.x), at("sign %d", sign));
        ctl_pi_reset(&pi, (num_t)0);
        (void)sample(0.0, 3.0);
        TEST_ASSERT_DOUBLE_WITHIN(0.0, 0.0, value_of(pi.state.x)); /* and a reset leaves nothing of it */
    }
}

void test_ctl_pi_with_inexact_gains_agrees_with_double_precision(void)
{
    /* header: both numerics within 1e-6 of full scale per step */
    ctl_pi_params_t p = valid_params();
    p.kp = num_of(0.6);
    p.ki_ts = num_of(0.108);
    p.out_min = num_of(-100.0);
    p.out_max = num_of(100.0);
    TEST_ASSERT_EQUAL(CTL_OK, ctl_pi_init(&pi, &p).status);
    noise_t noise = {32U};
    double  x = 0.0;
    for (int k = 0; k < 1000; k++) {
        const double err = 20.0 * noise_next(&noise);

        const double u = sample(err, 100.0);

        ASSERT_DOUBLE_WITHIN_AT(1e-6 * 100.0, x + (0.6 * err), u, at("sample %d", k));
        x += 0.108 * err;
    }
}

/* ---- the two equations ---------------------------------------------------------------------------------------------- */

void test_ctl_pi_fresh_with_a_zero_error_gives_zero(void) { TEST_ASSERT_EQUAL_DOUBLE(0.0, sample(0.0, 3.0)); }

void test_ctl_pi_first_output_is_proportional(void) { TEST_ASSERT_EQUAL_DOUBLE(1.25 * 0.5, sample(0.5, 3.0)); }

void test_ctl_pi_integrates_after_the_output_not_before(void)
{
    (void)sample(0.5, 3.0);

    TEST_ASSERT_EQUAL_DOUBLE(0.125 * 0.5, sample(0.0, 3.0));
    TEST_ASSERT_EQUAL_DOUBLE(0.125 * 0.5, sample(0.0, 3.0));
}

void test_ctl_pi_of_the_opposite_error_gives_the_opposite_output(void)
{
    noise_t  noise = {33U};
    ctl_pi_t mirror = pi;
    for (int k = 0; k < 200; k++) {
        const num_t err = num_of(6.0 * noise_next(&noise));
        const num_t u = ctl_pi_output(&pi, err);
        const num_t v = ctl_pi_output(&mirror, num_neg(err));
        ctl_pi_commit(&pi, num_clamp(u, num_of(-1.0), num_of(1.0)));
        ctl_pi_commit(&mirror, num_clamp(v, num_of(-1.0), num_of(1.0)));

        TEST_ASSERT_DOUBLE_WITHIN(200.0 * per_numeric(0.0, FIXED_STEP), -value_of(u), value_of(v)); /* half steps round up */
    }
}

void test_ctl_pi_output_is_within_the_limits_on_both_sides(void)
{
    ctl_pi_params_t p = valid_params();
    p.out_min = num_of(-1.0);
    p.out_max = num_of(2.0);
    TEST_ASSERT_EQUAL(CTL_OK, ctl_pi_init(&pi, &p).status);

    ASSERT_NUM_WITHIN(0.0, 2.0, ctl_pi_output(&pi, num_of(50.0)));
    ASSERT_NUM_WITHIN(0.0, -1.0, ctl_pi_output(&pi, num_of(-50.0)));
    ASSERT_NUM_WITHIN(0.0, 1.25, ctl_pi_output(&pi, num_of(1.0)));
}

void test_ctl_pi_proposing_twice_teaches_nothing(void)
{
    (void)ctl_pi_output(&pi, num_of(1.0));
    (void)ctl_pi_output(&pi, num_of(1.0));

    ASSERT_NUM_WITHIN(0.0, 1.25, ctl_pi_output(&pi, num_of(1.0)));
}

/* ---- anti-windup ------------------------------------------------------------------------------------------------------ */

void test_ctl_pi_with_hold_keeps_the_integrator_while_the_clamp_limits(void)
{
    for (int k = 0; k < 100; k++) {
        TEST_ASSERT_EQUAL_DOUBLE(3.0, sample(4.0, 3.0));
    }

    TEST_ASSERT_EQUAL_DOUBLE(0.0, sample(0.0, 3.0)); /* nothing was learned, nothing has to be unwound */
}

void test_ctl_pi_with_hold_keeps_the_integrator_while_the_actuator_limits(void)
{
    for (int k = 0; k < 100; k++) {
        (void)sample(1.0, 0.5); /* wants 1.25, gets 0.5: no clamp of its own is involved */
    }

    TEST_ASSERT_EQUAL_DOUBLE(0.0, sample(0.0, 3.0));
}

static void limit_while_the_error_points_inward(void)
{
    ctl_pi_reset(&pi, num_of(2.0));
    (void)ctl_pi_output(&pi, num_of(-0.5)); /* wants 2 - 0.625 = 1.375 */
    ctl_pi_commit(&pi, num_of(1.0));        /* still too low, but the error already points down */
}

void test_ctl_pi_with_hold_holds_also_when_the_error_points_inward(void)
{
    limit_while_the_error_points_inward();

    ASSERT_NUM_WITHIN(0.0, 2.0, ctl_pi_output(&pi, (num_t)0));
}

void test_ctl_pi_with_outward_hold_learns_when_the_error_points_inward(void)
{
    start(CTL_PI_HOLD_OUTWARD);

    limit_while_the_error_points_inward();

    ASSERT_NUM_WITHIN(0.0, 2.0 - (0.125 * 0.5), ctl_pi_output(&pi, (num_t)0));
}

void test_ctl_pi_with_outward_hold_holds_when_the_error_points_outward_on_either_side(void)
{
    start(CTL_PI_HOLD_OUTWARD);
    for (int k = 0; k < 50; k++) {
        TEST_ASSERT_EQUAL_DOUBLE(3.0, sample(4.0, 3.0));
    }
    TEST_ASSERT_EQUAL_DOUBLE(0.0, sample(0.0, 3.0));
    for (int k = 0; k < 50; k++) {
        TEST_ASSERT_EQUAL_DOUBLE(-3.0, sample(-4.0, 3.0));
    }
    TEST_ASSERT_EQUAL_DOUBLE(0.0, sample(0.0, 3.0));
}

void test_ctl_pi_with_outward_hold_learns_when_the_actuator_did_too_much_and_the_error_points_up(void)
{
    start(CTL_PI_HOLD_OUTWARD);

    (void)ctl_pi_output(&pi, num_of(1.0)); /* wants 1.25 */
    ctl_pi_commit(&pi, num_of(2.0));       /* the actuator did more: limited from below, the error pushes away from it */

    ASSERT_NUM_WITHIN(0.0, 0.125, ctl_pi_output(&pi, (num_t)0));
}

void test_ctl_pi_leaves_saturation_as_soon_as_the_error_turns(void)
{
    for (int mode = 0; mode < 2; mode++) {
        start((mode == 0) ? CTL_PI_HOLD : CTL_PI_HOLD_OUTWARD);
        for (int k = 0; k < 1000; k++) {
            (void)sample(10.0, 3.0);
        }

        TEST_ASSERT_TRUE_MESSAGE(sample(-0.25, 3.0) < 0.0, at("mode %d", mode));
    }
}

void test_ctl_pi_integrator_is_bounded_whatever_is_committed(void)
{
    /* an actuator that claims to follow everything: no limit is ever seen */
    for (int k = 0; k < 1000; k++) {
        (void)ctl_pi_output(&pi, num_of(2.0));
        ctl_pi_commit(&pi, pi.state.wanted);
    }
    ASSERT_NUM_WITHIN(0.0, 3.0, pi.state.x);
    for (int k = 0; k < 1000; k++) {
        (void)ctl_pi_output(&pi, num_of(-2.0));
        ctl_pi_commit(&pi, pi.state.wanted);
    }
    ASSERT_NUM_WITHIN(0.0, -3.0, pi.state.x);
}

void test_ctl_pi_integrator_bound_is_the_larger_magnitude_of_the_limits(void)
{
    ctl_pi_params_t p = valid_params();
    p.out_min = num_of(-5.0);
    p.out_max = num_of(1.0);
    TEST_ASSERT_EQUAL(CTL_OK, ctl_pi_init(&pi, &p).status);
    for (int k = 0; k < 1000; k++) {
        (void)ctl_pi_output(&pi, num_of(2.0));
        ctl_pi_commit(&pi, pi.state.wanted);
    }

    ASSERT_NUM_WITHIN(0.0, 5.0, pi.state.x);
}

void test_ctl_pi_hold_instead_of_a_commit_keeps_the_integrator_in_both_modes(void)
{
    for (int mode = 0; mode < 2; mode++) {
        start((mode == 0) ? CTL_PI_HOLD : CTL_PI_HOLD_OUTWARD);
        ctl_pi_reset(&pi, num_of(1.0));
        ASSERT_NUM_WITHIN(0.0, 1.625, ctl_pi_output(&pi, num_of(0.5)));

        ctl_pi_hold(&pi);

        ASSERT_NUM_WITHIN(0.0, 1.0, pi.state.x);
        ctl_pi_commit(&pi, pi.state.wanted); /* a commit that comes all the same finds nothing left to learn */
        ASSERT_NUM_WITHIN(0.0, 1.0, pi.state.x);
        TEST_ASSERT_EQUAL_DOUBLE(1.625, sample(0.5, 3.0)); /* the next sample is an ordinary one */
        ASSERT_NUM_WITHIN(0.0, 1.0625, pi.state.x);
    }
}

/* ---- reset -------------------------------------------------------------------------------------------------------------- */

void test_ctl_pi_reset_starts_with_the_given_integrator(void)
{
    (void)sample(1.0, 3.0);

    ctl_pi_reset(&pi, num_of(1.5));

    ASSERT_NUM_WITHIN(0.0, 1.5, ctl_pi_output(&pi, (num_t)0));
}

void test_ctl_pi_reset_cuts_the_integrator_to_the_limits(void)
{
    ctl_pi_reset(&pi, num_of(50.0));
    ASSERT_NUM_WITHIN(0.0, 3.0, pi.state.x);

    ctl_pi_reset(&pi, num_of(-50.0));
    ASSERT_NUM_WITHIN(0.0, -3.0, pi.state.x);
}

void test_ctl_pi_reset_with_what_is_not_finite_starts_with_zero_and_counts(void)
{
    for (size_t i = 0; i < COUNT_OF(NOT_FINITE); i++) {
        ctl_pi_reset(&pi, NOT_FINITE[i]);

        ASSERT_NUM_WITHIN(0.0, 0.0, pi.state.x);
        TEST_ASSERT_EQUAL_UINT32(i + 1U, pi.state.rejected);
    }
}

void test_ctl_pi_commit_right_after_a_reset_changes_nothing(void)
{
    (void)ctl_pi_output(&pi, num_of(1.0));
    ctl_pi_reset(&pi, num_of(1.5));

    ctl_pi_commit(&pi, num_of(1.5));

    ASSERT_NUM_WITHIN(0.0, 1.5, pi.state.x);
    ASSERT_NUM_WITHIN(0.0, 1.5, pi.state.wanted);
}

/* ---- bad input ------------------------------------------------------------------------------------------------------------ */

void test_ctl_pi_error_that_is_not_finite_counts_and_acts_as_zero(void)
{
    ctl_pi_reset(&pi, num_of(0.5));
    for (size_t i = 0; i < COUNT_OF(NOT_FINITE); i++) {
        const num_t u = ctl_pi_output(&pi, NOT_FINITE[i]);
        ctl_pi_commit(&pi, u);

        ASSERT_NUM_WITHIN(0.0, 0.5, u);
        ASSERT_NUM_WITHIN(0.0, 0.5, pi.state.x);
        TEST_ASSERT_EQUAL_UINT32(i + 1U, pi.state.rejected);
    }
}

void test_ctl_pi_commit_of_what_is_not_finite_counts_and_acts_as_done(void)
{
    for (size_t i = 0; i < COUNT_OF(NOT_FINITE); i++) {
        ctl_pi_reset(&pi, (num_t)0);
        (void)ctl_pi_output(&pi, num_of(1.0));
        ctl_pi_commit(&pi, NOT_FINITE[i]);

        ASSERT_NUM_WITHIN(0.0, 0.125, pi.state.x);
        TEST_ASSERT_EQUAL_UINT32(i + 1U, pi.state.rejected);
    }
}

void test_ctl_pi_fed_with_anything_stays_bounded(void)
{
    noise_t noise = {34U};
    for (int mode = 0; mode < 2; mode++) {
        start((mode == 0) ? CTL_PI_HOLD : CTL_PI_HOLD_OUTWARD);
        for (uint32_t k = 0; k < 5000U; k++) {
            const num_t u = ctl_pi_output(&pi, noise_nasty(&noise));
            ctl_pi_commit(&pi, (noise_pick(&noise, 2U) != 0U) ? u : noise_nasty(&noise));

            ASSERT_BOUNDED_AT(3.0, u, at("sample %u", k));
            ASSERT_BOUNDED_AT(3.0, pi.state.x, at("sample %u", k));
        }
        TEST_ASSERT_GREATER_THAN_UINT32(0U, pi.state.rejected);
    }
}

void test_ctl_pi_with_the_largest_gains_stays_bounded(void)
{
    const ctl_pi_params_t p = {NUM_MAX, NUM_MAX, -NUM_MAX, NUM_MAX, CTL_PI_HOLD_OUTWARD};
    noise_t               noise = {35U};
    TEST_ASSERT_EQUAL(CTL_OK, ctl_pi_init(&pi, &p).status);
    for (uint32_t k = 0; k < 2000U; k++) {
        const num_t u = ctl_pi_output(&pi, noise_nasty(&noise));
        ctl_pi_commit(&pi, u);

        ASSERT_BOUNDED_AT(num_max_value(), u, at("sample %u", k));
        ASSERT_BOUNDED_AT(num_max_value(), pi.state.x, at("sample %u", k));
    }
}

/* ---- configuration ---------------------------------------------------------------------------------------------------------- */

static void assert_rejected(const ctl_pi_params_t *p, ctl_status_t status, uint16_t field, num_t given)
{
    (void)sample(1.0, 3.0);
    const ctl_pi_t before = pi;

    const ctl_diag_t got = ctl_pi_init(&pi, p);

    TEST_ASSERT_EQUAL(status, got.status);
    TEST_ASSERT_EQUAL_UINT16(field, got.field);
    ASSERT_SAME_BITS(given, got.given);
    ASSERT_SAME_BITS(before, pi);
}

void test_ctl_pi_init_rejects_a_gain_out_of_range(void)
{
    ctl_pi_params_t p = valid_params();
    p.kp = num_of(-0.1);
    assert_rejected(&p, CTL_ERR_RANGE, CTL_PI_KP, p.kp);

    p = valid_params();
    p.ki_ts = num_of(-0.1);
    assert_rejected(&p, CTL_ERR_RANGE, CTL_PI_KI_TS, p.ki_ts);
}

void test_ctl_pi_init_rejects_what_is_not_finite_in_every_field(void)
{
    for (size_t i = 0; i < COUNT_OF(NOT_FINITE); i++) {
        ctl_pi_params_t p = valid_params();
        p.kp = NOT_FINITE[i];
        assert_rejected(&p, CTL_ERR_RANGE, CTL_PI_KP, NOT_FINITE[i]);
        p = valid_params();
        p.ki_ts = NOT_FINITE[i];
        assert_rejected(&p, CTL_ERR_RANGE, CTL_PI_KI_TS, NOT_FINITE[i]);
        p = valid_params();
        p.out_min = NOT_FINITE[i];
        assert_rejected(&p, CTL_ERR_RANGE, CTL_PI_OUT_MIN, NOT_FINITE[i]);
        p = valid_params();
        p.out_max = NOT_FINITE[i];
        assert_rejected(&p, CTL_ERR_RANGE, CTL_PI_OUT_MAX, NOT_FINITE[i]);
    }
}

void test_ctl_pi_init_rejects_limits_that_leave_no_room(void)
{
    ctl_pi_params_t p = valid_params();
    p.out_min = p.out_max;
    assert_rejected(&p, CTL_ERR_RELATION, CTL_PI_OUT_MIN, p.out_min);

    p.out_min = num_of(3.5);
    assert_rejected(&p, CTL_ERR_RELATION, CTL_PI_OUT_MIN, p.out_min);
}

void test_ctl_pi_init_rejects_an_unknown_anti_windup(void)
{
    ctl_pi_params_t p = valid_params();
    p.anti_windup = (ctl_pi_anti_windup_t)(CTL_PI_HOLD_OUTWARD + 1);

    assert_rejected(&p, CTL_ERR_RANGE, CTL_PI_ANTI_WINDUP, num_of(2.0));
}

void test_ctl_pi_init_without_a_pointer_says_so(void)
{
    const ctl_pi_params_t p = valid_params();

    ASSERT_DIAG(CTL_ERR_NULL, 0U, 0.0, ctl_pi_init(NULL, &p));
    assert_rejected(NULL, CTL_ERR_NULL, 0U, (num_t)0);
}

void test_ctl_pi_init_starts_from_rest_and_clears_the_counter(void)
{
    (void)sample(1.0, 3.0);
    (void)ctl_pi_output(&pi, NOT_FINITE[0]);

    start(CTL_PI_HOLD);

    TEST_ASSERT_EQUAL_UINT32(0U, pi.state.rejected);
    TEST_ASSERT_EQUAL_DOUBLE(0.0, sample(0.0, 3.0));
}

void test_ctl_pi_init_takes_zero_gains(void)
{
    ctl_pi_params_t p = valid_params();
    p.kp = (num_t)0;
    p.ki_ts = (num_t)0;

    TEST_ASSERT_EQUAL(CTL_OK, ctl_pi_init(&pi, &p).status);
    TEST_ASSERT_EQUAL_DOUBLE(0.0, sample(2.0, 3.0));
}

/* ---- other gains, and without looking --------------------------------------------------------------------------------------- */

void test_ctl_pi_tune_goes_on_from_its_state_with_the_new_gains_and_bound(void)
{
    (void)sample(1.0, 100.0);
    const double    x = value_of(pi.state.x);
    ctl_pi_params_t p = valid_params();
    p.kp = num_of(0.5);
    p.out_min = num_of(-8.0);

    ctl_pi_tune(&pi, &p);

    TEST_ASSERT_EQUAL_DOUBLE(x + (0.5 * 0.25), sample(0.25, 100.0));
    for (int k = 0; k < 500; k++) {
        ctl_pi_commit(&pi, ctl_pi_output(&pi, num_of(-1.0)));
    }
    TEST_ASSERT_TRUE(value_of(pi.state.x) < -3.0);
    TEST_ASSERT_TRUE(value_of(pi.state.x) >= -8.0);
}

void test_ctl_pi_tune_gains_takes_the_gains_alone_and_goes_on_from_its_state(void)
{
    (void)sample(2.0, 3.0);
    const num_t     integral = pi.state.x;
    const num_t     bound = pi.bound;
    ctl_pi_params_t p = valid_params();
    p.kp = num_of(0.5);
    p.ki_ts = num_of(0.0625);
    p.out_min = num_of(-1.0);
    p.out_max = num_of(1.0);
    ctl_pi_tune_gains(&pi, &p);

    TEST_ASSERT_TRUE(pi.params.kp == num_of(0.5));
    TEST_ASSERT_TRUE(pi.params.ki_ts == num_of(0.0625));
    TEST_ASSERT_TRUE(pi.params.out_min == num_of(-3.0));
    TEST_ASSERT_TRUE(pi.params.out_max == num_of(3.0));
    TEST_ASSERT_TRUE(pi.bound == bound);
    TEST_ASSERT_TRUE(pi.state.x == integral);
}

void test_ctl_pi_of_a_vector_proposes_without_limits_notes_nothing_and_learns_what_it_is_told(void)
{
    ctl_pi_t twin = pi;
    noise_t  noise = {36U};
    for (int k = 0; k < 300; k++) {
        const num_t err = num_of(4.0 * noise_next(&noise)); /* beyond the limits now and then */
        (void)ctl_pi_output(&twin, err);
        ctl_pi_commit(&twin, twin.state.wanted);

        const num_t before = pi.state.x;
        const num_t got = ctl_pi_propose_unchecked(&pi, err);
        TEST_ASSERT_TRUE(before == pi.state.x);
        ctl_pi_learn_unchecked(&pi, err);

        TEST_ASSERT_TRUE_MESSAGE(twin.state.wanted == got, at("sample %d", k));
        TEST_ASSERT_TRUE_MESSAGE(twin.state.x == pi.state.x, at("sample %d", k));
    }
}
