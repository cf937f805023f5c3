/* control/motor/thermal.h: heating and cooling against the exponential, for any load. */
#include "control/motor/thermal.h"
#include "tests/support/numeric.h"

void setUp(void) {}
void tearDown(void) {}

static ctl_thermal_params_t params(double continuous_a, double tau_s)
{
    const ctl_thermal_params_t p = {(float)(1.0 / (continuous_a * continuous_a)), ctl_thermal_rate(1e-3f, (float)tau_s)};
    return p;
}

static double heated(const ctl_thermal_params_t *p, ctl_heat_t *heat, double amp, double time_s)
{
    for (long k = 0; k < lround(time_s * 1e3); k++) {
        ctl_thermal_step(p, heat, (float)(amp * amp));
    }
    return (double)ctl_thermal_heat(*heat);
}

/* 1.5e-4: Euler's step of 1 ms in a time constant of 10 s, half of it, and what a float makes of the square */
void test_thermal_heats_and_cools_along_the_exponential(void)
{
    const ctl_thermal_params_t p = params(5.0, 10.0);
    ctl_heat_t                 heat = 0;
    TEST_ASSERT_DOUBLE_WITHIN(1.5e-4, 4.0 * (1.0 - exp(-0.3)), heated(&p, &heat, 10.0, 3.0));
    const double hot = (double)ctl_thermal_heat(heat);
    TEST_ASSERT_DOUBLE_WITHIN(1.5e-4, hot * exp(-1.0), heated(&p, &heat, 0.0, 10.0));
    TEST_ASSERT_DOUBLE_WITHIN(1.5e-4, 1.0, heated(&p, &heat, 5.0, 120.0));
}

/* the time of a data sheet: an overload of twice the current for 30 s gives a time constant, which gives the time back */
void test_thermal_time_constant_of_an_overload_reaches_full_heat_in_its_time(void)
{
    const double               tau = -30.0 / log(1.0 - 0.25);
    const ctl_thermal_params_t p = params(3.0, tau);
    ctl_heat_t                 heat = 0;
    int                        k = 0;
    while ((ctl_thermal_heat(heat) < 1.0f) && (k < 40000)) {
        ctl_thermal_step(&p, &heat, 36.0f);
        k++;
    }
    TEST_ASSERT_INT_WITHIN(5, 30000, k);
}

/* a float of 1 takes no 1e-7 any more: an hour, close to its end */
void test_thermal_an_hour_is_no_longer_than_an_hour(void)
{
    const ctl_thermal_params_t p = params(1.0, 3600.0);
    ctl_heat_t                 heat = 0;
    TEST_ASSERT_DOUBLE_WITHIN(2e-4, 1.0 - exp(-3.0), heated(&p, &heat, 1.0, 10800.0)); /* rate: 1 in 1193 */
}

void test_thermal_no_load_leaves_it_outside_of_its_range(void)
{
    const ctl_thermal_params_t p = params(1.0, 0.002);
    const float                load[] = {NAN, INFINITY, -INFINITY, -1.0f, 1e30f, 0.0f};
    const double               at[] = {64.0, 64.0, 0.0, 0.0, 64.0, 0.0};
    for (size_t k = 0; k < COUNT_OF(load); k++) {
        ctl_heat_t heat = 0;
        for (int i = 0; i < 100; i++) {
            ctl_thermal_step(&p, &heat, load[k]);
        }
        TEST_ASSERT_DOUBLE_WITHIN(1e-5, at[k], (double)ctl_thermal_heat(heat));
    }
    const ctl_heat_t ends[] = {INT64_MAX, INT64_MIN, -1}; /* flipped bits */
    for (size_t k = 0; k < COUNT_OF(ends); k++) {
        ctl_heat_t heat = ends[k];
        for (int i = 0; i < 1000; i++) {
            ctl_thermal_step(&p, &heat, 1.0f);
        }
        TEST_ASSERT_DOUBLE_WITHIN(1e-5, 1.0, (double)ctl_thermal_heat(heat));
    }
}

void test_thermal_allowed_load_falls_on_a_line_from_all_to_the_continuous_one(void)
{
    TEST_ASSERT_EQUAL_FLOAT(4.0f, ctl_thermal_allowed(0.0f, 4.0f));
    TEST_ASSERT_EQUAL_FLOAT(4.0f, ctl_thermal_allowed(0.9f, 4.0f));
    TEST_ASSERT_DOUBLE_WITHIN(1e-5, 2.5, (double)ctl_thermal_allowed(0.95f, 4.0f));
    TEST_ASSERT_DOUBLE_WITHIN(1e-5, 1.0, (double)ctl_thermal_allowed(1.0f, 4.0f));
    TEST_ASSERT_DOUBLE_WITHIN(1e-5, 0.0, (double)ctl_thermal_allowed(1.05f, 4.0f));
    TEST_ASSERT_EQUAL_FLOAT(0.8f, ctl_thermal_allowed(1.5f, 0.8f)); /* a drive that cannot overload it */
}

/* a current that keeps to what is allowed meets 1 and does not pass it, whatever it may be */
void test_thermal_a_current_that_follows_the_line_does_not_overheat(void)
{
    for (double most = 1.1; most < 50.0; most *= 1.5) {
        const ctl_thermal_params_t p = params(1.0, 2.0);
        ctl_heat_t                 heat = 0;
        for (int k = 0; k < 60000; k++) {
            ctl_thermal_step(&p, &heat, ctl_thermal_allowed(ctl_thermal_heat(heat), (float)most));
            TEST_ASSERT_TRUE_MESSAGE(ctl_thermal_heat(heat) <= 1.0f, at("most %g, sample %d", most, k));
        }
        TEST_ASSERT_TRUE_MESSAGE(ctl_thermal_heat(heat) > 0.99f, at("most %g", most));
    }
}
