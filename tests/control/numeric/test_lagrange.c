/* control/numeric/lagrange.c against exact solutions of the moment equations, and what makes an interpolation one. */
#include "tests/support/numeric.h"

#include "control/numeric/lagrange.h"
#include "tests/control/golden/lagrange.h"

#define TAP_BOUND per_numeric(2.5e-7, 3.0 * FIXED_STEP) /* header of lagrange.h */

void setUp(void) {}
void tearDown(void) {}

void test_ctl_lagrange_matches_golden(void)
{
    for (size_t i = 0; i < COUNT_OF(GOLDEN_LAGRANGE); i++) {
        const golden_lagrange_t *const row = &GOLDEN_LAGRANGE[i];
        num_t                          a[CTL_LAGRANGE_TAPS];

        ctl_lagrange(row->order, num_of(row->f), a);

        ASSERT_NUM_WITHIN_AT(TAP_BOUND, row->a0, a[0], at("row %u, tap 0", (unsigned)i));
        ASSERT_NUM_WITHIN_AT(TAP_BOUND, row->a1, a[1], at("row %u, tap 1", (unsigned)i));
        ASSERT_NUM_WITHIN_AT(TAP_BOUND, row->a2, a[2], at("row %u, tap 2", (unsigned)i));
        ASSERT_NUM_WITHIN_AT(TAP_BOUND, row->a3, a[3], at("row %u, tap 3", (unsigned)i));
    }
}

void test_ctl_lagrange_of_every_fraction_delays_polynomials_of_its_order_exactly(void)
{
    for (uint16_t order = 0; order < CTL_LAGRANGE_TAPS; order++) {
        for (double f = 0.0; f <= order; f += 1.0 / 37.0) {
            const num_t given = num_of(f);
            num_t       a[CTL_LAGRANGE_TAPS];
            ctl_lagrange(order, given, a);
            for (uint16_t power = 0; power <= order; power++) { /* power 0: the taps sum to one */
                double moment = 0.0;
                for (uint16_t k = 0; k <= order; k++) {
                    moment += value_of(a[k]) * pow(k, power);
                }

                /* a tap's error counts with up to 1 + 2^power + 3^power */
                const double bound = TAP_BOUND * (1.0 + pow(2.0, power) + pow(3.0, power));
                ASSERT_DOUBLE_WITHIN_AT(bound, (order == 0U) ? 1.0 : pow(value_of(given), power), moment,
                                        at("order %u, power %u, f %g", order, power, f));
            }
        }
    }
}

void test_ctl_lagrange_of_a_whole_fraction_is_a_plain_delay(void)
{
    for (uint16_t order = 1; order < CTL_LAGRANGE_TAPS; order++) {
        for (uint16_t f = 0; f <= order; f++) {
            num_t a[CTL_LAGRANGE_TAPS];

            ctl_lagrange(order, num_of(f), a);

            for (uint16_t k = 0; k < CTL_LAGRANGE_TAPS; k++) {
                ASSERT_NUM_WITHIN_AT(TAP_BOUND, (k == f) ? 1.0 : 0.0, a[k], at("order %u, f %u, tap %u", order, f, k));
            }
        }
    }
}

void test_ctl_lagrange_taps_above_the_order_are_zero(void)
{
    for (uint16_t order = 0; order < CTL_LAGRANGE_TAPS; order++) {
        num_t a[CTL_LAGRANGE_TAPS] = {NUM_MAX, NUM_MAX, NUM_MAX, NUM_MAX};

        ctl_lagrange(order, num_of(0.375), a);

        for (uint16_t k = (uint16_t)(order + 1U); k < CTL_LAGRANGE_TAPS; k++) {
            ASSERT_NUM_WITHIN(0.0, 0.0, a[k]);
        }
    }
}

void test_ctl_lagrange_of_a_mirrored_fraction_is_mirrored(void)
{
    for (uint16_t order = 1; order < CTL_LAGRANGE_TAPS; order++) {
        num_t a[CTL_LAGRANGE_TAPS];
        num_t b[CTL_LAGRANGE_TAPS];

        ctl_lagrange(order, num_of(0.3125), a);
        ctl_lagrange(order, num_of(order - 0.3125), b);

        for (uint16_t k = 0; k <= order; k++) {
            ASSERT_NUM_WITHIN(2.0 * TAP_BOUND, value_of(a[k]), b[order - k]);
        }
    }
}

static void assert_same_taps(uint16_t order_a, num_t f_a, uint16_t order_b, num_t f_b)
{
    num_t a[CTL_LAGRANGE_TAPS];
    num_t b[CTL_LAGRANGE_TAPS];
    ctl_lagrange(order_a, f_a, a);
    ctl_lagrange(order_b, f_b, b);
    for (uint16_t k = 0; k < CTL_LAGRANGE_TAPS; k++) {
        ASSERT_NUM_WITHIN_AT(0.0, value_of(a[k]), b[k], at("order %u, tap %u", order_b, k));
    }
}

void test_ctl_lagrange_fraction_outside_of_the_order_is_cut_to_it(void)
{
    for (uint16_t order = 0; order < CTL_LAGRANGE_TAPS; order++) {
        assert_same_taps(order, num_of(order), order, num_of(order + 0.5));
        assert_same_taps(order, num_of(order), order, NUM_MAX);
        assert_same_taps(order, (num_t)0, order, num_of(-0.5));
        assert_same_taps(order, (num_t)0, order, -NUM_MAX);
    }
}

void test_ctl_lagrange_order_above_three_counts_as_three(void)
{
    assert_same_taps(3U, num_of(1.25), 4U, num_of(1.25));
    assert_same_taps(3U, num_of(1.25), UINT16_MAX, num_of(1.25));
}

void test_ctl_lagrange_of_what_is_not_a_number_is_finite(void)
{
    for (size_t i = 0; i < COUNT_OF(NOT_FINITE); i++) {
        for (uint16_t order = 0; order < CTL_LAGRANGE_TAPS; order++) {
            num_t a[CTL_LAGRANGE_TAPS];

            ctl_lagrange(order, NOT_FINITE[i], a);

            for (uint16_t k = 0; k < CTL_LAGRANGE_TAPS; k++) {
                ASSERT_BOUNDED_AT(1.0 + TAP_BOUND, a[k], at("case %u, order %u", (unsigned)i, order));
            }
        }
    }
#ifndef EVENSPIN_FIXED
    assert_same_taps(3U, 0.0f, 3U, NAN);
#endif
}
