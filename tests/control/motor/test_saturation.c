/* control/motor/saturation.c: the slope of a flux linkage that saturates, by its inverse tangent. */
#include "tests/support/numeric.h"

#include "control/motor/saturation.h"

void setUp(void) {}
void tearDown(void) {}

static ctl_saturation_params_t with(double i_sat, double cross)
{
    return (ctl_saturation_params_t){num_of(1.0 / i_sat), num_of(cross)};
}

static void shares(const ctl_saturation_params_t *p, double d, double q, double *out_d, double *out_q)
{
    const ctl_dq_t i = {num_of(d), num_of(q)};
    ctl_dq_t       share;
    TEST_ASSERT_TRUE(ctl_saturation(p, &i, &share));
    *out_d = value_of(share.d);
    *out_q = value_of(share.q);
}

/* The linkage of an axis is L i_sat atan(i / i_sat); its slope by a central difference, whose error is h^2 / 6 times the third derivative. */
void test_ctl_saturation_is_the_slope_of_the_flux_linkage(void)
{
    const ctl_saturation_params_t p = with(8.0, 0.0);
    for (double i = -22.0; i <= 22.0; i += 0.7) {
        const double h = 1e-3, slope = 8.0 * (atan((i + h) / 8.0) - atan((i - h) / 8.0)) / (2.0 * h);
        double       d, q;
        shares(&p, i, 3.0, &d, &q);
        ASSERT_DOUBLE_WITHIN_AT(1e-6, slope, d, at("%g A", i));
        TEST_ASSERT_DOUBLE_WITHIN(1e-6, 1.0 / (1.0 + 9.0 / 64.0), q); /* its own current alone */
    }
}

void test_ctl_saturation_halves_at_its_current_alone_or_as_the_amplitude_of_both_axes(void)
{
    double                  d, q;
    ctl_saturation_params_t p = with(5.0, 0.0);
    shares(&p, 5.0, -5.0, &d, &q);
    TEST_ASSERT_DOUBLE_WITHIN(1e-6, 0.5, d);
    TEST_ASSERT_DOUBLE_WITHIN(1e-6, 0.5, q);
    p = with(5.0, 1.0);
    shares(&p, 3.0, -4.0, &d, &q);
    TEST_ASSERT_DOUBLE_WITHIN(1e-6, 0.5, d);
    TEST_ASSERT_DOUBLE_WITHIN(1e-6, 0.5, q);
    p = with(5.0, 0.5);
    shares(&p, 3.0, 4.0, &d, &q);
    TEST_ASSERT_DOUBLE_WITHIN(1e-6, 25.0 / (25.0 + 9.0 + 8.0), d);
    TEST_ASSERT_DOUBLE_WITHIN(1e-6, 25.0 / (25.0 + 16.0 + 4.5), q);
    p = (ctl_saturation_params_t){num_of(0.0), num_of(1.0)};
    shares(&p, 30.0, 40.0, &d, &q);
    TEST_ASSERT_DOUBLE_WITHIN(1e-7, 1.0, d);
    TEST_ASSERT_DOUBLE_WITHIN(1e-7, 1.0, q);
}

void test_ctl_saturation_stays_between_a_tenth_and_one_for_any_current(void)
{
    const double least = value_of(CTL_SATURATION_LEAST);
    noise_t      noise = {7U};
    for (int k = 0; k < 5000; k++) {
        const ctl_dq_t                i = {noise_nasty(&noise), noise_nasty(&noise)};
        const ctl_saturation_params_t p = {num_of(0.01 + 100.0 * fabs(noise_next(&noise))), num_of(fabs(noise_next(&noise)))};
        ctl_dq_t                      share;
        TEST_ASSERT_EQUAL(num_is_finite(i.d) && num_is_finite(i.q), ctl_saturation(&p, &i, &share));
        TEST_ASSERT_TRUE(value_of(share.d) >= least && value_of(share.d) <= 1.0);
        TEST_ASSERT_TRUE(value_of(share.q) >= least && value_of(share.q) <= 1.0);
    }
    double                        d, q;
    const ctl_saturation_params_t p = with(1.0, 1.0);
    shares(&p, 3.1, 0.0, &d, &q);
    TEST_ASSERT_DOUBLE_WITHIN(1e-7, 0.1, d);
}
