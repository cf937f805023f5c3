/* The program of the board, from power-on to a turning motor, through the registers of the fake chip. */
#include <math.h>

#include "firmware/link/frame.h"
#include "firmware/link/protocol.h"
#include "tests/hal/support/virtual_chip.h"

#define CALIBRATION 4200                 /* periods: 4096, and some */
#define ALIGNMENT 12000                  /* shorter than the default, with nothing on the shaft */
#define ALIGNED (1000 + ALIGNMENT + 500) /* 0.1 s in which the shaft rests before it */

void setUp(void) { world_begin(1.0); }
void tearDown(void) {}

static void start_up(void)
{
    drive_params_t params;
    uint16_t       culprit;
    TEST_ASSERT_EQUAL(PORT_OK, main_start());
    world_run(CALIBRATION);
    TEST_ASSERT_EQUAL(DRIVE_READY, main_drive()->state);
    params = *main_drive()->params;
    params.align_periods = ALIGNMENT;
    TEST_ASSERT_TRUE(drive_tune(main_drive(), &params, &culprit));
    world_run(20);
    drive_start(main_drive());
    world_run(ALIGNED);
    TEST_ASSERT_EQUAL_MESSAGE(FAULT_none, main_drive()->fault, "start-up");
    TEST_ASSERT_EQUAL(DRIVE_RUN, main_drive()->state);
    drive_stop(main_drive());
    world_run(20);
    TEST_ASSERT_EQUAL(DRIVE_READY, main_drive()->state);
}

static void turn_at(float rad_s)
{
    const drive_command_t command = {.mode = DRIVE_MODE_SPEED, .speed_ref_rad_s = rad_s};
    TEST_ASSERT_TRUE(drive_command(main_drive(), &command));
    drive_start(main_drive());
    world_run(10000);
    TEST_ASSERT_EQUAL(FAULT_none, main_drive()->fault);
    TEST_ASSERT_EQUAL(DRIVE_RUN, main_drive()->state);
    TEST_ASSERT_DOUBLE_WITHIN(0.01 * fabs((double)rad_s), (double)rad_s, plant.x.speed_rad_s);
}

static double largest_current(void)
{
    double i[3];
    sim_plant_phase_currents(&plant, i);
    return fmax(fabs(i[0]), fmax(fabs(i[1]), fabs(i[2])));
}

void test_virtual_chip_calibrates_offsets_with_the_bridge_off(void)
{
    amplifier_offset_v[0] = 0.030; /* 0.43 A, as seen on the bench */
    amplifier_offset_v[1] = -0.010;
    amplifier_offset_v[2] = 0.020;
    TEST_ASSERT_EQUAL(PORT_OK, main_start());

    world_run(4050); /* of 4096 */
    TEST_ASSERT_EQUAL(DRIVE_OFFSET_CALIBRATION, main_drive()->state);
    TEST_ASSERT_EQUAL_UINT32(0U, periods_with_gates_on);
    world_run(150);

    TEST_ASSERT_FLOAT_WITHIN(0.0105f /* count */, 0.4286f, main_drive()->offset_a_a);
    TEST_ASSERT_FLOAT_WITHIN(0.0105f, -0.1429f, main_drive()->offset_b_a);
    TEST_ASSERT_FLOAT_WITHIN(0.0105f, 0.2857f, main_drive()->offset_c_a);
    TEST_ASSERT_EQUAL(DRIVE_READY, main_drive()->state);
}

void test_virtual_chip_refuses_an_amplifier_without_a_plausible_zero(void)
{
    amplifier_offset_v[1] = 0.2; /* 2.9 A */
    TEST_ASSERT_EQUAL(PORT_OK, main_start());

    world_run(CALIBRATION);

    TEST_ASSERT_EQUAL(FAULT_offset_calibration, main_drive()->fault);
    TEST_ASSERT_EQUAL_UINT32(0U, periods_with_gates_on);
}

void test_virtual_chip_does_nothing_without_a_start_and_aligns_with_the_first(void)
{
    const double before = plant.x.theta_m_rad;
    TEST_ASSERT_EQUAL(PORT_OK, main_start());
    world_run(100000); /* 10 s */
    TEST_ASSERT_EQUAL_UINT32(0U, periods_with_gates_on);
    TEST_ASSERT_EQUAL_DOUBLE(before, plant.x.theta_m_rad);

    world_begin(1.0);
    start_up();
    const uint32_t gates = periods_with_gates_on;
    TEST_ASSERT_UINT32_WITHIN(600U, (uint32_t)ALIGNMENT, gates); /* 36 quarters of a turn of whole periods, and some of the run */
    world_run(100);
    TEST_ASSERT_EQUAL_UINT32(gates, periods_with_gates_on);
    /* what the drive takes for the electrical angle is that of the rotor, within 3 degrees */
    const double off = (double)main_drive()->tracking.theta_e / 4294967296.0 * 6.283185307 - 4.0 * plant.x.theta_m_rad;
    TEST_ASSERT_DOUBLE_WITHIN(0.052, 0.0, remainder(off, 6.283185307));
}

void test_virtual_chip_turns_at_the_commanded_speed_both_ways(void)
{
    start_up();

    turn_at(104.72f); /* 1000 r/min */
    turn_at(-52.36f);

    TEST_ASSERT_NOT_EQUAL(0U, main_drive()->speed.edge.index_passes);
    TEST_ASSERT_FALSE(chip.adc_overflow);
}

void test_virtual_chip_turns_with_swapped_encoder_tracks_when_told(void)
{
    encoder_reversed = true;
    TEST_ASSERT_EQUAL(PORT_OK, main_start());
    drive_params_t params = *main_drive()->params;
    uint16_t       culprit;
    params.encoder_reversed = 1U;
    TEST_ASSERT_TRUE(drive_tune(main_drive(), &params, &culprit));
    world_run(CALIBRATION);
    params = *main_drive()->params;
    params.align_periods = ALIGNMENT;
    TEST_ASSERT_TRUE(drive_tune(main_drive(), &params, &culprit));
    world_run(20);
    drive_start(main_drive());
    world_run(ALIGNED);

    turn_at(104.72f);
}

void test_virtual_chip_measures_speed_by_edges_without_quantisation(void)
{
    start_up();
    turn_at(104.72f);

    double mean = 0.0;
    for (int k = 0; k < 100; k++) {
        world_run(10);
        const double error = (double)drive_speed_rad_s(main_drive()) - plant.x.speed_rad_s;
        mean += error * error / 100.0;
    }

    /* counting edges alone would be off by 1.57 rad/s, one count in a millisecond */
    TEST_ASSERT_DOUBLE_WITHIN(0.05, 0.0, sqrt(mean));
}

void test_virtual_chip_trips_on_over_current_in_the_same_period_and_restarts(void)
{
    start_up();
    turn_at(104.72f);

    short_circuit_a = 25.0;
    const uint32_t gates = periods_with_gates_on;
    world_run(1);
    TEST_ASSERT_EQUAL_UINT32(gates, periods_with_gates_on);
    TEST_ASSERT_EQUAL(FAULT_hardware_over_current, main_drive()->fault);

    short_circuit_a = 0.0;
    world_run(100);
    TEST_ASSERT_DOUBLE_WITHIN(1e-6, 0.0, largest_current());
    TEST_ASSERT_EQUAL(DRIVE_FAULT, main_drive()->state);

    drive_clear_fault(main_drive());
    world_run(2);
    TEST_ASSERT_EQUAL(DRIVE_READY, main_drive()->state);
    TEST_ASSERT_EQUAL_UINT32(gates, periods_with_gates_on);
    turn_at(104.72f);
}

void test_virtual_chip_does_not_restart_while_the_cause_stands(void)
{
    start_up();
    turn_at(104.72f);
    short_circuit_a = 25.0;
    world_run(1);
    const uint32_t gates = periods_with_gates_on;

    drive_clear_fault(main_drive());
    world_run(2);
    drive_start(main_drive());
    world_run(100);

    TEST_ASSERT_EQUAL(DRIVE_FAULT, main_drive()->state);
    TEST_ASSERT_EQUAL_UINT32(gates, periods_with_gates_on);
}

void test_virtual_chip_trips_on_nfault_and_names_the_gate_driver(void)
{
    start_up();
    turn_at(104.72f);

    chip.drv_cause[3] = 0x040; /* VREG_UV */
    chip.drv[3] = 0x040;
    world_run(1);
    TEST_ASSERT_EQUAL(FAULT_gate_driver, main_drive()->fault);
    world_run(2);
    TEST_ASSERT_EQUAL(FAULT_gate_driver_supply, main_drive()->fault); /* the main loop has asked it meanwhile */

    chip.drv_cause[3] = 0U;
    drive_clear_fault(main_drive());
    world_run(2);
    turn_at(104.72f);
}

void test_virtual_chip_trips_on_the_fourth_encoder_phase_error(void)
{
    start_up();
    turn_at(104.72f);

    for (int k = 0; k < 3; k++) {
        chip.qep_flags = EQEP_INT_PHASE_ERROR;
        world_run(1);
        TEST_ASSERT_EQUAL(FAULT_none, main_drive()->fault);
    }
    chip.qep_flags = EQEP_INT_PHASE_ERROR;
    world_run(1);

    TEST_ASSERT_EQUAL(FAULT_encoder_error, main_drive()->fault);
    TEST_ASSERT_FALSE(fake_gate_follows(0) || fake_gate_follows(1) || fake_gate_follows(2));
}

void test_virtual_chip_stops_on_command_with_every_gate_off(void)
{
    start_up();
    turn_at(104.72f);

    drive_stop(main_drive());
    world_run(2);

    TEST_ASSERT_EQUAL(DRIVE_READY, main_drive()->state);
    for (int k = 0; k < 3; k++) {
        TEST_ASSERT_TRUE(fake_gate_is_low(k));
    }
}

void test_virtual_chip_feeds_its_watchdog_all_the_time(void)
{
    start_up();
    turn_at(104.72f);

    TEST_ASSERT_TRUE(chip.watchdog_on);
    TEST_ASSERT_LESS_THAN_UINT32(520U / 4U, longest_hunger); /* it bites after 520 periods */
    TEST_ASSERT_EQUAL(0, chip.watchdog_too_soon);
}

/* The counter is looked at twice in an interrupt; a look takes 4 cycles. */
void test_virtual_chip_measures_how_long_its_interrupts_take(void)
{
    start_up();
    chip.interrupt_cycles = 2000U;
    turn_at(104.72f);

    const timing_t *const t = &main_drive()->timing;
    TEST_ASSERT_UINT32_WITHIN(10U, 2004U, t->current.min_cyc);
    TEST_ASSERT_UINT32_WITHIN(10U, 2004U, t->current.max_cyc);
    TEST_ASSERT_UINT32_WITHIN(10U, 2004U, t->speed.last_cyc);
    TEST_ASSERT_UINT32_WITHIN(3U, 10000U, timing_bin(&t->current, 3U)); /* 2004 */
    TEST_ASSERT_UINT32_WITHIN(3U, 1000U, timing_bin(&t->speed, 3U));
}

void test_virtual_chip_trips_on_an_interrupt_longer_than_its_period(void)
{
    start_up();
    turn_at(104.72f);
    chip.interrupt_cycles = 19990U;
    world_period();
    TEST_ASSERT_EQUAL(FAULT_none, main_drive()->fault);
    chip.interrupt_cycles = 20001U;
    world_make_up_time(); /* all looks at the counter together took longer than the period before */
    world_period();

    TEST_ASSERT_EQUAL(FAULT_isr_overrun, main_drive()->fault);
    for (int k = 0; k < 3; k++) {
        TEST_ASSERT_TRUE(fake_gate_is_low(k));
    }
}

void test_virtual_chip_halted_by_a_debugger_switches_off_and_says_so(void)
{
    start_up();
    turn_at(104.72f);

    fake_halt(2000000U); /* 10 ms: no instruction runs */
    TEST_ASSERT_TRUE(fake_gate_is_low(0) && fake_gate_is_low(1) && fake_gate_is_low(2));
    world_make_up_time();
    world_run(1);

    TEST_ASSERT_EQUAL(FAULT_processor_halted, main_drive()->fault);
    drive_clear_fault(main_drive());
    world_run(2);
    turn_at(104.72f);
}

void test_virtual_chip_whose_clock_fails_switches_off_and_says_so(void)
{
    start_up();
    turn_at(104.72f);

    chip.clock_failed = true;
    fake_trips();
    TEST_ASSERT_TRUE(fake_gate_is_low(0) && fake_gate_is_low(1) && fake_gate_is_low(2));
    world_run(1);

    TEST_ASSERT_EQUAL(FAULT_processor_clock, main_drive()->fault);
}

/* Interrupts masked for good: the hardware alone, 2.1 periods after the last one; then the main loop says which fault. */
void test_virtual_chip_whose_current_interrupt_stops_is_off_within_two_periods_and_a_bit(void)
{
    start_up();
    turn_at(104.72f);

    chip.intm = true;
    world_period();
    TEST_ASSERT_TRUE(fake_gate_follows(0));
    world_period();
    world_period();
    TEST_ASSERT_TRUE(fake_gate_is_low(0) && fake_gate_is_low(1) && fake_gate_is_low(2));
    main_pass();

    TEST_ASSERT_EQUAL(FAULT_late_interrupt, main_drive()->fault);
}

void test_virtual_chip_long_blockage_at_rest_is_counted_in_periods_and_no_fault(void)
{
    TEST_ASSERT_EQUAL(PORT_OK, main_start());
    world_run(CALIBRATION);
    const uint32_t before = main_drive()->sample.seq;

    chip.intm = true; /* at rest: the guard switches nothing off */
    for (int k = 0; k < 50; k++) {
        world_period();
    }
    chip.intm = false;
    fake_interrupts();

    TEST_ASSERT_EQUAL_UINT32(before + 50U, main_drive()->sample.seq);
    TEST_ASSERT_EQUAL(FAULT_none, main_drive()->fault); /* one gap, and no voltage on the motor */
    port_background();
    TEST_ASSERT_EQUAL_UINT32(49U, port_health()->lost_periods);
}

/* Phase b reads a tenth of its current, as a dead amplifier does that another one leaks into. */
void test_virtual_chip_dead_current_amplifier_is_found_by_the_sum_of_the_currents(void)
{
    start_up();
    drive_stop(main_drive());
    world_run(20);
    drive_params_t params = *main_drive()->params;
    uint16_t       culprit;
    params.plausibility_share = 0.0f; /* the motor's equations would find it first */
    TEST_ASSERT_TRUE(drive_tune(main_drive(), &params, &culprit));
    world_run(20);
    drive_start(main_drive());
    turn_at(104.72f);
    amplifier_gain[1] = 0.1;
    drive_command_t command = {.mode = DRIVE_MODE_CURRENT, .iq_ref_a = 3.0f};
    TEST_ASSERT_TRUE(drive_command(main_drive(), &command));
    world_run(600);

    TEST_ASSERT_EQUAL(FAULT_current_sum, main_drive()->fault);
}

/* In the alignment the vector of 4 A passes every phase: each amplifier is compared with the other two before the drive runs. */
void test_virtual_chip_amplifier_without_any_signal_is_found_in_the_alignment(void)
{
    for (int k = 0; k < 3; k++) {
        world_begin(1.0);
        amplifier_gain[k] = 0.0;
        TEST_ASSERT_EQUAL(PORT_OK, main_start());
        world_run(CALIBRATION);
        TEST_ASSERT_EQUAL(DRIVE_READY, main_drive()->state); /* its zero is as good as any */
        drive_start(main_drive());
        world_run(40000);

        TEST_ASSERT_EQUAL(FAULT_current_sum, main_drive()->fault);
    }
}

/* Gains that are off by 2 %, one against the other two, and zeros as bad as they may be: nothing is wrong. */
void test_virtual_chip_amplifiers_within_their_tolerance_add_up(void)
{
    amplifier_offset_v[0] = 0.045;
    amplifier_offset_v[1] = -0.03;
    amplifier_offset_v[2] = 0.045;
    amplifier_gain[0] = 1.02;
    amplifier_gain[1] = 0.98;
    amplifier_gain[2] = 1.02;
    start_up();
    turn_at(104.72f);
    turn_at(-104.72f);

    TEST_ASSERT_EQUAL(FAULT_none, main_drive()->fault);
}

void test_virtual_chip_without_a_trip_answers_and_never_switches_a_gate(void)
{
    chip.trip_zone_dead = true;
    TEST_ASSERT_EQUAL(PORT_TRIP_UNARMED, main_start());
    world_run(CALIBRATION);
    TEST_ASSERT_EQUAL(FAULT_trip_path, main_drive()->fault);

    drive_clear_fault(main_drive());
    world_run(2);
    drive_start(main_drive());
    world_run(100);

    TEST_ASSERT_EQUAL(FAULT_trip_path, main_drive()->fault);
    TEST_ASSERT_EQUAL_UINT32(0U, periods_with_gates_on);
}

/* No encoder but the one that the port computes with, no voltage that the driver warns of, no speed at which an open bridge
 * charges the link: whatever comes over the link. */
void test_virtual_chip_keeps_its_own_limits_against_parameters(void)
{
    TEST_ASSERT_EQUAL(PORT_OK, main_start());
    world_run(10);
    uint16_t       culprit;
    drive_params_t params = *main_drive()->params;
    TEST_ASSERT_EQUAL_FLOAT(4000.0f, params.encoder_counts);
    TEST_ASSERT_EQUAL_FLOAT(32.0f, params.over_voltage_v);
    TEST_ASSERT_TRUE(params.over_speed_rad_s * 1.7320508f * 4.0f * 6.4e-3f < 24.0f);

    params.encoder_counts = 8192.0f;
    TEST_ASSERT_FALSE(drive_tune(main_drive(), &params, &culprit));
    TEST_ASSERT_EQUAL_UINT16(PARAM_encoder_counts, culprit);
    float low, high;
    drive_relation(&params, PARAM_encoder_counts, &low, &high);
    TEST_ASSERT_EQUAL_FLOAT(4000.0f, low);
    TEST_ASSERT_EQUAL_FLOAT(4000.0f, high);

    params = *main_drive()->params;
    params.over_voltage_v = 33.0f;
    TEST_ASSERT_FALSE(drive_tune(main_drive(), &params, &culprit));
    TEST_ASSERT_EQUAL_UINT16(PARAM_over_voltage_v, culprit);
    params = *main_drive()->params;
    params.over_current_a = 18.1f;
    TEST_ASSERT_FALSE(drive_tune(main_drive(), &params, &culprit));
    TEST_ASSERT_EQUAL_UINT16(PARAM_over_current_a, culprit);
}

/* Coasting at 250 rad/s the motor's voltage is 6.4 V. Its short circuit drives 3.2 A in a period; a current loop that began at no
 * voltage would let it rise on. */
void test_virtual_chip_start_into_a_turning_motor_keeps_its_currents(void)
{
    start_up();
    turn_at(250.0f);
    drive_stop(main_drive());
    world_run(50);
    TEST_ASSERT_TRUE(plant.x.speed_rad_s > 240.0);
    const drive_command_t hold = {.mode = DRIVE_MODE_CURRENT};
    TEST_ASSERT_TRUE(drive_command(main_drive(), &hold));
    drive_start(main_drive());
    double peak_a = 0.0;
    for (int k = 0; k < 50; k++) {
        world_run(1);
        peak_a = fmax(peak_a, largest_current());
    }

    TEST_ASSERT_EQUAL(FAULT_none, main_drive()->fault);
    TEST_ASSERT_EQUAL(DRIVE_RUN, main_drive()->state);
    TEST_ASSERT_TRUE_MESSAGE(peak_a < 5.0, "more than the short circuit of one period");
}

static int periods_left;

static void world_of_main(void)
{
    if (periods_left-- > 0) {
        world_period();
    } else {
        longjmp(chip.escape, 1);
    }
}

void test_virtual_chip_main_itself_comes_to_ready(void)
{
    periods_left = CALIBRATION + 10000;
    chip.on_clock = &world_of_main;

    if (setjmp(chip.escape) == 0) {
        (void)board_main();
        TEST_FAIL_MESSAGE("main returned");
    }

    TEST_ASSERT_EQUAL(DRIVE_READY, main_drive()->state);
}

void test_virtual_chip_answers_the_bench_through_its_serial_port(void)
{
    frame_t         request;
    frame_decoder_t decoder;
    uint16_t        wire[FRAME_WIRE_MAX];
    TEST_ASSERT_EQUAL(PORT_OK, main_start());
    world_run(10);
    frame_begin(&request, LINK_alive, 77U);
    const uint16_t count = frame_end(&request, wire);
    for (uint16_t i = 0U; i < count; i++) {
        chip.rx[i] = wire[i];
    }
    chip.rx_count = count; /* 9 octets: within the FIFO */
    chip.tx_count = 0U;

    for (int k = 0; k < 10; k++) {
        chip.tx_room = 16U;
        world_run(1);
    }

    uint16_t good = 0U;
    frame_decoder_reset(&decoder);
    for (uint16_t i = 0U; i < chip.tx_count; i++) {
        good += (frame_decode(&decoder, chip.tx[i]) == FRAME_GOOD) ? 1U : 0U;
    }
    TEST_ASSERT_EQUAL_UINT16(1U, good);
    TEST_ASSERT_EQUAL_HEX16(LINK_alive + LINK_ANSWER, frame_type(&decoder));
    TEST_ASSERT_EQUAL_UINT16(77U, frame_seq(&decoder));
    codec_reader_t r = frame_payload(&decoder);
    const uint32_t counter = codec_get_u32(&r);
    TEST_ASSERT_TRUE((counter > 10U) && (counter <= 20U)); /* periods since the start */
    TEST_ASSERT_EQUAL_UINT16(DRIVE_OFFSET_CALIBRATION, codec_get_u8(&r));
}
