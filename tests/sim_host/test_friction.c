/* Forms that dry friction takes at standstill, against closed solutions of a rotor that nothing else acts on. */
#include "tests/sim_host/support/machine.h"

#define J_KGM2 7.06e-5
#define T_NM 0.0706 /* 1000 rad/s^2 */

void setUp(void)
{
    machine_defaults();
    model.viscous_nms = 0.0;
    model.psi_wb = 0.0; /* without magnets the motor has no torque */
    machine_set("coulomb_friction", "torque_nm", T_NM);
}
void tearDown(void) {}

/* J w' = -T tanh(w / s) is solved by sinh(w / s) = sinh(w0 / s) exp(-T t / (J s)). */
void test_friction_that_rises_with_the_speed_slows_a_rotor_down_ever_more_gently(void)
{
    const double w0[] = {20.0, -20.0, 0.5};
    for (size_t n = 0; n < COUNT_OF(w0); n++) {
        const double s = 2.0;
        machine_set("coulomb_friction", "smooth_rad_s", s);
        model.initial_speed_rad_s = w0[n];
        machine_start();
        for (int k = 1; k <= 300; k++) {
            machine_voltage(0.0, 0.0, 1);
            const double left = sinh(w0[n] / s) * exp(-1000.0 * 1e-4 * k / s);
            /* steps of T h / (J s) = 0.05: the fourth-order rule is off by 0.05^5 / 120 a step */
            TEST_ASSERT_DOUBLE_WITHIN_MESSAGE(1e-6, s * asinh(left), plant.x.speed_rad_s, at("%d after %g rad/s", k, w0[n]));
        }
    }
}

void test_friction_that_rises_with_the_speed_does_not_hold_a_shaft(void)
{
    const double s = 0.5;
    machine_set("coulomb_friction", "smooth_rad_s", s);
    machine_start();
    plant.outside.load_torque_nm = 0.5 * T_NM;
    machine_voltage(0.0, 0.0, 1000); /* time constant J s / T = 0.5 ms */
    TEST_ASSERT_DOUBLE_WITHIN(1e-6, -s * atanh(0.5), plant.x.speed_rad_s);
}

/* Dahl, exponent 1: over a travel x from rest friction is T (1 - exp(-x / l)); its work slows the rotor down. */
void test_friction_that_bends_before_it_slides_takes_the_work_of_its_travel(void)
{
    const double l = 0.01, w0 = 30.0;
    for (int sign = -1; sign <= 1; sign += 2) {
        machine_set("coulomb_friction", "presliding_rad", l);
        model.initial_speed_rad_s = w0 * sign;
        machine_start();
        for (int k = 1; k <= 250; k++) {
            machine_voltage(0.0, 0.0, 1);
            const double x = fabs(plant.x.theta_m_rad);
            const double work = T_NM * (x - l * (1.0 - exp(-x / l)));
            const double w = sqrt(w0 * w0 - 2.0 * work / J_KGM2);
            TEST_ASSERT_DOUBLE_WITHIN_MESSAGE(1e-5, w * sign, plant.x.speed_rad_s, at("period %d", k));
        }
    }
}

/* A motion that is small against l meets a spring T / l: w = w0 cos(W t) with W^2 = T / (l J), 44.7 rad/s here. The
 * largest travel is w0 / W = 0.45 mrad, where the spring is softer by x / 2l = 0.1 %. */
void test_friction_that_bends_is_a_spring_for_small_travels(void)
{
    const double l = 0.5, w0 = 0.02;
    const double omega = sqrt(T_NM / (l * J_KGM2));
    machine_set("coulomb_friction", "presliding_rad", l);
    model.initial_speed_rad_s = w0;
    machine_start();
    for (int k = 1; k <= 3000; k++) {
        machine_voltage(0.0, 0.0, 1);
        TEST_ASSERT_DOUBLE_WITHIN_MESSAGE(0.005 * w0, w0 * cos(omega * 1e-4 * k), plant.x.speed_rad_s, at("period %d", k));
    }
}

void test_friction_that_bends_lets_go_of_a_shaft_with_its_whole_torque(void)
{
    machine_set("coulomb_friction", "presliding_rad", 1e-3);
    machine_start();
    plant.outside.load_torque_nm = -2.0 * T_NM;
    machine_voltage(0.0, 0.0, 500);
    /* 1000 rad/s^2 from the beginning, and the work saved while bending: w^2 / 2 = 1000 (x + l) */
    const double x = plant.x.theta_m_rad;
    TEST_ASSERT_TRUE(x > 1.0);
    TEST_ASSERT_DOUBLE_WITHIN(1e-4, sqrt(2.0 * 1000.0 * (x + 1e-3)), plant.x.speed_rad_s);
}

/* Behind a coupling the rotor meets it, too: held by a stiff one, both turn as one piece. */
void test_friction_that_bends_acts_on_the_rotor_of_two_masses(void)
{
    machine_set("coulomb_friction", "presliding_rad", 0.01);
    machine_set("two_mass", "f_res_hz", 800.0);
    machine_set("two_mass", "load_ratio", 0.5);
    machine_set("two_mass", "damping_ratio", 0.5);
    model.initial_speed_rad_s = 30.0;
    machine_start();
    machine_voltage(0.0, 0.0, 200);
    const double x = 0.5 * (plant.x.theta_m_rad + plant.x.theta_m_rad + plant.load.twist_rad);
    const double work = T_NM * (x - 0.01 * (1.0 - exp(-x / 0.01)));
    TEST_ASSERT_DOUBLE_WITHIN(0.02, sqrt(900.0 - 2.0 * work / J_KGM2), plant.x.speed_rad_s);
}
