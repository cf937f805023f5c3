/* control/motor/dead_time.c: the compensation of each phase by hand, and the harmonics of the sum by the Fourier series of a square wave. */
#include "tests/support/numeric.h"

#include "control/motor/dead_time.h"

void setUp(void) {}
void tearDown(void) {}

static ctl_rotor_t rotor_at(double rad) { return (ctl_rotor_t){num_of(sin(rad)), num_of(cos(rad))}; }

/* Of the vector in the stationary frame. */
static void compensation(double amp, double theta, double volt, double soft, double *alpha, double *beta)
{
    const ctl_dq_t    i = {num_of(0.0), num_of(amp)};
    const ctl_rotor_t r = rotor_at(theta);
    ctl_dq_t          v;
    TEST_ASSERT_TRUE(ctl_dead_time(&i, &r, num_of(volt), num_of(1.0 / soft), &v));
    *alpha = value_of(v.d) * cos(theta) - value_of(v.q) * sin(theta);
    *beta = value_of(v.d) * sin(theta) + value_of(v.q) * cos(theta);
}

static double sat(double x) { return fmax(-1.0, fmin(1.0, x)); }

void test_ctl_dead_time_adds_to_each_phase_what_its_current_says(void)
{
    for (int k = 0; k < 73; k++) {
        const double theta = k * TWO_PI / 73.0;
        double       phase[3], alpha, beta;
        for (int x = 0; x < 3; x++) {
            phase[x] = 0.15 * sat(-2.0 * sin(theta - x * TWO_PI / 3.0) / 0.3);
        }
        compensation(2.0, theta, 0.15, 0.3, &alpha, &beta);
        /* amplitude-invariant; the common part of the three has no effect; ten products, each 1e-7 of 7 at most */
        TEST_ASSERT_DOUBLE_WITHIN(3e-6, (2.0 * phase[0] - phase[1] - phase[2]) / 3.0, alpha);
        TEST_ASSERT_DOUBLE_WITHIN(3e-6, (phase[1] - phase[2]) / sqrt(3.0), beta);
    }
}

/* Fourier: a square wave of height V has 4 V / (pi n) at every odd n; those that three phases have in common drop out. */
void test_ctl_dead_time_has_the_harmonics_of_the_square_waves_that_the_bridge_loses(void)
{
    const int N = 3600;
    for (int order = 1; order <= 13; order += 2) {
        double    re = 0.0, im = 0.0;
        const int sense = ((order % 3) == 1) ? 1 : -1; /* 1, 7, 13 turn with the rotor, 5 and 11 against it */
        for (int k = 0; k < N; k++) {
            const double theta = (k + 0.5) * TWO_PI / N;
            double       alpha, beta;
            compensation(2.0, theta, 0.15, 0.004, &alpha, &beta);
            const double at_rad = -sense * order * theta;
            re += (alpha * cos(at_rad) - beta * sin(at_rad)) / N;
            im += (alpha * sin(at_rad) + beta * cos(at_rad)) / N;
        }
        const double expected = ((order % 3) == 0) ? 0.0 : 4.0 * 0.15 / (0.5 * TWO_PI * order);
        ASSERT_DOUBLE_WITHIN_AT(2e-4, expected, hypot(re, im), at("order %d", order)); /* 3600 points of a jump */
    }
}

void test_ctl_dead_time_is_soft_near_zero_and_never_more_than_the_dead_time_takes(void)
{
    double alpha, beta;
    compensation(0.0, 0.4, 0.15, 0.1, &alpha, &beta);
    TEST_ASSERT_DOUBLE_WITHIN(1e-7, 0.0, hypot(alpha, beta));
    compensation(0.01, 0.4, 0.15, 0.1, &alpha, &beta);
    TEST_ASSERT_DOUBLE_WITHIN(1e-5, 0.015, hypot(alpha, beta)); /* a tenth of soft: a tenth of V, as a vector */
    noise_t noise = {5U};
    for (int k = 0; k < 5000; k++) {
        const ctl_dq_t    i = {noise_nasty(&noise), noise_nasty(&noise)};
        const ctl_rotor_t r = rotor_at(6.0 * noise_next(&noise));
        ctl_dq_t          v;
        const bool        good = ctl_dead_time(&i, &r, num_of(0.15), num_of(20.0), &v);
        TEST_ASSERT_EQUAL(num_is_finite(i.d) && num_is_finite(i.q), good);
        /* the longest vector of three phases within V is 4/3 V */
        TEST_ASSERT_TRUE(hypot(value_of(v.d), value_of(v.q)) <= 0.2 + 1e-5);
    }
}
