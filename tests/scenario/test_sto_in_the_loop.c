/* Safe torque off of a turning motor: the gates are off from the period on in which a channel asks for it, and stay off. */
#include "tests/scenario/support/rig.h"

void setUp(void) { rig_new(); }
void tearDown(void) { rig_free(); }

void test_sto_of_a_turning_motor_ends_its_torque_at_once_and_for_good(void)
{
    for (double channels = 1.0; channels <= 3.0; channels += 1.0) {
        const double t[3] = {0.0, 0.3, 0.4};
        const double v[3] = {0.0, channels, 0.0};
        rig_new();
        rig_input("speed_ref_rad_s", 200.0);
        TEST_ASSERT_TRUE(es_sim_set_input(rig, "sto", t, v, 3, false));
        rig_start();
        rig_run(3000);
        TEST_ASSERT_DOUBLE_WITHIN(2.0, 200.0, rig_read("true_speed_rad_s"));
        const double gates = rig_read("gate_periods");
        rig_run(1);
        TEST_ASSERT_EQUAL_DOUBLE_MESSAGE(gates, rig_read("gate_periods"), at("channels %g", channels));
        rig_run(99);
        TEST_ASSERT_EQUAL_STRING("safe_torque_off", rig_fault()); /* and not what follows from it */
        TEST_ASSERT_EQUAL_DOUBLE(0.0, rig_read("true_iq_a"));
        rig_run(1900); /* closed again for 0.1 s */
        TEST_ASSERT_EQUAL_STRING("safe_torque_off", rig_fault());
        TEST_ASSERT_EQUAL_DOUBLE(gates, rig_read("gate_periods"));
        TEST_ASSERT_TRUE(rig_read("true_speed_rad_s") > 150.0); /* it coasts */
    }
}
