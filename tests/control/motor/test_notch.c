/* control/motor/notch.c: against the polynomials of its transfer function, its gain at single frequencies, and what it does with
 * anything that is not a number. */
#include "tests/support/numeric.h"

#include "control/motor/notch.h"
#include "tests/control/golden/notch.h"

static ctl_notch_params_t p;
static ctl_notch_state_t  s;

static void start(double cycles, double damping, double depth)
{
    ctl_notch_design(&p, (float)cycles, (float)damping, (float)depth);
    TEST_ASSERT_EQUAL(CTL_OK, ctl_notch_check(&p).status);
    ctl_notch_reset(&s, (num_t)0);
}

void setUp(void) {}
void tearDown(void) {}

/* rounding of a sum of three products, times the gain 1 / (1 + a1 + a2) that it has on its way round: 300 at a hundredth of the rate */
void test_ctl_notch_matches_golden(void)
{
    size_t k = 0;
    while (k < COUNT_OF(GOLDEN_NOTCH)) {
        const golden_notch_t *const g = &GOLDEN_NOTCH[k];
        noise_t                     noise = {53U};
        start(g->cycles, g->damping, g->depth);
        for (uint32_t row = 0U; row < 120U; row++) {
            const num_t y = ctl_notch_step(&p, &s, num_of(noise_next(&noise) + ((row >= 60U) ? 0.25 : 0.0)));
            if ((row % 4U) == 0U) {
                TEST_ASSERT_EQUAL_UINT32(row, GOLDEN_NOTCH[k].row);
                ASSERT_NUM_WITHIN_AT(2e-5, GOLDEN_NOTCH[k].out, y, at("row %u", (unsigned)k));
                k++;
            }
        }
    }
}

static double gain(double cycles)
{
    double most = 0.0;
    for (int k = 0; k < 6000; k++) {
        const double y = value_of(ctl_notch_step(&p, &s, num_of(sin(TWO_PI * cycles * k))));
        most = ((k > 4000) && (fabs(y) > most)) ? fabs(y) : most;
    }
    return most;
}

/* |H| of (1) at the frequency that the bilinear transform makes of f: tan(pi f) / tan(pi f0) of the centre */
static double expected_gain(double f, double f0, double damping, double depth)
{
    const double r = tan(0.5 * TWO_PI * f) / tan(0.5 * TWO_PI * f0);
    return hypot(1.0 - r * r, 2.0 * depth * damping * r) / hypot(1.0 - r * r, 2.0 * damping * r);
}

void test_ctl_notch_has_its_depth_at_the_centre_and_nothing_far_from_it(void)
{
    static const double F[] = {0.005, 0.03, 0.0501, 0.061, 0.0703, 0.2001, 0.4503};
    for (size_t k = 0; k < COUNT_OF(F); k++) {
        start(0.061, 0.3, 0.1);
        /* the largest of samples that do not meet the crest: 1 - cos(pi / 8) at worst of a period, less over many */
        ASSERT_DOUBLE_WITHIN_AT(0.004, expected_gain(F[k], 0.061, 0.3, 0.1), gain(F[k]), at("%g", F[k]));
    }
    start(0.061, 0.3, 0.0);
    TEST_ASSERT_DOUBLE_WITHIN(2e-5, 0.0, gain(0.061));
}

void test_ctl_notch_leaves_a_constant_as_it_is(void)
{
    start(0.01, 0.05, 0.0);
    ctl_notch_reset(&s, num_of(3.25));
    for (int k = 0; k < 1000; k++) {
        ASSERT_NUM_WITHIN(2e-5, 3.25, ctl_notch_step(&p, &s, num_of(3.25)));
    }
}

void test_ctl_notch_of_what_is_not_finite_goes_on_with_the_value_before(void)
{
    for (size_t k = 0; k < COUNT_OF(NOT_FINITE); k++) {
        start(0.06, 0.3, 0.1);
        ctl_notch_state_t other = s;
        (void)ctl_notch_step(&p, &s, num_of(0.5));
        (void)ctl_notch_step(&p, &other, num_of(0.5));
        const num_t with = ctl_notch_step(&p, &s, NOT_FINITE[k]);
        const num_t same = ctl_notch_step(&p, &other, num_of(0.5));
        TEST_ASSERT_TRUE(with == same);
    }
}

void test_ctl_notch_is_bounded_by_eight_times_its_largest_input(void)
{
    for (int each = 0; each < 4; each++) {
        noise_t noise = {91U};
        start((each % 2) ? 0.008 : 0.4, (each / 2) ? 1.0 : 0.05, 0.0);
        for (int k = 0; k < 4000; k++) {
            const num_t x = ((noise_bits(&noise) & 0x100000U) != 0U) ? num_of(2.0) : num_of(-2.0);
            ASSERT_BOUNDED_AT(16.0, ctl_notch_step(&p, &s, x), at("case %d", each));
        }
    }
}

void test_ctl_notch_stays_a_number_whatever_comes(void)
{
    noise_t noise = {17U};
    start(0.06, 0.3, 0.1);
    for (int k = 0; k < 20000; k++) {
        TEST_ASSERT_TRUE(num_is_finite(num_mul(ctl_notch_step(&p, &s, noise_nasty(&noise)), NUM_C(0.01f))));
    }
    for (int k = 0; k < 4000; k++) {
        (void)ctl_notch_step(&p, &s, num_of(0.5));
    }
    ASSERT_NUM_WITHIN(1e-3, 0.5, ctl_notch_step(&p, &s, num_of(0.5)));
}

void test_ctl_notch_check_refuses_what_is_not_stable(void)
{
    start(0.06, 0.3, 0.1);
    const ctl_notch_params_t good = p;
    ASSERT_DIAG(CTL_ERR_NULL, 0U, 0.0, ctl_notch_check(NULL));
    p.a2 = num_of(1.0);
    TEST_ASSERT_EQUAL(CTL_NOTCH_A2, ctl_notch_check(&p).field);
    p = good;
    p.a1 = num_of(-1.0 - value_of(p.a2));
    TEST_ASSERT_EQUAL(CTL_ERR_RELATION, ctl_notch_check(&p).status);
    p = good;
    p.mean = num_of(1.1);
    TEST_ASSERT_EQUAL(CTL_NOTCH_MEAN, ctl_notch_check(&p).field);
    p.mean = num_of(0.4);
    ASSERT_DIAG(CTL_ERR_RANGE, CTL_NOTCH_MEAN, value_of(p.mean), ctl_notch_check(&p));
    p = good;
    for (int sign = -1; sign <= 1; sign += 2) { /* beyond what any a2 makes stable, whatever a2 is */
        p.a1 = num_of(2.5 * sign);
        ASSERT_DIAG(CTL_ERR_RANGE, CTL_NOTCH_A1, 2.5 * sign, ctl_notch_check(&p));
        p.a1 = good.a1;
        p.a2 = num_of(1.25 * sign);
        ASSERT_DIAG(CTL_ERR_RANGE, CTL_NOTCH_A2, 1.25 * sign, ctl_notch_check(&p));
        p = good;
    }
    for (size_t k = 0; k < COUNT_OF(NOT_FINITE); k++) {
        p = good;
        p.a1 = NOT_FINITE[k];
        TEST_ASSERT_EQUAL(CTL_NOTCH_A1, ctl_notch_check(&p).field);
    }
}
