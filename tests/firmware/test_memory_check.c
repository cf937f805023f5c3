/* A memory that changes by itself: found in the next passes of the main loop, and never found where nothing has changed. */
#include "firmware/app/memory_check.h"

#include "firmware/app/internal.h"
#include "mock_hal_clock.h"
#include "mock_hal_encoder.h"
#include "mock_hal_inverter.h"
#include "mock_hal_sample.h"
#include "tests/firmware/support/bench.h"

#define ROUND 40U /* passes in which every part of the set in force has been seen, whatever the round was at */

void setUp(void) { bench_start(); }
void tearDown(void) {}

static void run(void)
{
    drive_params_t p = bench_params();
    p.current_ki_v_per_as = 100.0f; /* a flipped sign of 0 is still 0 */
    bench_run_with(&p);
    TEST_ASSERT_EQUAL_INT(DRIVE_RUN, drive.state);
}

/* Flip a bit, and let the main loop pass; the interrupts would find some of it themselves. */
static uint16_t passes_until_found(void *memory, unsigned bit)
{
    uint16_t passes = 0U;
    ((unsigned char *)memory)[bit / 8U] ^= (unsigned char)(1U << (bit % 8U));
    while ((drive.fault == FAULT_none) && (passes < (2U * ROUND))) {
        drive_background(&drive);
        passes++;
    }
    return passes;
}

static void must_be_found(void *memory, size_t octets, unsigned step, uint16_t most, uint16_t detail, const char *what)
{
    for (unsigned bit = 0U; bit < 8U * octets; bit += step) {
        run();
        const uint16_t passes = passes_until_found(memory, bit);
        TEST_ASSERT_EQUAL_STRING_MESSAGE("memory_changed", faults_info((uint16_t)drive.fault)->name, what);
        TEST_ASSERT_EQUAL_UINT16_MESSAGE(detail, drive.fault_detail, what);
        TEST_ASSERT_TRUE_MESSAGE(passes <= most, what);
        TEST_ASSERT_FALSE_MESSAGE(bench.armed, what);
    }
}

void test_memory_check_every_bit_of_the_command_is_found_in_the_next_pass(void)
{
    run();
    const uint16_t at = drive.command_at;
    must_be_found(&drive.command[at], sizeof drive.command[at], 1U, 1U, DRIVE_MEMORY_COMMAND, "command");
    run();
    must_be_found(&drive.order[drive.command_at], sizeof drive.order[0], 1U, 1U, DRIVE_MEMORY_COMMAND, "order");
    for (unsigned bit = 0U; bit < 16U; bit++) {
        run();
        drive.command_at = (uint16_t)(drive.command_at ^ (1U << bit));
        drive_background(&drive);
        TEST_ASSERT_EQUAL_INT(FAULT_memory_changed, drive.fault);
    }
}

void test_memory_check_bits_of_zero_and_offsets_are_found_in_the_next_pass_of_a_run(void)
{
    must_be_found(&drive.zero.e, sizeof drive.zero.e, 1U, 1U, DRIVE_MEMORY_ZERO, "zero");
    must_be_found(&drive.offset_a_a, sizeof drive.offset_a_a, 1U, 1U, DRIVE_MEMORY_ZERO, "offset a");
    must_be_found(&drive.offset_c_a, sizeof drive.offset_c_a, 1U, 1U, DRIVE_MEMORY_ZERO, "offset c");
}

void test_memory_check_bits_of_the_set_in_force_are_found_within_a_round(void)
{
    must_be_found(&drive.set[0].params, sizeof drive.set[0].params, 37U, ROUND, DRIVE_MEMORY_PARAMETERS, "parameters");
    must_be_found(&drive.set[0].setup.limits, sizeof drive.set[0].setup.limits, 5U, ROUND, DRIVE_MEMORY_PARAMETERS, "limits");
    must_be_found(&drive.set[0].setup.motion, sizeof drive.set[0].setup.motion, 5U, ROUND, DRIVE_MEMORY_PARAMETERS, "motion");
}

void test_memory_check_bits_of_the_copies_in_the_controllers_are_found_in_the_next_pass(void)
{
    must_be_found(&drive.current.d.params.kp, sizeof(num_t), 1U, 1U, DRIVE_MEMORY_COPIES, "kp d");
    must_be_found(&drive.current.q.params.ki_ts, sizeof(num_t), 1U, 1U, DRIVE_MEMORY_COPIES, "ki q");
    must_be_found(&drive.current.q.bound, sizeof(num_t), 1U, 1U, DRIVE_MEMORY_COPIES, "bound q");
    must_be_found(&drive.speed.pi.params.out_max, sizeof(num_t), 1U, 1U, DRIVE_MEMORY_COPIES, "limit of the speed loop");
    must_be_found(&drive.speed.mt.params.speed_1_count, sizeof(num_t), 1U, 1U, DRIVE_MEMORY_COPIES, "M/T");
    must_be_found(&drive.tracking.pll.params.ki_ts, sizeof(num_t), 1U, 1U, DRIVE_MEMORY_COPIES, "PLL");
    must_be_found(&drive.scale.inv_current, sizeof(float), 1U, 1U, DRIVE_MEMORY_COPIES, "scale");
}

void test_memory_check_a_state_that_the_main_loop_did_not_enter_switches_off(void)
{
    for (int state = 0; state < 64; state++) {
        run();
        if ((state == (int)DRIVE_RUN) || (state == (int)DRIVE_ALIGN)) {
            continue; /* an alignment that nobody began ends by itself: the current interrupt finds no phase of it */
        }
        drive.state = (drive_state_t)state;
        drive_background(&drive);
        TEST_ASSERT_EQUAL_INT(FAULT_memory_changed, drive.fault);
        TEST_ASSERT_EQUAL_UINT16(DRIVE_MEMORY_STATE, drive.fault_detail);
        TEST_ASSERT_FALSE(bench.armed);
    }
}

/* Commands and parameters change with every pass, and the set in force with them: nothing of it is a fault. */
void test_memory_check_is_silent_while_commands_and_parameters_change(void)
{
    run();
    for (int pass = 0; pass < 300; pass++) {
        drive_params_t p = *drive_newest_params(&drive);
        uint16_t       culprit = PARAM_COUNT;
        p.speed_kp_a_per_unit = 0.03f + 0.0001f * (float)(pass % 50);
        (void)drive_tune(&drive, &p, &culprit);
        bench_command(DRIVE_MODE_SPEED, (double)(pass % 20), 0.0, 0.0);
        drive_background(&drive);
        if ((pass % 3) != 0) {
            bench_periods(7U); /* some sets wait over several passes */
        }
        TEST_ASSERT_EQUAL_INT(FAULT_none, drive.fault);
    }
    TEST_ASSERT_EQUAL_INT(DRIVE_RUN, drive.state);
}

void test_memory_check_clear_drops_a_wrong_command_and_measures_zero_and_offsets_again(void)
{
    run();
    drive.command[drive.command_at].speed_ref_rad_s = 77.0f;
    drive_background(&drive);
    TEST_ASSERT_EQUAL_INT(FAULT_memory_changed, drive.fault);
    drive_clear_fault(&drive);
    drive_background(&drive);
    TEST_ASSERT_EQUAL_INT(FAULT_none, drive.fault);
    TEST_ASSERT_EQUAL_INT(DRIVE_INIT, drive.state);
    for (int pass = 0; pass < 3; pass++) {
        drive_background(&drive);
    }
    TEST_ASSERT_EQUAL_INT(DRIVE_READY, drive.state);
    TEST_ASSERT_EQUAL_FLOAT(0.0f, drive_newest_command(&drive)->speed_ref_rad_s);
}

void test_memory_check_clear_does_not_help_against_other_parameters(void)
{
    run();
    drive.set[0].setup.limits.over_current_a *= 2.0f;
    for (uint16_t pass = 0U; pass < ROUND; pass++) {
        drive_background(&drive);
    }
    TEST_ASSERT_EQUAL_INT(FAULT_memory_changed, drive.fault);
    drive_clear_fault(&drive);
    drive_background(&drive);
    TEST_ASSERT_EQUAL_INT(FAULT_memory_changed, drive.fault);
    TEST_ASSERT_EQUAL_INT(DRIVE_FAULT, drive.state);
}
