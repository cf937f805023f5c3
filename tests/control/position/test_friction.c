/* control/position/friction.c: viscous, Coulomb and Stribeck's friction, and what it refuses. */
#include "tests/support/numeric.h"

#include "control/position/friction.h"
#include "tests/control/golden/friction.h"

/* Yeh and Liu 2024, table of the identified parameters. */
static ctl_friction_t valid(void)
{
    const ctl_friction_t p = {num_of(0.0339), num_of(0.387), num_of(0.457), num_of(0.551), num_of(1.957)};
    return p;
}

static double torque(const ctl_friction_t *p, double speed) { return value_of(ctl_friction(p, num_of(speed))); }

void setUp(void) {}
void tearDown(void) {}

/* The logarithm errs by 3e-7, the shape takes it into the exponent; x 2^-x has its steepest logarithmic slope at 1/e. In
 * fixed point the ratio of the speeds has steps of 2^-24, too. */
void test_ctl_friction_matches_golden_in_both_directions(void)
{
    for (size_t k = 0; k < COUNT_OF(GOLDEN_FRICTION); k++) {
        const golden_friction_t *const g = &GOLDEN_FRICTION[k];
        const ctl_friction_t p = {num_of(g->viscous), num_of(g->coulomb), num_of(g->stat), num_of(g->stribeck), num_of(g->shape)};
        const double tolerance = per_numeric(1e-6, 2e-6) * (g->stat + g->viscous * g->speed) + per_numeric(0.0, 2.0 * FIXED_STEP);
        TEST_ASSERT_EQUAL(CTL_OK, ctl_friction_check(&p).status);

        ASSERT_DOUBLE_WITHIN_AT(tolerance, g->torque, torque(&p, g->speed), at("row %u", (unsigned)k));
        ASSERT_DOUBLE_WITHIN_AT(tolerance, -g->torque, torque(&p, -g->speed), at("row %u, backwards", (unsigned)k));
    }
}

void test_ctl_friction_at_standstill_is_nothing(void)
{
    const ctl_friction_t p = valid();

    TEST_ASSERT_EQUAL_DOUBLE(0.0, torque(&p, 0.0));
    TEST_ASSERT_EQUAL_DOUBLE(0.0, torque(&p, -0.0));
}

void test_ctl_friction_just_off_standstill_is_the_static_one(void)
{
    const ctl_friction_t p = valid();

    TEST_ASSERT_DOUBLE_WITHIN(2e-6, 0.457, torque(&p, 1e-6));
    TEST_ASSERT_DOUBLE_WITHIN(2e-6, -0.457, torque(&p, -1e-6));
}

void test_ctl_friction_far_above_the_stribeck_speed_is_coulomb_and_viscous(void)
{
    const ctl_friction_t p = valid();

    TEST_ASSERT_DOUBLE_WITHIN(3e-6, 0.387 + 0.0339 * 20.0, torque(&p, 20.0));
    TEST_ASSERT_DOUBLE_WITHIN(3e-6, -0.387 - 0.0339 * 20.0, torque(&p, -20.0));
}

void test_ctl_friction_is_odd_to_the_bit(void)
{
    const ctl_friction_t p = valid();
    noise_t              noise = {103U};
    for (int k = 0; k < 2000; k++) {
        const double v = 8.0 * noise_next(&noise);
        ASSERT_DOUBLE_WITHIN_AT(per_numeric(0.0, FIXED_STEP), -torque(&p, v), torque(&p, -v), at("at %g", v));
    }
}

/* slope: viscous, and at most (T_s - T_c) delta/v_s of Stribeck's fall */
void test_ctl_friction_is_continuous_and_falls_no_faster_than_its_slope(void)
{
    const ctl_friction_t p = valid();
    const double         step = 1.0 / 4096.0;
    for (double v = step; v < 4.0; v += step) {
        const double rise = torque(&p, v + step) - torque(&p, v);
        TEST_ASSERT_TRUE_MESSAGE(rise <= 0.0339 * step + 2e-6, at("rises too fast at %g", v));
        TEST_ASSERT_TRUE_MESSAGE(rise >= -0.07 * 1.957 / 0.551 * step - 2e-6, at("falls too fast at %g", v));
    }
}

void test_ctl_friction_stays_between_coulomb_and_static_plus_viscous(void)
{
    const ctl_friction_t p = valid();
    for (double v = 1e-4; v < 60.0; v *= 1.07) {
        const double dry = torque(&p, v) - 0.0339 * v;
        TEST_ASSERT_TRUE_MESSAGE((dry >= 0.387 - 4e-6) && (dry <= 0.457 + 4e-6), at("%.9g at %g", dry, v));
    }
}

void test_ctl_friction_of_a_speed_that_is_not_a_number_is_nothing(void)
{
    const ctl_friction_t p = valid();
    for (size_t k = 0; k < COUNT_OF(NOT_FINITE); k++) {
        TEST_ASSERT_EQUAL_DOUBLE(0.0, value_of(ctl_friction(&p, NOT_FINITE[k])));
    }
}

void test_ctl_friction_of_any_speed_is_bounded(void)
{
    ctl_friction_t p = valid();
    const double   shapes[] = {0.1, 1.0, 2.0, 10.0};
    for (size_t s = 0; s < COUNT_OF(shapes); s++) {
        p.shape = num_of(shapes[s]);
        for (size_t k = 0; k < COUNT_OF(NASTY); k++) {
            const double v = num_is_finite(NASTY[k]) ? fabs(value_of(NASTY[k])) : 0.0;
            ASSERT_BOUNDED_AT((0.457 + 0.0339 * v) * 1.00001, ctl_friction(&p, NASTY[k]), at("value %u", (unsigned)k));
        }
    }
}

/* ---- refused ---------------------------------------------------------------------------------------------------------- */

static void assert_refused(const ctl_friction_t *p, ctl_status_t status, uint16_t field)
{
    const ctl_diag_t got = ctl_friction_check(p);

    TEST_ASSERT_EQUAL(status, got.status);
    TEST_ASSERT_EQUAL(field, got.field);
}

void test_ctl_friction_check_accepts_the_paper_and_none_at_all(void)
{
    ctl_friction_t p = valid();
    assert_refused(&p, CTL_OK, 0U);
    p.viscous = p.coulomb = p.stat = (num_t)0;
    assert_refused(&p, CTL_OK, 0U);
}

void test_ctl_friction_check_without_parameters_is_null(void) { assert_refused(NULL, CTL_ERR_NULL, 0U); }

void test_ctl_friction_check_rejects_static_below_coulomb_and_names_it(void)
{
    ctl_friction_t p = valid();
    p.stat = num_of(0.3869);

    assert_refused(&p, CTL_ERR_RELATION, CTL_FRICTION_STATIC);
    TEST_ASSERT_EQUAL_DOUBLE(value_of(p.stat), value_of(ctl_friction_check(&p).given));
    p.stat = p.coulomb;
    assert_refused(&p, CTL_OK, 0U);
}

void test_ctl_friction_check_rejects_what_is_out_of_range_and_names_it(void)
{
    for (uint16_t f = CTL_FRICTION_VISCOUS; f <= CTL_FRICTION_SHAPE; f++) {
        for (size_t k = 0; k < COUNT_OF(NOT_FINITE) + 2U; k++) {
            ctl_friction_t p = valid();
            num_t *const   at_field[] = {NULL, &p.viscous, &p.coulomb, &p.stat, &p.stribeck, &p.shape};
            const num_t    bad = (k < COUNT_OF(NOT_FINITE)) ? NOT_FINITE[k] : num_of((k == COUNT_OF(NOT_FINITE)) ? -1e-3 : -50.0);
            *at_field[f] = bad;

            assert_refused(&p, CTL_ERR_RANGE, f);
        }
    }
}

void test_ctl_friction_check_limits_of_stribeck_speed_and_shape(void)
{
    ctl_friction_t p = valid();
    p.stribeck = (num_t)0;
    assert_refused(&p, CTL_ERR_RANGE, CTL_FRICTION_STRIBECK);
    p = valid();
    p.shape = num_of(0.0999);
    assert_refused(&p, CTL_ERR_RANGE, CTL_FRICTION_SHAPE);
    p.shape = num_of(10.001);
    assert_refused(&p, CTL_ERR_RANGE, CTL_FRICTION_SHAPE);
    p.shape = NUM_C(10.0f);
    assert_refused(&p, CTL_OK, 0U);
    p.shape = NUM_C(0.1f);
    assert_refused(&p, CTL_OK, 0U);
}
