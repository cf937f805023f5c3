/* The referee's inverter: what the volt-seconds of a period must be. */
#include <math.h>
#include <unity.h>

#include "sim_host/referee/bridge.h"
#include "tests/sim_host/referee/support/defaults.h"

static referee_parameters_t p;
static referee_machine_t    machine;

void setUp(void)
{
    p = plain_motor();
    p.motor_locked = 1.0;
    p.bridge_dc_link_v = 100.0;
}

void tearDown(void) {}

/* Current of phase a after `periods` with a constant voltage on alpha. */
static double settle(double v_alpha, int periods)
{
    referee_machine_init(&machine, &p);
    for (int n = 0; n < periods; n++) {
        referee_bridge_period(&machine, (referee_vector_t){v_alpha, 0.0}, p.bridge_dc_link_v, 0.0, n * 1e-4);
    }
    return machine.i_a.x;
}

void test_referee_bridge_edges_give_the_wanted_mean_voltage(void)
{
    p.bridge_edges = 1.0;

    /* 0.05 A: the ripple of a 100 us period at its start, which is not exactly the mean */
    TEST_ASSERT_DOUBLE_WITHIN(0.05, 5.0, settle(5.0, 600));
}

void test_referee_bridge_dead_time_costs_its_volt_seconds_against_each_current(void)
{
    /* i_a > 0, i_b = i_c < 0: phase losses -u, +u, +u with u = 3 us * 10 kHz * 100 V = 3 V: 4/3 u on alpha */
    p.dead_time_dead_time_s = 3e-6;
    const double average_a = settle(12.0, 600);
    p.bridge_edges = 1.0;
    const double edges_a = settle(12.0, 600);

    TEST_ASSERT_DOUBLE_WITHIN(1e-3, 12.0 - 4.0, average_a);
    TEST_ASSERT_DOUBLE_WITHIN(0.1, 12.0 - 4.0, edges_a); /* sampled off the middle by half the dead time */
}

/* i_a = i, i_b = i_c = -i/2 at rest under 1 ohm: 4 V = i + u (2 tanh(i / s) + 2 tanh(i / 2s)) / 3, u = 3 V, s = 2 A. */
void test_referee_bridge_a_soft_dead_time_loses_less_at_small_currents(void)
{
    p.dead_time_dead_time_s = 3e-6;
    p.dead_time_soft_a = 2.0;
    const double i_a = settle(4.0, 600);
    TEST_ASSERT_TRUE(i_a > 1.0); /* a hard one of 4 V lets nothing flow */
    TEST_ASSERT_DOUBLE_WITHIN(1e-3, 4.0, i_a + 2.0 * tanh(0.5 * i_a) + 2.0 * tanh(0.25 * i_a));
}

void test_referee_bridge_dead_time_holds_the_current_at_zero_below_its_loss(void)
{
    p.dead_time_dead_time_s = 3e-6;
    TEST_ASSERT_DOUBLE_WITHIN(0.01, 0.0, settle(2.0, 600)); /* below 4 V: nothing flows */
    TEST_ASSERT_DOUBLE_WITHIN(0.01, 0.0, settle(-2.0, 600));
}

void test_referee_bridge_a_sagging_link_scales_the_voltage(void)
{
    for (int edges = 0; edges < 2; edges++) {
        p.bridge_edges = edges;
        referee_machine_init(&machine, &p);
        for (int n = 0; n < 600; n++) {
            referee_bridge_period(&machine, (referee_vector_t){5.0, 0.0}, 80.0, 0.0, n * 1e-4);
        }
        TEST_ASSERT_DOUBLE_WITHIN(0.05, 4.0, machine.i_a.x);
    }
}
