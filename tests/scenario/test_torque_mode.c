/* Torque mode on the machine: torque over inertia until the limit of the speed, which it holds without a step of the current. Default
 * motor: 0.0384 N m/A on 7.06e-5 kg m^2, 543.9 rad/s^2 per ampere. */
#include "tests/scenario/support/rig.h"

#define PER_AMP (1.5 * 4.0 * 6.4e-3 / 7.06e-5)

void setUp(void)
{
    rig_new();
    rig_model("viscous_nms", 0.0);
    rig_input("control_mode", 3.0);
}
void tearDown(void) { rig_free(); }

static double largest_step;

/* To the end of @p periods; the largest speed, and the largest step of the q current asked for from one speed sample to the next. */
static double watch(int periods)
{
    double top = 0.0;
    double before = rig_read("iq_ref_a");
    largest_step = 0.0;
    for (int k = 0; k < periods; k += 10) {
        rig_run(10);
        const double now = rig_read("iq_ref_a");
        largest_step = fmax(largest_step, fabs(now - before));
        before = now;
        top = fmax(top, fabs(rig_read("true_speed_rad_s")));
    }
    return top;
}

void test_torque_mode_accelerates_by_the_torque_asked_for_and_holds_the_limit_in_both_directions(void)
{
    for (int sign = -1; sign <= 1; sign += 2) {
        setUp();
        rig_input("iq_ref_a", 2.0 * sign);
        rig_input("speed_ref_rad_s", 150.0);
        rig_start();
        rig_run(500);
        TEST_ASSERT_DOUBLE_WITHIN(1e-4, 2.0 * sign, rig_read("iq_ref_a"));
        const double at_50ms = rig_read("true_speed_rad_s");
        rig_run(500);
        /* 0.05 s of 2 A; band: 2 A are 13.6 rad/s before the limit */
        TEST_ASSERT_DOUBLE_WITHIN(0.02 * 2.0 * PER_AMP * 0.05, 2.0 * sign * PER_AMP * 0.05,
                                  rig_read("true_speed_rad_s") - at_50ms);
        const double top = watch(8000);
        /* the loop of damping 0.9 swings over a step by 15 % at most (test_speed_control.c), of the 13.6 rad/s band and what the
         * dead time of 1.4 ms adds */
        TEST_ASSERT_TRUE_MESSAGE(top < 150.0 + 0.3 * 13.6, at("top %g", top));
        TEST_ASSERT_DOUBLE_WITHIN(0.3, 150.0 * sign, rig_read("true_speed_rad_s"));
        /* 0.147 A per rad/s: 1 rad/s and some encoder noise in a sample */
        TEST_ASSERT_TRUE_MESSAGE(largest_step < 0.3, at("step %g A", largest_step));
        TEST_ASSERT_EQUAL_STRING("none", rig_fault());
    }
}

/* A brake of 1 A takes it off the limit when less is asked for; then a torque of the other sign: the other limit. */
void test_torque_mode_leaves_the_limit_without_a_step(void)
{
    rig_input("iq_ref_a", 2.0);
    rig_step("load_brake_nm", 0.0, 0.6, 4.0 * 0.0384);
    rig_input("speed_ref_rad_s", 100.0);
    rig_start();
    (void)watch(5900);
    TEST_ASSERT_DOUBLE_WITHIN(0.3, 100.0, rig_read("true_speed_rad_s"));
    (void)watch(1500);
    TEST_ASSERT_DOUBLE_WITHIN(1e-3, 2.0, rig_read("iq_ref_a")); /* all that is asked for: the load is stronger */
    TEST_ASSERT_TRUE_MESSAGE(largest_step < 0.5,
                             at("step %g A", largest_step)); /* 1.1 rad/s in a sample by 2 A, and the ripple */
    TEST_ASSERT_EQUAL_STRING("none", rig_fault());
}

/* a load drives the shaft beyond the limit with no torque asked for: the drive holds it there */
void test_torque_mode_brakes_a_load_that_drives(void)
{
    rig_input("iq_ref_a", 0.0);
    rig_input("speed_ref_rad_s", 100.0);
    rig_input("load_torque_nm", -2.0 * 0.0384);
    rig_start();
    (void)watch(12000);
    TEST_ASSERT_DOUBLE_WITHIN(0.3, 100.0, rig_read("true_speed_rad_s"));
    TEST_ASSERT_DOUBLE_WITHIN(0.1, -2.0, rig_read("true_iq_a"));
    TEST_ASSERT_EQUAL_STRING("none", rig_fault());
}

/* The torque of 6 A of a machine with L_q = 2 L_d by the shortest vector: the same torque from less current, and a d current. */
void test_torque_mode_goes_with_most_torque_per_ampere(void)
{
    rig_param("mtpa", 1.0);
    rig_model("lq_h", 0.8e-3);
    rig_model("ld_h", 0.2e-3);
    rig_param("motor_lq_h", 0.8e-3);
    rig_param("motor_ld_h", 0.2e-3);
    rig_input("iq_ref_a", 6.0);
    rig_input("speed_ref_rad_s", 300.0);
    rig_model("rotor_locked", 1.0);
    rig_start();
    rig_run(1000);
    const double id = rig_read("true_id_a");
    const double iq = rig_read("true_iq_a");
    TEST_ASSERT_TRUE_MESSAGE(id < -0.5, at("id %g", id));
    TEST_ASSERT_DOUBLE_WITHIN(0.06, 6.0, iq * (1.0 + (0.2e-3 - 0.8e-3) / 6.4e-3 * id));
    TEST_ASSERT_TRUE(id * id + iq * iq < 36.0);
}

/* I2t in the machine, 10 A of a motor that bears 5 A for ever, time constant 2 s. To heat 0.9 it takes t1 = -2 ln(1 - 0.9/4) = 0.51 s;
 * from there heat' = (1 + 30 (1 - heat) - heat) / 2 gives 1 - heat = 0.1 exp(-15.5 (t - t1)), so that the current is
 * 5 sqrt(1 + 3 exp(-15.5 (t - t1))). */
void test_overload_of_the_machine_brings_the_current_down_to_the_continuous_one_without_a_trip(void)
{
    rig_input("control_mode", 0.0);
    rig_model("rotor_locked", 1.0);
    rig_param("motor_continuous_a", 5.0);
    rig_param("motor_thermal_s", 2.0);
    rig_input("iq_ref_a", 10.0);
    rig_start();
    const double t1 = -2.0 * log(1.0 - 0.9 / 4.0);
    rig_run((int64_t)(1e4 * (t1 - 0.02)));
    TEST_ASSERT_DOUBLE_WITHIN(0.05, 10.0, rig_read("true_iq_a"));
    double t = t1 - 0.02;
    for (int k = 0; k < 5; k++) {
        rig_run(700);
        t += 0.07;
        /* steps of half a percent of 10 A, 1 ms of sampling, and 4 ms from the first rise of the current */
        TEST_ASSERT_DOUBLE_WITHIN_MESSAGE(0.25, 5.0 * sqrt(1.0 + 3.0 * exp(-15.5 * (t - t1))), rig_read("true_iq_a"),
                                          at("%g s", t));
    }
    rig_run(20000);
    TEST_ASSERT_DOUBLE_WITHIN(0.05, 5.0, rig_read("true_iq_a"));
    TEST_ASSERT_DOUBLE_WITHIN(0.01, 1.0, rig_read("motor_heat"));
    TEST_ASSERT_EQUAL_STRING("none", rig_fault());
}

/* The motor warms up by 50 degrees a second, as its sensor has it: from 10 A at 100 degrees down a line that ends at 140, where it
 * trips. 1 ms of sampling, steps of half a percent of 10 A, and 4 ms until the current follows. */
void test_temperature_of_the_machine_brings_the_current_down_and_then_trips(void)
{
    const double t[3] = {0.0, 0.2, 2.2};
    const double celsius[3] = {100.0, 100.0, 200.0};
    rig_input("control_mode", 0.0);
    rig_model("rotor_locked", 1.0);
    rig_param("motor_derate_c", 100.0);
    rig_param("motor_trip_c", 140.0);
    rig_input("iq_ref_a", 10.0);
    TEST_ASSERT_TRUE(es_sim_set_input(rig, "motor_temperature_c", t, celsius, 3, true));
    rig_start();
    rig_run(2000);
    TEST_ASSERT_DOUBLE_WITHIN(0.05, 10.0, rig_read("true_iq_a"));
    rig_run(4000); /* 120 degrees */
    TEST_ASSERT_DOUBLE_WITHIN(0.12, 5.0, rig_read("true_iq_a"));
    rig_run(3980);
    TEST_ASSERT_EQUAL_STRING("none", rig_fault());
    TEST_ASSERT_DOUBLE_WITHIN(0.12, 0.05, rig_read("true_iq_a"));
    rig_run(220); /* 17 passes of the main loop, 1 ms each */
    TEST_ASSERT_EQUAL_STRING("motor_temperature", rig_fault());
}
