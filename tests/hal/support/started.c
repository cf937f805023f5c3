#include "tests/hal/support/started.h"

hal_sample_t       sample;
hal_status_t       sample_status;
hal_encoder_edge_t edge;
hal_status_t       edge_status;
int                current_runs, speed_runs;
hal_duty_t         duty;

static void current_isr(void)
{
    port_current_begin();
    sample_status = hal_sample_read(&sample);
    edge_status = hal_encoder_edge(&edge);
    (void)hal_inverter_set_duty(&duty);
    current_runs++;
    port_current_end();
}

static void speed_isr(void)
{
    port_speed_begin();
    speed_runs++;
    port_speed_end();
}

void started(void)
{
    const hal_duty_t half = {0.5f, 0.5f, 0.5f};
    duty = half;
    current_runs = 0;
    speed_runs = 0;
    fake_power_on();
    TEST_ASSERT_EQUAL(PORT_OK, port_init());
    port_start(&current_isr, &speed_isr);
    period(); /* the first interrupt comes before anybody can arm */
    current_runs = 0;
}

void period(void)
{
    chip.cycles += 20000U;
    fake_pwm_zero();
}

void pass_ms(int ms)
{
    for (int i = 0; i < (10 * ms); i++) {
        period();
    }
    port_background();
}

void arm(void)
{
    TEST_ASSERT_EQUAL(HAL_OK, hal_inverter_arm());
    period();
}

bool all_gates_follow(void) { return fake_gate_follows(0) && fake_gate_follows(1) && fake_gate_follows(2); }
bool all_gates_low(void) { return fake_gate_is_low(0) && fake_gate_is_low(1) && fake_gate_is_low(2); }

void phase_currents(double a, double b, double c)
{
    const double amps[3] = {a, b, c};
    for (int k = 0; k < 3; k++) {
        chip.cmpss[k].volts = 1.65 + (0.07 * amps[k]);
    }
}
