/* What the referee's drive sees. */
#include <math.h>
#include <unity.h>

#include "sim_host/referee/sensors.h"
#include "tests/sim_host/referee/support/defaults.h"

static referee_parameters_t p;
static referee_machine_t    machine;
static referee_noise_t      noise;

void setUp(void)
{
    p = plain_motor();
    p.sensor_counts_per_rev = 4000.0;
    referee_noise_seed(&noise, 7U);
}

void tearDown(void) {}

static referee_sample_t sample_at(double theta_rad)
{
    p.motor_start_angle_rad = theta_rad;
    referee_machine_init(&machine, &p);
    return referee_sensors_sample(&machine, &noise);
}

void test_referee_sensors_encoder_cuts_to_whole_counts(void)
{
    const double count = 2.0 * REFEREE_PI / 4000.0;

    TEST_ASSERT_DOUBLE_WITHIN(1e-12, 7.0 * count, sample_at(7.999 * count).theta_m_rad);
    TEST_ASSERT_DOUBLE_WITHIN(1e-12, 3999.0 * count, sample_at(-0.001 * count).theta_m_rad);
}

void test_referee_sensors_encoder_errors_add_to_the_angle(void)
{
    p.sensor_counts_per_rev = 0.0; /* no steps */
    p.encoder_offset_angle_el_rad = 0.3;
    p.encoder_eccentricity_amplitude_rad = 0.01;
    p.encoder_eccentricity_phase_rad = 0.2;

    TEST_ASSERT_DOUBLE_WITHIN(1e-12, 1.0 + (0.3 / 3.0) + (0.01 * sin(1.2)), sample_at(1.0).theta_m_rad);
}

void test_referee_sensors_counts_are_lost_turn_by_turn(void)
{
    p.encoder_count_loss_counts_per_turn = 4.0;
    p.motor_start_angle_rad = 0.1;
    referee_machine_init(&machine, &p);
    machine.theta_rad = 1.0 + (3.0 * 2.0 * REFEREE_PI);

    TEST_ASSERT_DOUBLE_WITHIN(2.0 * REFEREE_PI / 4000.0, 1.0 - (12.0 * 2.0 * REFEREE_PI / 4000.0),
                              referee_sensors_sample(&machine, &noise).theta_m_rad);
}

void test_referee_sensors_currents_have_gain_offset_and_steps(void)
{
    p.current_gain_gain_a = 1.1;
    p.current_offset_offset_b_a = 0.5;
    p.sensor_current_lsb_a = 0.25;
    referee_machine_init(&machine, &p);
    machine.i_filtered_a = (referee_vector_t){2.0, 0.0}; /* i_b = -1 */

    const referee_sample_t sample = referee_sensors_sample(&machine, &noise);

    TEST_ASSERT_EQUAL_DOUBLE(2.25, sample.ia_a); /* 2.2, in steps of 0.25 */
    TEST_ASSERT_EQUAL_DOUBLE(-0.5, sample.ib_a);
}

void test_referee_sensors_cubic_error_is_that_of_the_reading_at_rated_current(void)
{
    p.motor_rated_current_a = 4.0;
    p.sensor_cubic_error_rel = -0.1;
    referee_machine_init(&machine, &p);
    machine.i_filtered_a = (referee_vector_t){2.0, 0.0};

    TEST_ASSERT_DOUBLE_WITHIN(1e-12, 2.0 * (1.0 - (0.1 / 4.0)), referee_sensors_sample(&machine, &noise).ia_a);
    machine.i_filtered_a.x = -4.0;
    TEST_ASSERT_DOUBLE_WITHIN(1e-12, -4.0 * 0.9, referee_sensors_sample(&machine, &noise).ia_a);
}

void test_referee_noise_has_mean_0_and_deviation_1(void)
{
    double    sum = 0.0;
    double    squares = 0.0;
    double    fourth = 0.0;
    const int n = 200000;
    for (int k = 0; k < n; k++) {
        const double x = referee_noise_normal(&noise);
        sum += x;
        squares += x * x;
        fourth += x * x * x * x;
    }
    TEST_ASSERT_DOUBLE_WITHIN(0.01, 0.0, sum / n); /* 4.5 standard errors */
    TEST_ASSERT_DOUBLE_WITHIN(0.015, 1.0, squares / n);
    TEST_ASSERT_DOUBLE_WITHIN(0.1, 3.0, fourth / n); /* normal, not just any noise */
}
