/* What the vocabulary of the format does not have: each against a result by hand. */
#include <math.h>

#include "sim_host/referee/foreign.h"
#include "sim_host/referee/machine.h"
#include "unity.h"

#define H_S 1e-5

static referee_parameters_t p;

void setUp(void)
{
    p = (referee_parameters_t){.motor_pole_pairs = 3.0,
                               .motor_resistance_ohm = 1e6,
                               .motor_ld_h = 2e-3,
                               .motor_lq_h = 2e-3,
                               .motor_psi_wb = 0.1,
                               .motor_inertia_kgm2 = 1e-3,
                               .stribeck_friction_speed_rad_s = 1.0,
                               .resistance_drift_time_s = 1.0,
                               .friction_drift_time_s = 1.0,
                               .magnet_drift_time_s = 2.0,
                               .position_load_width_rad = 1.0,
                               .presliding_length_rad = 1.0};
}

void tearDown(void) {}

void test_referee_foreign_pump_brakes_with_the_square_of_the_speed_and_pulses_along_the_angle(void)
{
    p.pump_load_torque_nm_s2 = 2e-3;
    p.pump_load_pulse_rel = 0.5;
    p.pump_load_order = 5.0;
    TEST_ASSERT_DOUBLE_WITHIN(1e-12, 2e-3 * 100.0, referee_foreign_torque(&p, 0.0, 10.0));
    TEST_ASSERT_DOUBLE_WITHIN(1e-12, -2e-3 * 100.0 * 1.5, referee_foreign_torque(&p, REFEREE_PI / 10.0, -10.0));
}

void test_referee_foreign_load_at_a_position_falls_to_one_over_e_one_width_away(void)
{
    p.position_load_amplitude_nm = 0.3;
    p.position_load_centre_rad = 50.0;
    p.position_load_width_rad = 8.0;
    TEST_ASSERT_DOUBLE_WITHIN(1e-12, 0.3, referee_foreign_torque(&p, 50.0, 3.0));
    TEST_ASSERT_DOUBLE_WITHIN(1e-12, 0.3 * exp(-1.0), referee_foreign_torque(&p, 42.0, -3.0));
}

void test_referee_foreign_bristle_turns_over_within_a_few_lengths_after_a_reversal(void)
{
    p.presliding_torque_nm = 0.2;
    p.presliding_length_rad = 0.01;
    TEST_ASSERT_DOUBLE_WITHIN(1e-9, 0.2, referee_foreign_bristle(&p, 0.0, 0.5));
    /* from +T the other way: -T + 2 T exp(-x/l), zero after l ln 2; in many steps as in one */
    TEST_ASSERT_DOUBLE_WITHIN(1e-9, 0.0, referee_foreign_bristle(&p, 0.2, -0.01 * log(2.0)));
    double torque_nm = 0.2;
    for (int k = 0; k < 100; k++) {
        torque_nm = referee_foreign_bristle(&p, torque_nm, -1e-4 * log(2.0));
    }
    TEST_ASSERT_DOUBLE_WITHIN(1e-9, 0.0, torque_nm);
}

/* Shaft held at a speed by its inertia, phases open: the flux is what the voltage shows; here by its age alone. */
void test_referee_foreign_magnet_has_lost_63_percent_of_its_fall_after_one_time_constant(void)
{
    referee_machine_t machine;
    p.magnet_drift_fall_rel = 0.1;
    referee_machine_init(&machine, &p);
    referee_noise_t noise;
    referee_noise_seed(&noise, 1U);
    referee_machine_age(&machine, 2.0, 1e-4, &noise);
    TEST_ASSERT_DOUBLE_WITHIN(1e-12, 0.1 * (1.0 - 0.1 * (1.0 - exp(-1.0))), machine.psi_wb);
}

/* Without resistance the work of the voltage is energy of the field and work at the shaft: with a constant voltage that
 * brings the current from 0 to i on a locked rotor, the energy is that of the co-energy of the linkages. */
void test_referee_foreign_cross_saturation_keeps_energy_when_the_rotor_turns(void)
{
    p.motor_resistance_ohm = 0.0;
    p.motor_psi_wb = 0.0;
    p.motor_inertia_kgm2 = 1e9; /* turns evenly */
    p.cross_saturation_wb_per_a2 = 4e-5;
    referee_machine_t machine;
    referee_machine_init(&machine, &p);
    machine.speed_rad_s = 20.0;
    double work_j = 0.0;
    double shaft_j = 0.0;
    for (int k = 0; k < 20000; k++) {
        const double           t_s = k * H_S;
        const referee_vector_t v = {1.2 * cos(90.0 * t_s), 0.8 * sin(75.0 * t_s)};
        const referee_vector_t i0 = machine.i_a;
        referee_machine_step(&machine, H_S, v, 0.0, 0.0);
        work_j += 1.5 * H_S * ((v.x * 0.5 * (i0.x + machine.i_a.x)) + (v.y * 0.5 * (i0.y + machine.i_a.y)));
        shaft_j += H_S * machine.torque_nm * machine.speed_rad_s;
    }
    const double theta_e = 3.0 * machine.theta_rad;
    const double id = (machine.i_a.x * cos(theta_e)) + (machine.i_a.y * sin(theta_e));
    const double iq = (machine.i_a.y * cos(theta_e)) - (machine.i_a.x * sin(theta_e));
    /* energy of linkage_d = L id - k iq^2/2, linkage_q = L iq - k id iq: (L (id^2 + iq^2)) / 2 - k id iq^2, by i dlinkage */
    const double field_j = 1.5 * ((0.5 * 2e-3 * ((id * id) + (iq * iq))) - (4e-5 * id * iq * iq));
    TEST_ASSERT_DOUBLE_WITHIN(2e-3 * fabs(field_j) + 1e-6, field_j, work_j - shaft_j);
    TEST_ASSERT_TRUE(fabs(4e-5 * id * iq * iq) > 0.01 * fabs(field_j)); /* else nothing is tested */
}
