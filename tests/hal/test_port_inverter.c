/* The bridge: duties, arming, disarming, hardware faults. */
#include <math.h>

#include "tests/hal/support/started.h"

void setUp(void) { started(); }
void tearDown(void) {}

static void set(float a, float b, float c)
{
    const hal_duty_t d = {a, b, c};
    duty = d;
    period(); /* the interrupt of this period sets them... */
    period(); /* ...and this zero loads them */
}

void test_duty_is_high_side_time_centred_on_the_period_event(void)
{
    set(0.25f, 0.5f, 0.75f);

    TEST_ASSERT_EQUAL_UINT16(3750U, chip.epwm[0].compare_active);
    TEST_ASSERT_EQUAL_UINT16(2500U, chip.epwm[1].compare_active);
    TEST_ASSERT_EQUAL_UINT16(1250U, chip.epwm[2].compare_active);
    TEST_ASSERT_TRUE(chip.epwm[0].rises_on_up && chip.epwm[0].falls_on_down);
    TEST_ASSERT_DOUBLE_WITHIN(1e-9, 0.25, fake_duty(0));
}

void test_duty_takes_effect_at_the_next_zero_and_not_before(void)
{
    const hal_duty_t d = {0.2f, 0.2f, 0.2f};
    duty = d;
    period();
    TEST_ASSERT_DOUBLE_WITHIN(1e-9, 0.5, fake_duty(0));

    period();

    TEST_ASSERT_DOUBLE_WITHIN(1e-9, 0.2, fake_duty(0));
}

void test_duty_is_cut_where_the_shunts_would_no_longer_be_read(void)
{
    set(1.0f, 7.0f, 0.97f);

    for (int k = 0; k < 3; k++) {
        TEST_ASSERT_EQUAL_UINT16(150U, chip.epwm[k].compare_active); /* 3 % of 5000 */
    }
}

void test_duty_zero_keeps_its_events_off_the_turning_point(void)
{
    set(0.0f, -3.0f, NAN);

    for (int k = 0; k < 3; k++) { /* a pulse of 20 ns, which the dead band of 500 ns swallows */
        TEST_ASSERT_EQUAL_UINT16(4999U, chip.epwm[k].compare_active);
    }
}

void test_arm_lets_the_gates_follow_from_the_next_period_on(void)
{
    TEST_ASSERT_EQUAL(HAL_OK, hal_inverter_arm());
    TEST_ASSERT_TRUE(all_gates_low());

    period();

    TEST_ASSERT_TRUE(all_gates_follow());
}

void test_disarm_switches_every_gate_off_at_once(void)
{
    arm();

    hal_inverter_disarm();

    TEST_ASSERT_TRUE(all_gates_low());
    hal_inverter_disarm();
    period();
    TEST_ASSERT_TRUE(all_gates_low());
}

void test_disarm_takes_back_an_arming_that_has_not_begun(void)
{
    TEST_ASSERT_EQUAL(HAL_OK, hal_inverter_arm());
    hal_inverter_disarm();

    period();

    TEST_ASSERT_TRUE(all_gates_low());
}

void test_arm_looks_and_acts_with_interrupts_off(void)
{
    fake_forget_calls();

    TEST_ASSERT_EQUAL(HAL_OK, hal_inverter_arm());

    const int off = CALLED_AT_ALL("Interrupt_disableGlobal");
    const int look = CALLED_AFTER(off, "EPWM_getOneShotTripZoneFlagStatus", EPWM1_BASE);
    const int on = fake_find(off, "Interrupt_enableGlobal", 0, NULL);
    TEST_ASSERT_TRUE((off >= 0) && (look > off) && (on > look));
    TEST_ASSERT_FALSE(chip.intm);
}

void test_over_current_switches_off_without_the_cpu(void)
{
    arm();

    phase_currents(0.0, 18.2, -18.2);
    fake_trips(); /* no interrupt has run */

    TEST_ASSERT_TRUE(all_gates_low());
    TEST_ASSERT_EQUAL(HAL_INVERTER_OVER_CURRENT, hal_inverter_fault());
}

void test_negative_over_current_trips_as_well(void)
{
    arm();

    phase_currents(-18.2, 0.0, 0.0);
    fake_trips();

    TEST_ASSERT_TRUE(all_gates_low());
    TEST_ASSERT_EQUAL(HAL_INVERTER_OVER_CURRENT, hal_inverter_fault());
}

void test_current_below_the_threshold_does_not_trip(void)
{
    arm();

    phase_currents(17.8, -17.8, 0.0);
    period();

    TEST_ASSERT_TRUE(all_gates_follow());
    TEST_ASSERT_EQUAL(HAL_INVERTER_FINE, hal_inverter_fault());
}

void test_nfault_switches_off_without_the_cpu(void)
{
    arm();

    chip.drv[3] = 0x040; /* VREG_UV */
    fake_trips();

    TEST_ASSERT_TRUE(all_gates_low());
    TEST_ASSERT_EQUAL(HAL_INVERTER_DRIVER_FAULT, hal_inverter_fault());
}

void test_halt_with_the_bridge_off_is_no_fault_and_hides_none(void)
{
    fake_halt(1000000U);
    period();
    TEST_ASSERT_EQUAL(HAL_INVERTER_FINE, hal_inverter_fault());
    TEST_ASSERT_EQUAL(HAL_OK, hal_inverter_arm());
    hal_inverter_disarm();

    chip.drv[3] = 0x040; /* VREG_UV, while the processor stands */
    fake_halt(1000000U);
    TEST_ASSERT_EQUAL(HAL_INVERTER_DRIVER_FAULT, hal_inverter_fault());
}

void test_fault_stays_after_its_cause_has_gone(void)
{
    arm();
    phase_currents(19.0, 0.0, 0.0);
    fake_trips();
    phase_currents(0.0, 0.0, 0.0);
    period();

    TEST_ASSERT_EQUAL(HAL_INVERTER_OVER_CURRENT, hal_inverter_fault());
    TEST_ASSERT_EQUAL(HAL_SENSOR_FAULT, hal_inverter_arm());
    TEST_ASSERT_TRUE(all_gates_low());
}

void test_first_fault_is_the_one_that_is_kept(void)
{
    arm();
    phase_currents(19.0, 0.0, 0.0);
    fake_trips();
    TEST_ASSERT_EQUAL(HAL_INVERTER_OVER_CURRENT, hal_inverter_fault());
    chip.drv[2] = 0x400;
    fake_trips();

    TEST_ASSERT_EQUAL(HAL_INVERTER_OVER_CURRENT, hal_inverter_fault());
}

void test_cleared_fault_allows_arming_and_keeps_the_bridge_off_until_then(void)
{
    arm();
    phase_currents(19.0, 0.0, 0.0);
    fake_trips();
    phase_currents(0.0, 0.0, 0.0);

    hal_inverter_clear_fault();
    period();

    TEST_ASSERT_EQUAL(HAL_INVERTER_FINE, hal_inverter_fault());
    TEST_ASSERT_TRUE(all_gates_low());
    arm();
    TEST_ASSERT_TRUE(all_gates_follow());
}

void test_cleared_fault_comes_back_while_its_cause_stands(void)
{
    arm();
    phase_currents(19.0, 0.0, 0.0);
    fake_trips();

    hal_inverter_clear_fault();

    TEST_ASSERT_EQUAL(HAL_INVERTER_OVER_CURRENT, hal_inverter_fault());
}

void test_disarming_by_software_is_not_a_hardware_fault(void)
{
    arm();
    hal_inverter_disarm();

    TEST_ASSERT_EQUAL(HAL_INVERTER_FINE, hal_inverter_fault());
    TEST_ASSERT_EQUAL(HAL_OK, hal_inverter_arm());
}

static void a_period_begins(void) { period(); }

static void a_period_looks_for_faults(void)
{
    period();
    (void)hal_inverter_fault();
}

void test_disarm_wins_against_a_period_that_begins_meanwhile(void)
{
    for (int i = 0; i < 3; i++) { /* between any two modules */
        TEST_ASSERT_EQUAL(HAL_OK, hal_inverter_arm());
        chip.interrupted_call = "EPWM_forceTripZoneEvent";
        chip.calls_before = i;
        chip.interrupt = &a_period_begins;

        hal_inverter_disarm();

        TEST_ASSERT_NULL(chip.interrupted_call);
        TEST_ASSERT_TRUE(all_gates_low());
        period();
        TEST_ASSERT_TRUE(all_gates_low());
    }
}

void test_cleared_fault_is_not_found_again_by_an_interrupt_meanwhile(void)
{
    static const char *const CALL[] = {"CMPSS_clearFilterLatchHigh", "EPWM_clearOneShotTripZoneFlag", "EPWM_clearTripZoneFlag"};
    for (int i = 0; i < 3; i++) {
        arm();
        phase_currents(19.0, 0.0, 0.0);
        fake_trips();
        phase_currents(0.0, 0.0, 0.0);
        period();
        chip.interrupted_call = CALL[i];
        chip.interrupt = &a_period_looks_for_faults;

        hal_inverter_clear_fault();

        TEST_ASSERT_EQUAL_MESSAGE(HAL_INVERTER_FINE, hal_inverter_fault(), CALL[i]);
        TEST_ASSERT_TRUE(all_gates_low());
    }
}
