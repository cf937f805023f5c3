/* firmware/app/protection.c: every fault of the list can happen, happens at its limit, and leaves the bridge off. */
#include "firmware/app/protection.h"
#include "firmware/app/telemetry.h"
#include "mock_hal_clock.h"
#include "mock_hal_encoder.h"
#include "mock_hal_inverter.h"
#include "mock_hal_limits.h"
#include "mock_hal_sample.h"
#include "tests/firmware/support/bench.h"

void setUp(void) { bench_start(); }
void tearDown(void) {}

/* ---- every fault of faults.def -------------------------------------------------------------------------------------- */

static void provoke_over_current(void)
{
    bench_into(DRIVE_RUN);
    bench.sample.ia_a = 20.5f;
    bench_period();
}

static void provoke_over_voltage(void)
{
    bench_into(DRIVE_RUN);
    bench.sample.vdc_v = 40.5f;
    bench_period();
}

static void provoke_under_voltage(void)
{
    bench_into(DRIVE_RUN);
    bench.sample.vdc_v = 9.5f;
    bench_periods(20U);
}

static void provoke_over_speed(void)
{
    bench_into(DRIVE_RUN);
    bench_spin(660.0, 0.0);
}

static void provoke_encoder_lost(void)
{
    drive_params_t p = bench_params();
    p.encoder_jump_rad = 0.05f;
    p.encoder_jump_periods = 1U;
    bench_run_with(&p);
    bench_periods(2U);
    bench_angle(1.0);
    bench_periods(2U);
}

static void provoke_encoder_error(void)
{
    bench_into(DRIVE_RUN);
    bench.sample_status = HAL_SENSOR_FAULT;
    bench_period();
}

static void provoke_lost_sample(void)
{
    bench_into(DRIVE_RUN);
    bench.sample_status = HAL_STALE;
    bench_periods(3U);
}

static void provoke_non_finite(void)
{
    bench_into(DRIVE_RUN);
    bench.sample.ia_a = NAN;
    bench_periods(3U);
}

static void provoke_offset_calibration(void)
{
    drive_params_t p = bench_params();
    p.offset_calibration_periods = 10U;
    drive_init(&drive, &p);
    bench.sample.ib_a = 0.6f;
    drive_background(&drive);
    bench_live(20U);
}

static void provoke_configuration(void)
{
    drive_params_t p = bench_params();
    p.pole_pairs = 0U;
    drive_init(&drive, &p);
}

static drive_params_t alignment_params(void)
{
    drive_params_t p = bench_params();
    p.align_periods = 36000U; /* a quarter turn in 0.1 s, slow for the damping that does not know the pole pairs */
    p.align_rest_s = 0.1f;
    return p;
}

static void provoke_alignment(double rotor_pairs)
{
    const drive_params_t p = alignment_params();
    drive_init(&drive, &p);
    drive_background(&drive);
    bench.rotor_pairs = rotor_pairs;
    bench_align();
}

static void provoke_align_turning(void)
{
    const drive_params_t p = alignment_params();
    drive_init(&drive, &p);
    drive_background(&drive);
    drive_start(&drive);
    drive_background(&drive);
    bench_spin(10.0, 0.0);
}

/* 1000 rad/s^2 there, and back again: no vector stops that */
static void provoke_align_unsettled(void)
{
    const drive_params_t p = alignment_params();
    drive_init(&drive, &p);
    drive_background(&drive);
    drive_start(&drive);
    bench_live(BENCH_WAIT_PERIODS + 100U);
    for (int k = 0; (k < 40000) && (drive.state == DRIVE_ALIGN); k++) {
        bench_angle(0.1 * sin(100.0 * 1e-4 * k));
        bench_live(1U);
        drive_background(&drive);
    }
}

static void provoke_align_blocked(void) { provoke_alignment(0.0); }
static void provoke_align_direction(void) { provoke_alignment(-4.0); }
static void provoke_align_pole_pairs(void) { provoke_alignment(3.0); }

/* what holds the rotor back by 10 degrees at full current, and by 20 at half of it */
static void provoke_align_load(void)
{
    bench.rotor_load = 0.175;
    provoke_alignment(4.0);
}

static void provoke_hardware(hal_inverter_fault_t fault)
{
    bench_into(DRIVE_RUN);
    bench.inverter_fault = fault;
    bench_period();
}

static void provoke_hardware_over_current(void) { provoke_hardware(HAL_INVERTER_OVER_CURRENT); }
static void provoke_gate_driver(void) { provoke_hardware(HAL_INVERTER_DRIVER_FAULT); }
static void provoke_over_temperature(void) { provoke_hardware(HAL_INVERTER_OVER_TEMPERATURE); }

static void provoke_gate_driver_supply(void) { provoke_hardware(HAL_INVERTER_DRIVER_SUPPLY); }
static void provoke_gate_driver_link(void) { provoke_hardware(HAL_INVERTER_DRIVER_LINK); }
static void provoke_trip_path(void) { provoke_hardware(HAL_INVERTER_TRIP_PATH); }
static void provoke_current_sum(void) { provoke_hardware(HAL_INVERTER_CURRENT_SUM); }
static void provoke_late_interrupt(void) { provoke_hardware(HAL_INVERTER_LATE); }
static void provoke_processor_halted(void) { provoke_hardware(HAL_INVERTER_HALTED); }
static void provoke_processor_clock(void) { provoke_hardware(HAL_INVERTER_CLOCK); }
static void provoke_processor_memory(void) { provoke_hardware(HAL_INVERTER_MEMORY); }
static void provoke_safe_torque_off(void) { provoke_hardware(HAL_INVERTER_STO); }

static void provoke_ram_test(void) { provoke_hardware(HAL_INVERTER_RAM_TEST); }
static void provoke_program_test(void) { provoke_hardware(HAL_INVERTER_PROGRAM_TEST); }
static void provoke_processor_test(void) { provoke_hardware(HAL_INVERTER_PROCESSOR_TEST); }

static void provoke_start_turning(void)
{
    bench_into(DRIVE_READY);
    bench_spin(500.0, 0.0);
    drive_start(&drive);
    drive_background(&drive);
}

static drive_params_t position_params(void)
{
    drive_params_t p = bench_params();
    p.following_error_rad = 100.0f;
    return p;
}

static void provoke_following_error(void)
{
    drive_params_t p = position_params();
    p.following_error_rad = 0.1f;
    bench_run_with(&p);
    const drive_command_t far = {.mode = DRIVE_MODE_POSITION, .target_turns = 10};
    TEST_ASSERT_TRUE(drive_command(&drive, &far));
    bench_live(3000U); /* the command moves at 1.05 rad/s, the shaft does not */
}

static void provoke_position_limit(void)
{
    drive_params_t p = position_params();
    p.position_max_turn = 0.1f;
    p.position_min_turn = -0.1f;
    bench_run_with(&p);
    const drive_command_t here = {.mode = DRIVE_MODE_POSITION};
    TEST_ASSERT_TRUE(drive_command(&drive, &here));
    bench_live(100U);
    bench_spin(20.0, 1.0);
}

static void provoke_homing(void)
{
    const drive_params_t p = position_params();
    bench_run_with(&p);
    const drive_command_t here = {.mode = DRIVE_MODE_POSITION};
    TEST_ASSERT_TRUE(drive_command(&drive, &here));
    drive_home(&drive);
    bench_live(100U);
    for (uint16_t turn = 0U; turn < 10U; turn++) { /* no index pulse on the way */
        bench_spin(60.0, 1.0);
    }
}

static void provoke_isr_overrun(void)
{
    bench_into(DRIVE_RUN);
    bench_period(); /* the speed tick reads the clock a third time */
    bench.isr_cyc = BENCH_PERIOD_CYC + 1U;
    bench_period();
}

static void provoke_speed_overrun(void)
{
    bench_into(DRIVE_RUN);
    bench_period();
    for (int k = 0; k < 20; k++) { /* two speed ticks, and no speed interrupt comes to its end */
        bench.sample.seq++;
        drive_current_isr(&drive);
    }
}

/* 100 rad/s at standstill ask for more than the limit at once: 400 units of 0.0368 A. */
static void push_without_motion(double stall_s, double speed_ref_rad_s)
{
    drive_params_t p = bench_params();
    p.stall_s = (float)stall_s;
    bench_run_with(&p);
    bench_command(DRIVE_MODE_SPEED, speed_ref_rad_s, 0.0, 0.0);
}

static void provoke_stall(void)
{
    push_without_motion(0.02, 100.0);
    bench_periods(300U);
}

/* Asked forwards, as hard as it can, and it goes backwards. */
static void provoke_speed_deviation(void)
{
    drive_params_t p = bench_params();
    p.speed_source = DRIVE_SPEED_PLL;
    p.speed_deviation_s = 0.05f;
    bench_run_with(&p);
    bench_command(DRIVE_MODE_SPEED, 100.0, 0.0, 0.0);
    bench_spin(-100.0, 0.0);
}

/* The same current all the time, the speed rises, and the voltage falls. */
static void provoke_electrical_zero(void)
{
    drive_params_t p = bench_params();
    p.speed_source = DRIVE_SPEED_PLL;
    p.zero_check = 1U;
    bench_run_with(&p);
    for (int k = 0; k < 3000; k++) {
        bench_command(DRIVE_MODE_CURRENT, 0.0, 0.0, 10.0 - (double)k / 300.0);
        bench_angle(0.5 * 500.0 * 1e-8 * k * k);
        bench_period();
    }
}

/* The current loop asks for 6 A with 3.6 V, and no current flows. */
static void provoke_current_implausible(void)
{
    drive_params_t p = bench_params();
    p.plausibility_share = 0.025f;
    bench_run_with(&p);
    bench_command(DRIVE_MODE_CURRENT, 0.0, 0.0, 6.0);
    bench_periods(100U);
}

/* A command that nobody gave. */
static void provoke_memory_changed(void)
{
    const drive_params_t p = bench_params();
    bench_run_with(&p);
    drive.command[drive.command_at].speed_ref_rad_s = 100.0f;
    drive_background(&drive);
}

/* A current that flows whatever the drive asks for, twice what the part bears for ever. */
static void overload(float motor_a, float bridge_a)
{
    drive_params_t p = bench_params();
    p.motor_continuous_a = motor_a;
    p.motor_thermal_s = 1.0f;
    p.bridge_continuous_a = bridge_a;
    p.bridge_thermal_s = 1.0f;
    bench_run_with(&p);
    bench_currents(0.0, 10.0, 0.0);
    for (int k = 0; (k < 1000) && (drive.state == DRIVE_RUN); k++) {
        bench_live(10U);
    }
}
static void provoke_motor_overload(void) { overload(5.0f, 0.0f); }
static void provoke_bridge_overload(void) { overload(0.0f, 5.0f); }

static void provoke_motor_temperature(void)
{
    drive_params_t p = bench_params();
    p.motor_trip_c = 100.0f;
    bench_run_with(&p);
    bench.celsius[HAL_TEMPERATURE_MOTOR] = 100.0f;
    bench_live(200U);
}

static void provoke_temperature_sensor(void)
{
    drive_params_t p = bench_params();
    p.bridge_trip_c = 100.0f;
    bench_run_with(&p);
    bench.celsius_status[HAL_TEMPERATURE_BRIDGE] = HAL_SENSOR_FAULT;
    bench_live(200U);
}

static void provoke_brake_overload(void)
{
    drive_params_t p = bench_params();
    p.chopper_v = 20.0f; /* below the supply: 24^2 / 10 ohm of 30 W, for ever */
    p.chopper_continuous_w = 30.0f;
    p.chopper_thermal_s = 0.1f;
    bench_run_with(&p);
    bench_live(2000U);
}

/* The hardware of one channel is dead as well: nothing else would say so. */
static void provoke_sto_discrepancy(void)
{
    const drive_params_t p = bench_params();
    bench_run_with(&p);
    drive.sto.stuck = 2U;
    bench_live(20U);
}

static void provoke_encoder_index(void)
{
    const drive_params_t p = bench_params();
    bench_run_with(&p);
    for (uint16_t k = 1U; k <= 2U; k++) {
        bench.edge.index_passes = k;
        bench.edge.index_rad = (float)k;
        bench_live(20U);
    }
}

static void provoke_restart_lockout(void)
{
    drive_params_t p = bench_params();
    p.restart_limit = 1U;
    bench_run_with(&p);
    for (int k = 0; k < 2; k++) {
        bench.sample.vdc_v = 100.0f;
        bench_period();
        bench.sample.vdc_v = (float)BENCH_VDC;
        drive_clear_fault(&drive);
        bench_live(20U);
        drive_start(&drive);
        bench_live(20U);
    }
}

/* A fault without a row here fails the next test. */
static void (*const PROVOKE[FAULT_COUNT])(void) = {
    [FAULT_align_turning] = provoke_align_turning,
    [FAULT_align_unsettled] = provoke_align_unsettled,
    [FAULT_align_blocked] = provoke_align_blocked,
    [FAULT_align_direction] = provoke_align_direction,
    [FAULT_align_pole_pairs] = provoke_align_pole_pairs,
    [FAULT_align_load] = provoke_align_load,
    [FAULT_over_current] = provoke_over_current,
    [FAULT_over_voltage] = provoke_over_voltage,
    [FAULT_under_voltage] = provoke_under_voltage,
    [FAULT_over_speed] = provoke_over_speed,
    [FAULT_encoder_lost] = provoke_encoder_lost,
    [FAULT_encoder_error] = provoke_encoder_error,
    [FAULT_lost_sample] = provoke_lost_sample,
    [FAULT_non_finite] = provoke_non_finite,
    [FAULT_offset_calibration] = provoke_offset_calibration,
    [FAULT_configuration] = provoke_configuration,
    [FAULT_hardware_over_current] = provoke_hardware_over_current,
    [FAULT_gate_driver] = provoke_gate_driver,
    [FAULT_over_temperature] = provoke_over_temperature,
    [FAULT_following_error] = provoke_following_error,
    [FAULT_position_limit] = provoke_position_limit,
    [FAULT_homing] = provoke_homing,
    [FAULT_isr_overrun] = provoke_isr_overrun,
    [FAULT_speed_overrun] = provoke_speed_overrun,
    [FAULT_stall] = provoke_stall,
    [FAULT_speed_deviation] = provoke_speed_deviation,
    [FAULT_electrical_zero] = provoke_electrical_zero,
    [FAULT_current_implausible] = provoke_current_implausible,
    [FAULT_gate_driver_supply] = provoke_gate_driver_supply,
    [FAULT_gate_driver_link] = provoke_gate_driver_link,
    [FAULT_trip_path] = provoke_trip_path,
    [FAULT_current_sum] = provoke_current_sum,
    [FAULT_late_interrupt] = provoke_late_interrupt,
    [FAULT_processor_halted] = provoke_processor_halted,
    [FAULT_processor_clock] = provoke_processor_clock,
    [FAULT_processor_memory] = provoke_processor_memory,
    [FAULT_start_turning] = provoke_start_turning,
    [FAULT_memory_changed] = provoke_memory_changed,
    [FAULT_motor_overload] = provoke_motor_overload,
    [FAULT_bridge_overload] = provoke_bridge_overload,
    [FAULT_motor_temperature] = provoke_motor_temperature,
    [FAULT_temperature_sensor] = provoke_temperature_sensor,
    [FAULT_safe_torque_off] = provoke_safe_torque_off,
    [FAULT_ram_test] = provoke_ram_test,
    [FAULT_program_test] = provoke_program_test,
    [FAULT_processor_test] = provoke_processor_test,
    [FAULT_sto_discrepancy] = provoke_sto_discrepancy,
    [FAULT_brake_overload] = provoke_brake_overload,
    [FAULT_encoder_index] = provoke_encoder_index,
    [FAULT_restart_lockout] = provoke_restart_lockout,
};

/* The board is well again. */
static void heal(void)
{
    const bench_t  well = {.sample = {0.0f, 0.0f, 0.0f, (float)BENCH_VDC, 0.0f, 0U}};
    const uint32_t seq = bench.sample.seq;
    bench.sample = well.sample;
    bench.sample.seq = seq;
    bench.sample_status = HAL_OK;
    bench.edge_status = HAL_OK;
    bench.arm_status = HAL_OK;
    bench.inverter_fault = HAL_INVERTER_FINE;
    bench.isr_cyc = 0U;
    bench.rotor_pairs = 0.0;
}

void test_protection_every_fault_of_the_list_can_be_provoked_and_switches_the_bridge_off(void)
{
    for (uint16_t f = 1U; f < (uint16_t)FAULT_COUNT; f++) {
        TEST_ASSERT_NOT_NULL_MESSAGE(PROVOKE[f], faults_info(f)->name);
        bench_start();

        PROVOKE[f]();

        ASSERT_FAULT(f, faults_info(f)->name);
        TEST_ASSERT_TRUE_MESSAGE(bench.disarms > 0U, faults_info(f)->name);
    }
}

void test_protection_fault_stays_when_its_cause_is_gone_and_nothing_arms(void)
{
    for (uint16_t f = 1U; f < (uint16_t)FAULT_COUNT; f++) {
        bench_start();
        PROVOKE[f]();
        heal();
        const uint32_t arms = bench.arms;

        drive_start(&drive);
        bench_live(200U);

        ASSERT_FAULT(f, faults_info(f)->name);
        TEST_ASSERT_EQUAL_UINT32_MESSAGE(arms, bench.arms, faults_info(f)->name);
        if (f != (uint16_t)FAULT_configuration) { /* without a configuration there is no control at all */
            ASSERT_ZERO_VOLTAGE(faults_info(f)->name);
        }
    }
}

void test_protection_first_fault_wins_over_every_other(void)
{
    for (uint16_t f = 1U; f < (uint16_t)FAULT_COUNT; f++) {
        bench_start();
        PROVOKE[f]();
        /* and now everything at once */
        bench.sample.ia_a = 100.0f;
        bench.sample.vdc_v = 100.0f;
        bench.inverter_fault = HAL_INVERTER_DRIVER_FAULT;
        bench.isr_cyc = 10U * BENCH_PERIOD_CYC;
        bench_live(30U);

        ASSERT_FAULT(f, faults_info(f)->name);
    }
}

/* ---- within one interrupt ------------------------------------------------------------------------------------------- */

void test_protection_over_current_disarms_before_the_same_interrupt_ends(void)
{
    bench_into(DRIVE_RUN);
    bench_command(DRIVE_MODE_CURRENT, 0.0, 0.0, 5.0);
    bench_period();
    TEST_ASSERT_TRUE(bench.armed);
    bench_forget_calls();
    bench.sample.ic_a = -20.5f;
    bench.sample.seq++;

    drive_current_isr(&drive);

    TEST_ASSERT_FALSE(bench.armed);
    TEST_ASSERT_EQUAL_INT(DRIVE_FAULT, drive.state);
    TEST_ASSERT_TRUE(bench_first(CALL_DISARM) >= 0);
    TEST_ASSERT_TRUE(bench_first(CALL_READ) < bench_first(CALL_DISARM)); /* with this sample... */
    TEST_ASSERT_TRUE(bench_first(CALL_DISARM) < bench_first(CALL_DUTY)); /* ...and before any duty from it */
    ASSERT_ZERO_VOLTAGE("not a duty made from a bad current");
}

void test_protection_every_fault_of_a_sample_disarms_within_its_interrupt(void)
{
    const struct {
        float                i_a, vdc_v;
        hal_status_t         status;
        hal_inverter_fault_t hardware;
        uint32_t             cyc;
        drive_fault_t        fault;
    } row[] = {
        {-21.0f, 24.0f, HAL_OK, HAL_INVERTER_FINE, 0U, FAULT_over_current},
        {0.0f, 41.0f, HAL_OK, HAL_INVERTER_FINE, 0U, FAULT_over_voltage},
        {0.0f, 24.0f, HAL_SENSOR_FAULT, HAL_INVERTER_FINE, 0U, FAULT_encoder_error},
        {0.0f, 24.0f, HAL_OK, HAL_INVERTER_OVER_CURRENT, 0U, FAULT_hardware_over_current},
        {0.0f, 24.0f, HAL_STALE, HAL_INVERTER_DRIVER_FAULT, 0U, FAULT_gate_driver},
        {NAN, 24.0f, HAL_OK, HAL_INVERTER_OVER_TEMPERATURE, 0U, FAULT_over_temperature},
        {0.0f, 24.0f, HAL_OK, HAL_INVERTER_FINE, 20001U, FAULT_isr_overrun},
    };
    for (size_t k = 0; k < COUNT_OF(row); k++) {
        bench_start();
        bench_into(DRIVE_RUN);
        bench_period();
        TEST_ASSERT_TRUE(bench.armed);
        bench.sample.ib_a = row[k].i_a;
        bench.sample.vdc_v = row[k].vdc_v;
        bench.sample_status = row[k].status;
        bench.inverter_fault = row[k].hardware;
        bench.isr_cyc = row[k].cyc;
        bench.sample.seq++;

        drive_current_isr(&drive);

        ASSERT_FAULT(row[k].fault, faults_info(row[k].fault)->name);
    }
}

/* ---- limits have two sides ------------------------------------------------------------------------------------------ */

static void set_phase(int phase, float amps)
{
    *((phase == 0) ? &bench.sample.ia_a : ((phase == 1) ? &bench.sample.ib_a : &bench.sample.ic_a)) = amps;
}

void test_protection_over_current_acts_on_each_phase_in_both_directions_and_not_at_the_limit(void)
{
    for (int phase = 0; phase < 3; phase++) {
        for (int sign = -1; sign <= 1; sign += 2) {
            bench_start();
            bench_into(DRIVE_RUN);
            set_phase(phase, 20.0f * (float)sign);
            bench_period();
            ASSERT_NO_FAULT("20 A is allowed");

            set_phase(phase, nextafterf(20.0f, 21.0f) * (float)sign);
            bench_period();
            ASSERT_FAULT(FAULT_over_current, at("phase %d, sign %d", phase, sign));
        }
    }
}

void test_protection_over_current_acts_without_an_armed_bridge_too(void)
{
    bench_into(DRIVE_READY);
    bench.sample.ia_a = 21.0f;
    bench_period();

    ASSERT_FAULT(FAULT_over_current, "READY");
}

void test_protection_over_voltage_acts_above_its_limit_in_every_state(void)
{
    const drive_state_t state[] = {DRIVE_INIT, DRIVE_OFFSET_CALIBRATION, DRIVE_ALIGN, DRIVE_READY, DRIVE_RUN};
    for (size_t k = 0; k < COUNT_OF(state); k++) {
        bench_start();
        bench_into(state[k]);
        bench.sample.vdc_v = 40.0f;
        bench_period();
        ASSERT_NO_FAULT("40 V is allowed");

        bench.sample.vdc_v = nextafterf(40.0f, 41.0f);
        bench_period();
        ASSERT_FAULT(FAULT_over_voltage, at("state %d", (int)state[k]));
    }
}

void test_protection_under_voltage_acts_below_its_limit_while_armed(void)
{
    const drive_state_t state[] = {DRIVE_ALIGN, DRIVE_RUN};
    for (size_t k = 0; k < COUNT_OF(state); k++) {
        bench_start();
        bench_into(state[k]);
        bench.sample.vdc_v = 10.0f;
        bench_period();
        ASSERT_NO_FAULT("10 V is allowed");

        bench.sample.vdc_v = nextafterf(10.0f, 9.0f);
        bench_periods(19U);
        ASSERT_NO_FAULT("1.9 ms may be a supply that folds back");
        bench_period();
        ASSERT_FAULT(FAULT_under_voltage, at("state %d", (int)state[k]));
    }
}

void test_protection_under_voltage_that_comes_and_goes_does_not_add_up(void)
{
    bench_into(DRIVE_RUN);
    for (int k = 0; k < 20; k++) {
        bench.sample.vdc_v = 9.0f;
        bench_periods(19U);
        bench.sample.vdc_v = 24.0f;
        bench_period();
    }

    ASSERT_NO_FAULT("never 2 ms in a row");
}

void test_protection_long_gap_counts_as_many_samples_as_it_has_periods(void)
{
    bench_into(DRIVE_RUN);
    bench_period();
    bench.sample.seq += 2U; /* two periods went by unseen */
    bench_period();
    ASSERT_NO_FAULT("2 of 3");
    bench_periods(5U);

    bench.sample.seq += 3U;
    bench_period();
    ASSERT_FAULT(FAULT_lost_sample, "three at once");

    bench_start();
    bench_into(DRIVE_READY);
    bench_period();
    bench.sample.seq += 500U; /* a save */
    bench_period();
    ASSERT_NO_FAULT("at rest");
}

void test_protection_driver_that_pulled_its_line_is_named_once_it_has_been_asked(void)
{
    provoke_gate_driver();
    ASSERT_FAULT(FAULT_gate_driver, "in the interrupt there is no time to ask");

    bench.inverter_fault = HAL_INVERTER_DRIVER_SUPPLY;
    drive_background(&drive);

    ASSERT_FAULT(FAULT_gate_driver_supply, "asked");
    TEST_ASSERT_EQUAL_INT(DRIVE_FAULT, drive.state);
}

void test_protection_main_loop_sees_a_hardware_fault_when_no_current_interrupt_comes(void)
{
    bench_into(DRIVE_RUN);
    bench.inverter_fault = HAL_INVERTER_LATE;

    drive_background(&drive);

    ASSERT_FAULT(FAULT_late_interrupt, "without an interrupt");
    TEST_ASSERT_FALSE(bench.armed);
}

/* w_e psi 2 T / Lq = w 4 x 6.4 mWb x 200 us / 0.2 mH = 25.6 mA per rad/s: half of the 20 A at 390.6 rad/s. */
void test_protection_start_into_a_fast_motor_is_refused_and_into_a_slow_one_begins_with_its_voltage(void)
{
    for (int sign = -1; sign <= 1; sign += 2) {
        bench_start();
        bench_into(DRIVE_READY);
        bench_spin(395.0 * sign, 0.0);
        drive_start(&drive);
        drive_background(&drive);
        ASSERT_FAULT(FAULT_start_turning, at("sign %d", sign));
        TEST_ASSERT_FALSE(bench.armed);

        bench_start();
        bench_into(DRIVE_READY);
        bench_spin(386.0 * sign, 0.0);
        drive_start(&drive);
        drive_background(&drive);
        ASSERT_NO_FAULT("386 rad/s");
        TEST_ASSERT_EQUAL_INT(DRIVE_RUN, drive.state);
        const double volt_v = (double)num_to_float(drive.current.q.state.x) * (double)drive.scale.voltage_v;
        TEST_ASSERT_DOUBLE_WITHIN(0.1, 386.0 * 0.0256 * sign, volt_v);
    }
}

void test_protection_under_voltage_waits_for_the_supply_before_the_drive_is_armed(void)
{
    bench_into(DRIVE_READY);
    bench.sample.vdc_v = 0.0f;
    bench_periods(100U);

    ASSERT_NO_FAULT("supply not yet there");
}

void test_protection_over_speed_acts_in_both_directions_and_not_at_99_percent(void)
{
    for (int sign = -1; sign <= 1; sign += 2) {
        bench_start();
        bench_into(DRIVE_RUN);
        bench_spin(643.0 * sign, 0.0);
        ASSERT_NO_FAULT("643 of 650 rad/s");

        bench_start();
        bench_into(DRIVE_RUN);
        bench_spin(655.0 * sign, 0.0);
        ASSERT_FAULT(FAULT_over_speed, at("sign %d", sign));
    }
}

/* ---- encoder -------------------------------------------------------------------------------------------------------- */

void test_protection_phase_error_of_the_edge_timer_is_an_encoder_error(void)
{
    bench_into(DRIVE_RUN);
    bench.edge_status = HAL_SENSOR_FAULT;
    bench_periods(10U); /* looked at once per speed period */

    ASSERT_FAULT(FAULT_encoder_error, "edge timer");
    ASSERT_ZERO_VOLTAGE("from the period in which it was seen");
}

/* ---- lost and impossible samples ------------------------------------------------------------------------------------ */

void test_protection_lost_samples_trip_at_their_limit_in_a_row(void)
{
    bench_into(DRIVE_RUN);
    bench.sample_status = HAL_STALE;
    bench_periods(2U);
    ASSERT_NO_FAULT("2 of 3");

    bench_periods(1U);
    ASSERT_FAULT(FAULT_lost_sample, "the third");
}

void test_protection_good_sample_ends_the_row_of_lost_ones(void)
{
    bench_into(DRIVE_RUN);
    for (int k = 0; k < 20; k++) {
        bench.seq_by_itself = false;
        bench.sample_status = HAL_STALE;
        bench_periods(2U);
        bench.seq_by_itself = true;
        bench.sample_status = HAL_OK;
        bench_periods(1U);
    }

    ASSERT_NO_FAULT("2 of 3, 20 times");
    TEST_ASSERT_EQUAL_UINT32(40U, drive_rejected(&drive));
}

void test_protection_gaps_in_the_sequence_trip_like_lost_samples(void)
{
    bench_into(DRIVE_RUN);
    bench_period();
    for (int k = 0; k < 2; k++) {
        bench.sample.seq++; /* and one more by itself */
        bench_period();
    }
    ASSERT_NO_FAULT("two gaps");

    bench.sample.seq++;
    bench_period();
    ASSERT_FAULT(FAULT_lost_sample, "three gaps in a row");
}

void test_protection_repeated_sequence_number_counts_as_lost(void)
{
    bench_into(DRIVE_RUN);
    bench_period();
    bench.seq_by_itself = false;
    bench_periods(3U);

    ASSERT_FAULT(FAULT_lost_sample, "the same number three times");
}

static float *field(int which)
{
    hal_sample_t *const s = &bench.sample;
    float *const        of[] = {&s->ia_a, &s->ib_a, &s->ic_a, &s->vdc_v};
    return of[which];
}

void test_protection_number_that_is_none_trips_from_every_field_at_its_limit_in_a_row(void)
{
    const float bad[] = {NAN, INFINITY, -INFINITY};
    for (int which = 0; which < 4; which++) {
        for (size_t k = 0; k < COUNT_OF(bad); k++) {
            bench_start();
            bench_into(DRIVE_RUN);
            bench_period();
            *field(which) = bad[k];
            bench_periods(2U);
            ASSERT_NO_FAULT(at("2 of 3, field %d, kind %u", which, (unsigned)k));
            ASSERT_ZERO_VOLTAGE("not used");

            bench_periods(1U);
            ASSERT_FAULT(FAULT_non_finite, at("field %d, kind %u", which, (unsigned)k));
        }
    }
}

void test_protection_good_sample_ends_the_row_of_impossible_ones(void)
{
    bench_into(DRIVE_RUN);
    for (int k = 0; k < 20; k++) {
        bench.sample.vdc_v = NAN;
        bench_periods(2U);
        bench.sample.vdc_v = (float)BENCH_VDC;
        bench_periods(1U);
    }

    ASSERT_NO_FAULT("2 of 3, 20 times");
    TEST_ASSERT_EQUAL_UINT32(40U, drive_rejected(&drive));
}

void test_protection_counter_of_rejected_samples_stops_at_its_end(void)
{
    bench_into(DRIVE_RUN);
    drive.rejected = UINT32_MAX;
    bench.sample.ia_a = NAN;
    bench_period();

    TEST_ASSERT_EQUAL_UINT32(UINT32_MAX, drive.rejected);
}

/* ---- time ----------------------------------------------------------------------------------------------------------- */

void test_protection_interrupt_that_just_fits_its_period_is_no_overrun(void)
{
    bench_into(DRIVE_RUN);
    bench_period();
    bench.isr_cyc = BENCH_PERIOD_CYC;
    bench_periods(5U);
    ASSERT_NO_FAULT("20000 cycles");

    bench.isr_cyc = BENCH_PERIOD_CYC + 1U;
    bench_period();
    ASSERT_FAULT(FAULT_isr_overrun, "20001 cycles");
}

/* ---- stall ---------------------------------------------------------------------------------------------------------- */

/* The first sample of the speed loop makes the current, 20 count, and the next trips: in periods 1, 11 .. 201, 211. */
void test_protection_stall_is_a_fault_after_its_samples_and_not_before(void)
{
    push_without_motion(0.02, -100.0);
    bench_periods(210U);
    ASSERT_NO_FAULT("20 samples without motion");
    bench_periods(1U);
    ASSERT_FAULT(FAULT_stall, "one more");
}

void test_protection_stall_counts_again_after_every_motion(void)
{
    const double move[] = {0.03, -0.03}; /* more than 1/256 turn, 0.0245 rad */
    for (size_t k = 0; k < COUNT_OF(move); k++) {
        bench_start();
        push_without_motion(0.02, 100.0);
        for (int step = 1; step <= 10; step++) {
            bench_periods(150U);
            bench_angle(move[k] * step);
        }
        ASSERT_NO_FAULT(at("moves by %g rad", move[k]));
        bench_periods(300U);
        ASSERT_FAULT(FAULT_stall, "stands again");
    }
}

void test_protection_shaft_that_only_gives_way_is_a_stall(void)
{
    const double step_rad[] = {0.0005, -0.0005}; /* 0.015 rad in all */
    for (size_t k = 0; k < COUNT_OF(step_rad); k++) {
        bench_start();
        push_without_motion(0.02, 100.0);
        for (int step = 1; step <= 30; step++) {
            bench_periods(10U);
            bench_angle(step_rad[k] * step);
        }
        ASSERT_FAULT(FAULT_stall, at("%g rad", 30.0 * step_rad[k]));
    }
}

/* One of 16 counts a turn, 0.393 rad, takes 79 ms at 5 rad/s and 561 ms at 0.7 rad/s; in between the encoder stands. */
void test_protection_shaft_that_turns_slowly_between_coarse_counts_is_no_stall(void)
{
    const double speed[] = {5.0, -5.0, 0.7};
    for (size_t k = 0; k < COUNT_OF(speed); k++) {
        drive_params_t p = bench_params();
        p.stall_s = 0.08f;
        p.encoder_counts = 16.0f;
        p.iq_limit_a = 0.05f; /* always at its limit */
        bench_start();
        bench_run_with(&p);
        bench_command(DRIVE_MODE_SPEED, speed[k], 0.0, 0.0);
        const uint32_t count_periods = (uint32_t)(TWO_PI / 16.0 / fabs(speed[k]) * 1e4);
        for (int n = 1; n <= 6; n++) {
            bench_periods(count_periods);
            bench_angle(copysign(TWO_PI / 16.0 * n, speed[k]));
        }
        ASSERT_NO_FAULT(at("%g rad/s", speed[k]));
        bench_periods(4U * count_periods + 3300U); /* 3 counts, and 4 * 0.08 s at least */
        ASSERT_FAULT(FAULT_stall, at("stands, asked for %g rad/s", speed[k]));
    }
}

void test_protection_no_stall_without_a_wish_to_turn_or_below_the_current_limit(void)
{
    push_without_motion(0.02, 0.0);
    bench_periods(1000U);
    ASSERT_NO_FAULT("speed 0");

    bench_start();
    drive_params_t p = bench_params();
    p.stall_s = 0.02f;
    p.speed_ki_a_per_unit_s = 0.0f;
    bench_run_with(&p);
    bench_command(DRIVE_MODE_SPEED, 60.0, 0.0, 0.0); /* 240 * 0.0368 = 8.83 A of 10 */
    bench_periods(1000U);
    ASSERT_NO_FAULT("8.8 A");
    bench_command(DRIVE_MODE_SPEED, 62.0, 0.0, 0.0); /* 9.13 A */
    bench_periods(1000U);
    ASSERT_FAULT(FAULT_stall, "9.1 A");

    bench_start();
    push_without_motion(0.02, 100.0);
    bench_command(DRIVE_MODE_CURRENT, 0.0, 0.0, 10.0);
    bench_periods(1000U);
    ASSERT_NO_FAULT("current mode");

    bench_start();
    p = bench_params();
    p.stall_s = 0.02f;
    p.following_error_rad = 100.0f;
    bench_run_with(&p);
    const drive_command_t far = {.mode = DRIVE_MODE_POSITION, .speed_ref_rad_s = 100.0f, .target_turns = 10};
    TEST_ASSERT_TRUE(drive_command(&drive, &far));
    bench_periods(20000U);
    ASSERT_FAULT(FAULT_stall, "position mode");

    bench_start();
    push_without_motion(0.0, 100.0);
    bench_periods(1000U);
    ASSERT_NO_FAULT("stall_s = 0");
}

/* ---- hardware ------------------------------------------------------------------------------------------------------- */

void test_protection_hardware_faults_are_seen_in_every_state(void)
{
    const drive_state_t state[] = {DRIVE_INIT, DRIVE_OFFSET_CALIBRATION, DRIVE_ALIGN, DRIVE_READY, DRIVE_RUN};
    for (size_t k = 0; k < COUNT_OF(state); k++) {
        bench_start();
        bench_into(state[k]);
        bench.inverter_fault = HAL_INVERTER_DRIVER_FAULT;
        bench_period();
        ASSERT_FAULT(FAULT_gate_driver, at("state %d", (int)state[k]));
    }
}

void test_protection_hardware_fault_is_named_before_what_it_does_to_the_sample(void)
{
    bench_into(DRIVE_RUN);
    bench.inverter_fault = HAL_INVERTER_OVER_CURRENT;
    bench.sample.ia_a = 25.0f;
    bench_period();

    ASSERT_FAULT(FAULT_hardware_over_current, "comparator and sample in the same period");
}

/* ---- memory that changes by itself ------------------------------------------------------------------------------------ */

/* A flipped exponent bit makes a number what is none, and no controller ever gets rid of it. */
void test_protection_current_controller_that_lost_its_state_is_off_in_the_same_period(void)
{
    FLOAT_ONLY();
    num_t *const state[] = {&drive.current.d.state.x, &drive.current.q.state.x};
    for (size_t k = 0; k < COUNT_OF(state); k++) {
        bench_start();
        drive_params_t p = bench_params();
        p.current_ki_v_per_as = 100.0f;
        bench_run_with(&p);
        bench_command(DRIVE_MODE_CURRENT, 0.0, 0.0, 1.0);
        bench_periods(10U);
        *state[k] = NOT_FINITE[0];
        bench_period();
        ASSERT_FAULT(FAULT_non_finite, k == 0U ? "d" : "q");

        drive_clear_fault(&drive); /* and the next start has another one */
        drive_background(&drive);
        drive_start(&drive);
        drive_background(&drive);
        bench_periods(10U);
        ASSERT_NO_FAULT("after a start");
        ASSERT_DUTIES_LEGAL("after a start");
    }
}

/* Highest bit of the count: 6.5 s without the speed loop, which would hold its last torque. */
void test_protection_speed_loop_does_not_stand_still_when_its_count_changes_by_itself(void)
{
    drive_params_t p = bench_params();
    bench_run_with(&p);
    bench_periods(20U);
    drive.speed_count = 0x8000U;
    bench_period();
    const uint32_t before = bench.requests;
    bench_periods(10U);
    TEST_ASSERT_TRUE(bench.requests > before);
}

/* ---- both sides of what is counted ---------------------------------------------------------------------------------- */

/* A number is one up to 1e12: below it is too much current, above it is none. */
void test_protection_current_beyond_1e12_is_no_number_and_below_is_too_much(void)
{
    bench_into(DRIVE_RUN);
    bench.sample.ia_a = 1.2e12f;
    bench_period();
    ASSERT_NO_FAULT("one impossible sample");
    TEST_ASSERT_EQUAL_UINT16(1U, drive.bad_samples);
    bench.sample.ia_a = 0.9e12f;
    bench_period();
    ASSERT_FAULT(FAULT_over_current, "0.9e12 A");
}

void test_protection_hardware_fault_that_no_list_has_is_the_gate_driver(void)
{
    for (int beyond = 0; beyond < 20; beyond++) {
        bench_start();
        bench_into(DRIVE_RUN);
        bench.inverter_fault = (hal_inverter_fault_t)((int)HAL_INVERTER_FAULTS + beyond);
        bench_period();
        ASSERT_FAULT(FAULT_gate_driver, "unknown");
    }
}

/* A number that stands or goes back is one sample; one that jumps ahead by half of all numbers less one is as many. */
void test_protection_number_that_stands_or_goes_back_is_one_lost_sample_and_a_jump_ahead_is_many(void)
{
    static const struct {
        uint32_t step;
        uint16_t lost;
    } ROW[] = {{0U, 1U}, {UINT32_C(0) - 5U, 1U}, {UINT32_C(0x80000000), 1U}, {2U, 1U}, {3U, 2U}};
    for (size_t k = 0; k < COUNT_OF(ROW); k++) {
        bench_start();
        bench_into(DRIVE_RUN);
        bench_period();
        bench.seq_by_itself = false;
        bench.sample.seq += ROW[k].step;
        bench_period();
        ASSERT_NO_FAULT(at("step %g", (double)ROW[k].step));
        TEST_ASSERT_EQUAL_UINT16_MESSAGE(ROW[k].lost, drive.lost_samples, at("step %g", (double)ROW[k].step));
    }
    bench_start();
    bench_into(DRIVE_RUN);
    bench_period();
    bench.seq_by_itself = false;
    bench.sample.seq += UINT32_C(0x7FFFFFFF);
    bench_period();
    ASSERT_FAULT(FAULT_lost_sample, "as far ahead as a number can be without being one that went back");
}

void test_protection_sample_of_a_failed_encoder_is_rejected_and_counted(void)
{
    bench_into(DRIVE_RUN);
    bench_period();
    const uint32_t rejected = drive_rejected(&drive);
    drive.sample.seq++;
    TEST_ASSERT_FALSE(drive_check_sample(&drive, HAL_SENSOR_FAULT, drive.sample.seq - 1U));
    TEST_ASSERT_EQUAL_UINT32(rejected + 1U, drive_rejected(&drive));
}

void test_protection_count_of_impossible_samples_stops_at_its_end(void)
{
    bench_into(DRIVE_RUN);
    bench.sample.ia_a = NAN;
    drive.bad_samples = UINT16_MAX;
    bench_period();
    TEST_ASSERT_EQUAL_UINT16(UINT16_MAX, drive.bad_samples);
    ASSERT_FAULT(FAULT_non_finite, "more than enough");
}

/* A sample behind a gap is judged in full: of the currents that the limit counts for, the offset is off. */
void test_protection_over_current_behind_a_gap_counts_after_the_offset(void)
{
    for (int over = 0; over < 2; over++) {
        bench_start();
        bench_into(DRIVE_RUN);
        bench_period();
        drive.offset_a_a = -0.4f;
        drive.sample.seq += 2U;
        drive.sample.ia_a = (over != 0) ? 19.7f : 19.5f; /* 20.1 and 19.9 A */
        TEST_ASSERT_TRUE(drive_check_sample(&drive, HAL_OK, drive.sample.seq - 2U));
        TEST_ASSERT_EQUAL_INT((over != 0) ? FAULT_over_current : FAULT_none, drive.fault);
    }
}
