#include "sim_host/referee/sensors.h"

#include <math.h>

static double wrapped(double x_rad)
{
    const double turn = 2.0 * REFEREE_PI;
    const double remainder = x_rad - (turn * floor(x_rad / turn));
    return (remainder < turn) ? remainder : 0.0;
}

static double converted(double i_a, double gain, double offset_a, const referee_parameters_t *p, referee_noise_t *noise)
{
    const double load = i_a / p->motor_rated_current_a;
    const double curved = i_a * (1.0 + (p->sensor_cubic_error_rel * load * load));
    const double seen = (gain * curved) + offset_a + (p->sensor_current_noise_a * referee_noise_normal(noise));
    return (p->sensor_current_lsb_a > 0.0) ? (p->sensor_current_lsb_a * nearbyint(seen / p->sensor_current_lsb_a)) : seen;
}

static double counted(const referee_machine_t *machine)
{
    const referee_parameters_t *const p = machine->p;
    const double                      true_rad = machine->theta_rad;
    const double                      counts = p->sensor_counts_per_rev;
    double                            rad = true_rad + (p->encoder_offset_angle_el_rad / p->motor_pole_pairs);
    rad += p->encoder_eccentricity_amplitude_rad * sin(true_rad + p->encoder_eccentricity_phase_rad);
    if (p->encoder_code_wheel_amplitude_rad != 0.0) {
        rad +=
            p->encoder_code_wheel_amplitude_rad * sin((p->encoder_code_wheel_order * true_rad) + p->encoder_code_wheel_phase_rad);
    }
    if (p->encoder_count_loss_counts_per_turn != 0.0 && counts > 0.0) { /* at the passage of zero */
        const double turns = floor(true_rad / (2.0 * REFEREE_PI)) - floor(p->motor_start_angle_rad / (2.0 * REFEREE_PI));
        rad -= turns * p->encoder_count_loss_counts_per_turn * 2.0 * REFEREE_PI / counts;
    }
    const double inside = wrapped(rad);
    if (counts <= 0.0) {
        return inside;
    }
    const double count_rad = 2.0 * REFEREE_PI / counts;
    return floor(inside / count_rad) * count_rad;
}

referee_sample_t referee_sensors_sample(const referee_machine_t *machine, referee_noise_t *noise)
{
    const referee_parameters_t *const p = machine->p;
    const double                      ia = machine->i_filtered_a.x;
    const double                      ib = -0.5 * machine->i_filtered_a.x + (0.5 * REFEREE_SQRT_3 * machine->i_filtered_a.y);
    referee_sample_t                  sample;
    sample.ia_a =
        converted(ia, p->current_gain_gain_a * p->sensor_gain_a, p->current_offset_offset_a_a + p->sensor_offset_a_a, p, noise);
    sample.ib_a =
        converted(ib, p->current_gain_gain_b * p->sensor_gain_b, p->current_offset_offset_b_a + p->sensor_offset_b_a, p, noise);
    sample.theta_m_rad = counted(machine);
    return sample;
}
