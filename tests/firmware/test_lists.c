/* firmware/app/faults.c and telemetry.c: the lists, and what each signal shows. */
#include "firmware/app/telemetry.h"
#include "mock_hal_clock.h"
#include "mock_hal_encoder.h"
#include "mock_hal_inverter.h"
#include "mock_hal_limits.h"
#include "mock_hal_sample.h"
#include "tests/firmware/support/bench.h"

void setUp(void) { bench_start(); }
void tearDown(void) {}

static double shown(uint16_t signal) { return (double)telemetry_read(&drive, signal); }

/* ---- faults --------------------------------------------------------------------------------------------------------- */

void test_faults_first_row_is_no_fault(void)
{
    TEST_ASSERT_EQUAL_INT(0, FAULT_none);
    TEST_ASSERT_EQUAL_STRING("none", faults_info(0)->name);
}

void test_faults_every_fault_has_a_name_a_cause_and_a_first_thing_to_check(void)
{
    for (uint16_t i = 1U; i < (uint16_t)FAULT_COUNT; i++) {
        const fault_info_t *const f = faults_info(i);
        TEST_ASSERT_TRUE_MESSAGE(strlen(f->name) > 3U, f->name);
        TEST_ASSERT_TRUE_MESSAGE(strlen(f->cause) > 10U, f->name);
        TEST_ASSERT_TRUE_MESSAGE(strlen(f->check) > 10U, f->name);
        for (uint16_t k = 0U; k < i; k++) {
            TEST_ASSERT_TRUE_MESSAGE(strcmp(f->name, faults_info(k)->name) != 0, f->name);
        }
    }
}

void test_faults_beyond_the_list_there_is_none(void)
{
    TEST_ASSERT_NULL(faults_info(FAULT_COUNT));
    TEST_ASSERT_NULL(faults_info(UINT16_MAX));
}

void test_faults_number_of_a_fault_is_its_row(void)
{
    TEST_ASSERT_EQUAL_STRING("over_current", faults_info(FAULT_over_current)->name);
    TEST_ASSERT_EQUAL_STRING("isr_overrun", faults_info(FAULT_isr_overrun)->name);
}

/* ---- telemetry ------------------------------------------------------------------------------------------------------ */

void test_telemetry_every_signal_is_named_and_explained_once(void)
{
    for (uint16_t i = 0U; i < (uint16_t)SIGNAL_COUNT; i++) {
        const signal_info_t *const s = telemetry_info(i);
        TEST_ASSERT_TRUE_MESSAGE(strlen(s->name) > 2U, s->name);
        TEST_ASSERT_TRUE_MESSAGE(strlen(s->doc) > 5U, s->name);
        TEST_ASSERT_NOT_NULL_MESSAGE(s->unit, s->name);
        for (uint16_t k = 0U; k < i; k++) {
            TEST_ASSERT_TRUE_MESSAGE(strcmp(s->name, telemetry_info(k)->name) != 0, s->name);
        }
    }
    TEST_ASSERT_NULL(telemetry_info(SIGNAL_COUNT));
    TEST_ASSERT_NULL(telemetry_info(UINT16_MAX));
}

void test_telemetry_beyond_the_list_reads_zero(void)
{
    bench_into(DRIVE_RUN);

    TEST_ASSERT_EQUAL_DOUBLE(0.0, shown(SIGNAL_COUNT));
    TEST_ASSERT_EQUAL_DOUBLE(0.0, shown(UINT16_MAX));
}

void test_telemetry_every_signal_is_a_number_in_every_state(void)
{
    for (int state = DRIVE_INIT; state <= DRIVE_FAULT; state++) {
        bench_start();
        bench_into((drive_state_t)state);
        bench_periods(25U);
        for (uint16_t i = 0U; i < (uint16_t)SIGNAL_COUNT; i++) {
            TEST_ASSERT_TRUE_MESSAGE(isfinite(shown(i)), at("%s in state %d", telemetry_info(i)->name, state));
        }
        TEST_ASSERT_EQUAL_DOUBLE((double)state, shown(SIGNAL_state));
    }
}

void test_telemetry_shows_the_sample_and_the_currents_in_the_frame_of_the_drive(void)
{
    const double theta_m = 1.1;
    bench_into(DRIVE_RUN);
    bench_command(DRIVE_MODE_CURRENT, 0.0, 0.25, -1.5);
    bench_angle(theta_m);
    bench_currents(0.75, 2.5, 4.0 * theta_m);
    bench.sample.vdc_v = 22.5f;

    bench_period();

    /* floats of the sample; 5e-6: 3 operations on numbers up to 2.5, or 4 steps of 6e-8 of the base of 10 A */
    TEST_ASSERT_EQUAL_FLOAT(bench.sample.ia_a, (float)shown(SIGNAL_ia_a));
    TEST_ASSERT_EQUAL_FLOAT(bench.sample.ib_a, (float)shown(SIGNAL_ib_a));
    TEST_ASSERT_EQUAL_FLOAT(1.1f, (float)shown(SIGNAL_theta_m_rad));
    TEST_ASSERT_EQUAL_FLOAT(22.5f, (float)shown(SIGNAL_vdc_v));
    TEST_ASSERT_DOUBLE_WITHIN(5e-6, 0.75, shown(SIGNAL_id_a));
    TEST_ASSERT_DOUBLE_WITHIN(5e-6, 2.5, shown(SIGNAL_iq_a));
    TEST_ASSERT_DOUBLE_WITHIN(1e-6, 0.25, shown(SIGNAL_id_ref_a));
    TEST_ASSERT_DOUBLE_WITHIN(1e-6, -1.5, shown(SIGNAL_iq_ref_a));
    /* 0.6 V/A on the errors -0.5 A and -4 A */
    TEST_ASSERT_DOUBLE_WITHIN(1e-5, -0.3, shown(SIGNAL_vd_v));
    TEST_ASSERT_DOUBLE_WITHIN(1e-5, -2.4, shown(SIGNAL_vq_v));
}

void test_telemetry_counts_lost_samples_and_shows_the_duration_of_the_interrupt(void)
{
    bench_into(DRIVE_RUN);
    bench.isr_cyc = 1234U;
    bench_period();
    bench.sample_status = HAL_STALE;
    bench_periods(2U);

    TEST_ASSERT_EQUAL_DOUBLE(2.0, shown(SIGNAL_rejected_count));
    TEST_ASSERT_EQUAL_DOUBLE(1234.0, shown(SIGNAL_isr_cycles));
}

void test_telemetry_shows_the_fault_by_its_number(void)
{
    bench_into(DRIVE_RUN);
    bench.inverter_fault = HAL_INVERTER_OVER_TEMPERATURE;
    bench_period();

    TEST_ASSERT_EQUAL_DOUBLE((double)FAULT_over_temperature, shown(SIGNAL_fault));
    TEST_ASSERT_EQUAL_DOUBLE((double)DRIVE_FAULT, shown(SIGNAL_state));
}
