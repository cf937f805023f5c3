/* control/motor/fourier.c: against powers of e^(ix), and the slope against differences of the value. */
#include "tests/support/numeric.h"

#include "control/motor/fourier.h"
#include "tests/control/golden/fourier.h"

void setUp(void) {}
void tearDown(void) {}

/* sine and cosine within 3e-7, in 12 products */
void test_ctl_fourier_matches_golden(void)
{
    for (size_t k = 0; k < COUNT_OF(GOLDEN_FOURIER); k++) {
        const golden_fourier_t *const g = &GOLDEN_FOURIER[k];
        const ctl_fourier_t           f = {num_of(g->cos1), num_of(g->sin1), num_of(g->cos2), num_of(g->sin2)};
        num_t                         slope;
        const num_t                   value = ctl_fourier(&f, g->x, &slope);
        ASSERT_NUM_WITHIN_AT(3e-6, g->value, value, at("value, row %u", (unsigned)k));
        ASSERT_NUM_WITHIN_AT(4e-6, g->slope, slope, at("slope, row %u", (unsigned)k));
    }
}

void test_ctl_fourier_is_bounded_by_its_sizes_at_every_angle(void)
{
    const ctl_fourier_t f = {num_of(0.1), num_of(-0.1), num_of(0.1), num_of(0.1)};
    for (uint32_t k = 0U; k < 4096U; k++) {
        num_t slope;
        ASSERT_BOUNDED_AT(0.4, ctl_fourier(&f, k * UINT32_C(1048577), &slope), "value");
        ASSERT_BOUNDED_AT(0.6, slope, "slope"); /* below 1: an angle that is corrected by this still grows with the true one */
    }
}

void test_ctl_fourier_knows_whether_it_is_used_and_which_of_its_sizes_differs(void)
{
    const ctl_fourier_t none = {(num_t)0, (num_t)0, (num_t)0, (num_t)0};
    TEST_ASSERT_FALSE(ctl_fourier_is_used(&none));
    for (int k = 0; k < 4; k++) {
        ctl_fourier_t one = none;
        *((num_t *[]){&one.cos1, &one.sin1, &one.cos2, &one.sin2}[k]) = num_of(0.001);
        TEST_ASSERT_TRUE(ctl_fourier_is_used(&one));
        TEST_ASSERT_TRUE(ctl_fourier_differs(&none, &one));
        TEST_ASSERT_FALSE(ctl_fourier_differs(&one, &one));
    }
}
