/* The board says how long the interrupts take: what the drive measures, shows, and does about it. */
#include "tests/scenario/support/rig.h"

#define BIN_CYC 512

void setUp(void)
{
    rig_new();
    rig_input("speed_ref_rad_s", 31.4);
    rig_input("load_brake_nm", 0.03);
}
void tearDown(void) { rig_free(); }

/* The two counts of a bin of the histograms; a row shows one, the next row the next. */
static void histogram(int bin, double *current, double *speed)
{
    for (int k = 0; (k < 20) && (rig_read("isr_bin") != (double)bin); k++) {
        rig_run(1);
    }
    TEST_ASSERT_EQUAL_DOUBLE((double)bin, rig_read("isr_bin"));
    *current = rig_read("isr_bin_count");
    *speed = rig_read("speed_isr_bin_count");
}

void test_interrupt_load_is_what_the_drive_measures(void)
{
    rig_input("isr_load_cyc", 2378.0);
    rig_input("speed_isr_load_cyc", 1707.0);
    rig_start();
    rig_run(2000);

    TEST_ASSERT_EQUAL_DOUBLE(2378.0, rig_read("isr_cycles"));
    TEST_ASSERT_EQUAL_DOUBLE(2378.0, rig_read("isr_min_cycles"));
    TEST_ASSERT_EQUAL_DOUBLE(2378.0, rig_read("isr_max_cycles"));
    TEST_ASSERT_EQUAL_DOUBLE(1707.0, rig_read("speed_isr_cycles"));
    TEST_ASSERT_EQUAL_DOUBLE(1707.0, rig_read("speed_isr_max_cycles"));
}

void test_interrupt_load_that_changes_leaves_its_trace_in_the_histogram(void)
{
    rig_step("isr_load_cyc", 2378.0, 0.1, 5081.0);
    rig_start();
    rig_run(2000);

    double lower, upper, other, speed;
    histogram(2378 / BIN_CYC, &lower, &speed);
    histogram(5081 / BIN_CYC, &upper, &speed);
    histogram(16, &other, &speed);
    TEST_ASSERT_EQUAL_DOUBLE(1000.0, lower);
    TEST_ASSERT_DOUBLE_WITHIN(40.0, 1020.0, upper); /* it goes on while the rows are read */
    TEST_ASSERT_EQUAL_DOUBLE(0.0, other);
    TEST_ASSERT_EQUAL_DOUBLE(2378.0, rig_read("isr_min_cycles"));
    TEST_ASSERT_EQUAL_DOUBLE(5081.0, rig_read("isr_max_cycles"));
}

void test_interrupt_load_does_not_change_what_the_drive_does(void)
{
    rig_start();
    rig_run(3000);
    const double without = rig_read("true_speed_rad_s");

    rig_new();
    rig_input("speed_ref_rad_s", 31.4);
    rig_input("load_brake_nm", 0.03);
    rig_input("isr_load_cyc", 6000.0);
    rig_input("speed_isr_load_cyc", 6000.0); /* fits before the next current interrupt */
    rig_start();
    rig_run(3000);

    TEST_ASSERT_EQUAL_DOUBLE(without, rig_read("true_speed_rad_s"));
}

/* 20000 cycles are a period; a current interrupt takes 5000 of them, so that 150000 of the speed interrupt need 10. */
void test_interrupt_load_of_the_speed_interrupt_may_fill_its_period(void)
{
    rig_input("isr_load_cyc", 5000.0);
    rig_input("speed_isr_load_cyc", 149000.0);
    rig_start();
    rig_run(2000);

    TEST_ASSERT_EQUAL_STRING("none", rig_fault());
    TEST_ASSERT_EQUAL_DOUBLE(149000.0, rig_read("speed_isr_max_cycles"));
}

void test_interrupt_load_of_the_speed_interrupt_beyond_its_period_is_a_fault(void)
{
    rig_input("isr_load_cyc", 5000.0);
    rig_step("speed_isr_load_cyc", 5000.0, 0.1, 151000.0);
    rig_start();
    rig_run(1000);
    TEST_ASSERT_EQUAL_STRING("none", rig_fault());
    rig_run(25);

    TEST_ASSERT_EQUAL_STRING("speed_overrun", rig_fault());
    TEST_ASSERT_EQUAL_DOUBLE(5.0, rig_read("state"));
}

void test_interrupt_load_of_the_current_interrupt_beyond_its_period_is_a_fault(void)
{
    rig_step("isr_load_cyc", 20000.0, 0.1, 20001.0);
    rig_start();
    rig_run(1000);
    TEST_ASSERT_EQUAL_STRING("none", rig_fault());
    rig_run(1);

    TEST_ASSERT_EQUAL_STRING("isr_overrun", rig_fault());
    TEST_ASSERT_EQUAL_DOUBLE(20001.0, rig_read("isr_max_cycles"));
}

/* Start-up ends with a start: the figures of its interrupts are not those of the run. */
void test_interrupt_load_figures_begin_again_with_a_start(void)
{
    rig_param("offset_calibration_periods", 500.0);
    rig_step("isr_load_cyc", 9000.0, 0.07, 2000.0);
    rig_start();
    rig_run(600);
    TEST_ASSERT_EQUAL_DOUBLE(4.0, rig_read("state"));
    TEST_ASSERT_EQUAL_DOUBLE(9000.0, rig_read("isr_max_cycles"));

    rig_new();
    rig_param("offset_calibration_periods", 500.0);
    rig_step("isr_load_cyc", 9000.0, 0.03, 2000.0); /* while it calibrates */
    rig_start();
    rig_run(600);
    TEST_ASSERT_EQUAL_DOUBLE(4.0, rig_read("state"));
    TEST_ASSERT_EQUAL_DOUBLE(2000.0, rig_read("isr_max_cycles"));
}
