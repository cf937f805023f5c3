/* Counts to ampere and volt, three shunts of which two are enough, sequence numbers. */
#include <math.h>

#include "tests/hal/support/started.h"

#define LSB_A 0.01047f /* one count of the converter */

void setUp(void) { started(); }
void tearDown(void) {}

void test_zero_current_is_code_2253_and_not_half_of_the_range(void)
{
    phase_currents(0.0, 0.0, 0.0);

    period();

    TEST_ASSERT_EQUAL_UINT16(2252U, chip.result[0][0]);
    TEST_ASSERT_FLOAT_WITHIN(LSB_A, 0.0f, sample.ia_a);
    TEST_ASSERT_FLOAT_WITHIN(LSB_A, 0.0f, sample.ib_a);
    TEST_ASSERT_FLOAT_WITHIN(LSB_A, 0.0f, sample.ic_a);
}

void test_each_phase_reads_its_own_shunt_in_ampere(void)
{
    phase_currents(5.0, -7.0, 2.0);

    period();

    TEST_ASSERT_EQUAL(HAL_OK, sample_status);
    TEST_ASSERT_FLOAT_WITHIN(LSB_A, 5.0f, sample.ia_a);
    TEST_ASSERT_FLOAT_WITHIN(LSB_A, -7.0f, sample.ib_a);
    TEST_ASSERT_FLOAT_WITHIN(LSB_A, 2.0f, sample.ic_a);
}

void test_converter_clips_at_19_3_a_because_its_zero_is_not_in_the_middle(void)
{
    phase_currents(30.0, -30.0, 0.0);

    period();

    TEST_ASSERT_FLOAT_WITHIN(2.0f * LSB_A, 19.27f, sample.ia_a);
    TEST_ASSERT_FLOAT_WITHIN(2.0f * LSB_A, -23.57f, sample.ib_a);
}

void test_amplifier_offset_is_left_for_the_drive_to_calibrate(void)
{
    chip.cmpss[0].volts = 1.68; /* seen on the bench */

    period();

    TEST_ASSERT_FLOAT_WITHIN(LSB_A, 0.4286f, sample.ia_a); /* 30 mV x 14.286 A/V */
    port_limits_t limits;
    port_limits(&limits);
    TEST_ASSERT_TRUE(sample.ia_a < limits.offset_limit_a);
}

void test_dc_link_is_read_through_its_divider(void)
{
    chip.dc_link_pin_v = 24.0 / 13.42;

    period();

    TEST_ASSERT_FLOAT_WITHIN(0.01f /* count */, 24.0f, sample.vdc_v);
}

void test_limits_lie_where_the_converter_still_measures(void)
{
    port_limits_t limits;
    port_limits(&limits);

    TEST_ASSERT_TRUE(limits.over_current_a < 19.2f);
    TEST_ASSERT_TRUE(limits.over_voltage_v < 40.2f);
}

void test_sequence_counts_one_per_period(void)
{
    period();
    const uint32_t first = sample.seq;
    period();

    TEST_ASSERT_EQUAL_UINT32(first + 1U, sample.seq);
}

void test_second_read_in_one_period_is_stale(void)
{
    period();

    TEST_ASSERT_EQUAL(HAL_STALE, hal_sample_read(&sample));
}

void test_tripped_bridge_shows_in_the_status_of_the_sample_until_it_is_cleared(void)
{
    arm();
    period();
    TEST_ASSERT_EQUAL(HAL_OK, sample_status);

    phase_currents(0.0, 18.2, -18.2);
    fake_trips();
    period();
    TEST_ASSERT_EQUAL(HAL_TRIPPED, sample_status);
    TEST_ASSERT_FLOAT_WITHIN(LSB_A, 18.2f, sample.ib_a); /* good for all that */

    phase_currents(0.0, 0.0, 0.0);
    period();
    TEST_ASSERT_EQUAL(HAL_TRIPPED, sample_status);
    hal_inverter_clear_fault();
    period();
    TEST_ASSERT_EQUAL(HAL_OK, sample_status);
}

void test_sample_says_when_its_angle_was_taken(void)
{
    period();
    const uint32_t before = sample.at_cyc;
    period();

    TEST_ASSERT_UINT32_WITHIN(50U /* looks at the clock take time, too */, 20000U, sample.at_cyc - before);
}

void test_missed_period_shows_as_a_gap_and_the_converter_goes_on(void)
{
    period();
    const uint32_t before = sample.seq;
    chip.intm = true; /* something keeps interrupts off for two periods */
    period();
    period();
    chip.intm = false;
    fake_interrupts();
    TEST_ASSERT_EQUAL_UINT32(before + 2U, sample.seq);

    period();

    TEST_ASSERT_EQUAL_UINT32(before + 3U, sample.seq);
}

void test_phase_near_full_duty_is_calculated_from_the_other_two(void)
{
    for (int i = 0; i < 5; i++) {
        phase_currents(6.0, -4.0, -2.0);
        period();
    }
    const hal_duty_t high = {0.96f, 0.3f, 0.3f};
    duty = high;
    period();                   /* sets them */
    chip.cmpss[0].volts = 1.65; /* the shunt of phase a has not settled */

    period();

    TEST_ASSERT_FLOAT_WITHIN(4.0f * LSB_A, 6.0f, sample.ia_a);
    TEST_ASSERT_FLOAT_WITHIN(LSB_A, -4.0f, sample.ib_a);
}

void test_phase_is_calculated_with_the_offset_that_it_would_have_shown(void)
{
    /* offsets of 0.4, -0.2 and 0.3 A; the drive has calibrated on them */
    for (int i = 0; i < 1000; i++) {
        phase_currents(0.4, -0.2, 0.3);
        period();
    }
    const hal_duty_t high = {0.3f, 0.3f, 0.96f};
    duty = high;
    period();
    phase_currents(5.4, -3.2, 99.0);

    period();

    TEST_ASSERT_FLOAT_WITHIN(4.0f * LSB_A, -2.0f + 0.3f, sample.ic_a);
}

void test_phase_is_still_calculated_in_the_period_after_a_high_duty(void)
{
    const hal_duty_t high = {0.96f, 0.3f, 0.3f};
    const hal_duty_t low = {0.5f, 0.3f, 0.3f};
    phase_currents(0.0, 0.0, 0.0);
    period();
    duty = high;
    period(); /* set */
    duty = low;
    period(); /* loaded here; the sample at its end still has no settled shunt */
    phase_currents(9.0, -4.0, -2.0);
    period();
    TEST_ASSERT_FLOAT_WITHIN(4.0f * LSB_A, 6.0f, sample.ia_a);

    period();

    TEST_ASSERT_FLOAT_WITHIN(LSB_A, 9.0f, sample.ia_a);
}
