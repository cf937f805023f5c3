/* sim_host/board/board.c: the contract of hal/ on the simulated machine. */
#include "hal/hal_clock.h"
#include "hal/hal_link.h"
#include "hal/hal_storage.h"
#include "sim_host/board/board.h"
#include "tests/sim_host/support/machine.h"

static sim_board_t board;

static void start(void)
{
    const char *const refused =
        sim_plant_start(&board.plant, &model, (const double (*)[SIM_EFFECT_PARAMS])effect_values, 4000.0, 1U);
    TEST_ASSERT_NULL_MESSAGE(refused, refused);
    sim_board_start(&board);
    sim_board_select(&board);
}

void setUp(void)
{
    machine_defaults();
    model.rotor_locked = 1.0;
    start();
}
void tearDown(void) {}

static void set(float a, float b, float c)
{
    const hal_duty_t duty = {a, b, c};
    TEST_ASSERT_EQUAL_INT(HAL_OK, hal_inverter_set_duty(&duty));
}

static double id_a(void) { return board.plant.x.id_a; }

static float rad_of(uint32_t theta) { return (float)(theta * (TWO_PI / 4294967296.0)); }

static hal_sample_t read_ok(void)
{
    hal_sample_t s;
    TEST_ASSERT_EQUAL_INT(HAL_OK, hal_sample_read(&s));
    return s;
}

/* ---- inverter ------------------------------------------------------------------------------------------------------- */

/* set in period k (before it elapses), acts in k + 1: the current moves one period later */
void test_board_duty_acts_one_period_after_it_was_set(void)
{
    TEST_ASSERT_EQUAL_INT(HAL_OK, hal_inverter_arm());
    sim_board_period(&board); /* armed from here on */
    sim_board_period(&board);
    set(0.6f, 0.5f, 0.5f); /* 24 V 0.1 2/3 = 1.6 V on phase a */
    sim_board_period(&board);
    TEST_ASSERT_EQUAL_DOUBLE(0.0, id_a());
    set(0.5f, 0.5f, 0.5f);
    sim_board_period(&board);
    const double one = 1.6 / 0.36 * (1.0 - exp(-0.18));
    ASSERT_REL(1e-5, one, id_a(), "one period of voltage"); /* one step per period: (0.18)^5 / 120, and float duties */

    sim_board_period(&board);
    ASSERT_REL(1e-5, one * exp(-0.18), id_a(), "and no more");
}

void test_board_duties_outside_zero_and_one_are_cut(void)
{
    const float duty[][2] = {{-0.5f, 0.0f}, {1.5f, 1.0f}, {NAN, 0.0f}, {INFINITY, 1.0f}, {0.25f, 0.25f}};
    for (size_t k = 0; k < COUNT_OF(duty); k++) {
        set(duty[k][0], duty[k][0], duty[k][0]);
        for (int phase = 0; phase < 3; phase++) {
            TEST_ASSERT_EQUAL_DOUBLE((double)duty[k][1], board.duty_next[phase]);
        }
    }
}

void test_board_gates_follow_arming_in_the_next_period(void)
{
    sim_board_period(&board); /* no longer the very start */
    TEST_ASSERT_EQUAL_INT(HAL_OK, hal_inverter_arm());
    TEST_ASSERT_FALSE(board.gates_on);
    sim_board_period(&board);
    TEST_ASSERT_TRUE(board.gates_on);
    TEST_ASSERT_EQUAL_UINT64(1U, board.gate_periods);
}

void test_board_armed_before_the_first_period_has_its_gates_on_in_it(void)
{
    TEST_ASSERT_EQUAL_INT(HAL_OK, hal_inverter_arm());
    TEST_ASSERT_TRUE(board.gates_on);
}

void test_board_disarm_takes_the_gates_off_at_once_and_again(void)
{
    TEST_ASSERT_EQUAL_INT(HAL_OK, hal_inverter_arm());
    set(0.6f, 0.5f, 0.5f);
    for (int k = 0; k < 10; k++) {
        sim_board_period(&board);
    }
    TEST_ASSERT_TRUE(id_a() > 1.0);
    const uint64_t before = board.gate_periods;

    hal_inverter_disarm();
    hal_inverter_disarm();
    TEST_ASSERT_FALSE(board.gates_on);
    for (int k = 0; k < 10; k++) {
        sim_board_period(&board);
    }

    TEST_ASSERT_EQUAL_UINT64(before, board.gate_periods);
    TEST_ASSERT_EQUAL_DOUBLE(0.0, id_a());
}

void test_board_hardware_fault_refuses_arming_and_is_remembered_until_cleared(void)
{
    board.disturbance.inverter_fault = HAL_INVERTER_DRIVER_FAULT;
    TEST_ASSERT_EQUAL_INT(HAL_SENSOR_FAULT, hal_inverter_arm());
    TEST_ASSERT_FALSE(board.armed);
    TEST_ASSERT_EQUAL_INT(HAL_INVERTER_DRIVER_FAULT, hal_inverter_fault());

    board.disturbance.inverter_fault = HAL_INVERTER_FINE; /* its cause is gone */
    TEST_ASSERT_EQUAL_INT(HAL_INVERTER_DRIVER_FAULT, hal_inverter_fault());
    TEST_ASSERT_EQUAL_INT(HAL_SENSOR_FAULT, hal_inverter_arm());

    hal_inverter_clear_fault();
    TEST_ASSERT_EQUAL_INT(HAL_INVERTER_FINE, hal_inverter_fault());
    TEST_ASSERT_EQUAL_INT(HAL_OK, hal_inverter_arm());
}

void test_board_first_hardware_fault_is_the_one_remembered(void)
{
    board.disturbance.inverter_fault = HAL_INVERTER_OVER_TEMPERATURE;
    (void)hal_inverter_fault();
    board.disturbance.inverter_fault = HAL_INVERTER_OVER_CURRENT;

    TEST_ASSERT_EQUAL_INT(HAL_INVERTER_OVER_TEMPERATURE, hal_inverter_fault());
}

void test_board_hardware_fault_comes_back_while_its_cause_stands(void)
{
    board.disturbance.inverter_fault = HAL_INVERTER_OVER_TEMPERATURE;
    (void)hal_inverter_fault();
    hal_inverter_clear_fault();

    TEST_ASSERT_EQUAL_INT(HAL_INVERTER_OVER_TEMPERATURE, hal_inverter_fault());
}

void test_board_failed_self_test_stands_until_the_next_start(void)
{
    for (int test = HAL_INVERTER_RAM_TEST; test <= HAL_INVERTER_PROCESSOR_TEST; test++) {
        sim_board_start(&board);
        board.disturbance.inverter_fault = (hal_inverter_fault_t)test;
        TEST_ASSERT_EQUAL_INT(test, hal_inverter_fault());
        board.disturbance.inverter_fault = HAL_INVERTER_FINE;
        hal_inverter_clear_fault();
        TEST_ASSERT_EQUAL_INT(test, hal_inverter_fault());
        TEST_ASSERT_EQUAL_INT(HAL_SENSOR_FAULT, hal_inverter_arm());
        sim_board_start(&board);
        TEST_ASSERT_EQUAL_INT(HAL_INVERTER_FINE, hal_inverter_fault());
    }
}

/* ---- samples -------------------------------------------------------------------------------------------------------- */

void test_board_sample_has_the_sensors_and_a_third_current(void)
{
    board.plant.x.id_a = 2.0; /* a: 2 A, b and c: -1 A */
    board.plant.x.theta_m_rad = 1.0;
    const hal_sample_t s = read_ok();

    TEST_ASSERT_FLOAT_WITHIN(1e-6f, 2.0f, s.ia_a);
    TEST_ASSERT_FLOAT_WITHIN(1e-6f, -1.0f, s.ib_a);
    TEST_ASSERT_EQUAL_FLOAT(-s.ia_a - s.ib_a, s.ic_a);
    TEST_ASSERT_EQUAL_FLOAT(24.0f, s.vdc_v);
    TEST_ASSERT_FLOAT_WITHIN(1e-6f, 636.0f * (float)(TWO_PI / 4000.0), rad_of(s.theta_m));
}

void test_board_samples_are_numbered_in_order(void)
{
    const uint32_t first = read_ok().seq;
    for (uint32_t k = 1U; k < 10U; k++) {
        sim_board_period(&board);
        TEST_ASSERT_EQUAL_UINT32(first + k, read_ok().seq);
    }
}

void test_board_lost_sample_is_stale_with_the_old_number_and_the_next_one_goes_on(void)
{
    const uint32_t before = read_ok().seq;
    board.disturbance.sample_lost = true;
    hal_sample_t s;
    TEST_ASSERT_EQUAL_INT(HAL_STALE, hal_sample_read(&s));
    TEST_ASSERT_EQUAL_UINT32(before, s.seq);

    board.disturbance.sample_lost = false;
    TEST_ASSERT_EQUAL_UINT32(before + 1U, read_ok().seq);
}

void test_board_broken_current_sensor_reads_as_no_number(void)
{
    board.disturbance.current_nan = true;
    const hal_sample_t s = read_ok();

    TEST_ASSERT_TRUE(isnan(s.ia_a));
    TEST_ASSERT_FALSE(isnan(s.ib_a));
}

void test_board_stuck_encoder_shows_the_angle_at_which_it_stuck(void)
{
    board.plant.x.theta_m_rad = 1.0;
    const float before = rad_of(read_ok().theta_m);
    board.disturbance.encoder_stuck = true;
    board.plant.x.theta_m_rad = 2.0;
    TEST_ASSERT_EQUAL_FLOAT(before, rad_of(read_ok().theta_m));

    board.disturbance.encoder_stuck = false;
    TEST_ASSERT_FLOAT_WITHIN(2e-3f, 2.0f, rad_of(read_ok().theta_m));
}

void test_board_stuck_encoder_has_no_edges(void)
{
    hal_encoder_edge_t e;
    board.plant.edge_count = 10;
    board.plant.edge_time_s = 0.25;
    TEST_ASSERT_EQUAL_INT(HAL_OK, hal_encoder_edge(&e));
    board.disturbance.encoder_stuck = true;
    board.plant.edge_count = 20;
    board.plant.edge_time_s = 0.5;
    TEST_ASSERT_EQUAL_INT(HAL_OK, hal_encoder_edge(&e));
    TEST_ASSERT_EQUAL_INT32(10, e.edge_count);
    TEST_ASSERT_EQUAL_UINT32(50000000U, e.edge_cyc);

    board.disturbance.encoder_stuck = false;
    TEST_ASSERT_EQUAL_INT(HAL_OK, hal_encoder_edge(&e));
    TEST_ASSERT_EQUAL_INT32(20, e.edge_count);
}

void test_board_encoder_error_shows_at_the_sample_and_at_the_edge_timer(void)
{
    board.disturbance.encoder_error = true;
    hal_sample_t       s;
    hal_encoder_edge_t e;

    TEST_ASSERT_EQUAL_INT(HAL_SENSOR_FAULT, hal_sample_read(&s));
    TEST_ASSERT_EQUAL_INT(HAL_SENSOR_FAULT, hal_encoder_edge(&e));
}

/* ---- time and edges ------------------------------------------------------------------------------------------------- */

void test_board_clock_counts_200_mhz_and_stands_during_an_interrupt(void)
{
    TEST_ASSERT_EQUAL_UINT32(200000000U, hal_clock_hz());
    const uint32_t t0 = hal_clock_cyc();
    TEST_ASSERT_EQUAL_UINT32(t0, hal_clock_cyc());
    for (uint32_t k = 1U; k <= 100U; k++) {
        sim_board_period(&board);
        TEST_ASSERT_EQUAL_UINT32(t0 + 20000U * k, hal_clock_cyc());
    }
}

/* 2^32 cycles are 21.47 s */
void test_board_clock_wraps_like_the_counter_of_the_chip(void)
{
    board.plant.time_s = 21.47483648 - 0.5e-4;
    const uint32_t before = hal_clock_cyc();
    board.plant.time_s += 1e-4;

    TEST_ASSERT_TRUE(hal_clock_cyc() < before);
    TEST_ASSERT_EQUAL_UINT32(20000U, hal_clock_cyc() - before);
}

void test_board_edge_has_position_and_time_in_cycles(void)
{
    board.plant.edge_count = -3;
    board.plant.edge_time_s = 0.25;
    hal_encoder_edge_t e;
    TEST_ASSERT_EQUAL_INT(HAL_OK, hal_encoder_edge(&e));

    TEST_ASSERT_EQUAL_INT32(-3, e.edge_count);
    TEST_ASSERT_EQUAL_UINT32(50000000U, e.edge_cyc);
}

/* Counts that were lost before the pulse are in its latch; those after it come with the next one. */
void test_board_index_is_latched_with_the_counts_that_were_lost_until_then(void)
{
    hal_encoder_edge_t e;
    board.plant.edge_pitch_rad = TWO_PI / 4000.0;
    board.plant.index_rad = 0.1;
    board.plant.index_passes = 1U;
    TEST_ASSERT_EQUAL_INT(HAL_OK, hal_encoder_edge(&e));
    TEST_ASSERT_EQUAL_UINT16(1U, e.index_passes);
    TEST_ASSERT_FLOAT_WITHIN(1e-6f, 0.1f, e.index_rad);

    board.disturbance.encoder_slip_rad = -0.2;
    TEST_ASSERT_EQUAL_INT(HAL_OK, hal_encoder_edge(&e));
    TEST_ASSERT_FLOAT_WITHIN(1e-6f, 0.1f, e.index_rad);
    board.plant.index_passes = 2U;
    TEST_ASSERT_EQUAL_INT(HAL_OK, hal_encoder_edge(&e));
    TEST_ASSERT_EQUAL_UINT16(2U, e.index_passes);
    TEST_ASSERT_FLOAT_WITHIN(0.8e-3f, (float)(TWO_PI - 0.1), e.index_rad); /* half a count */
}

void test_board_remembers_the_request_for_the_speed_interrupt(void)
{
    TEST_ASSERT_FALSE(board.speed_requested);
    hal_clock_request_speed_isr();
    TEST_ASSERT_TRUE(board.speed_requested);
}

/* ---- link ----------------------------------------------------------------------------------------------------------- */

void test_board_link_takes_octets_in_order_and_no_more_than_fit(void)
{
    uint16_t out[100];
    for (uint16_t k = 0U; k < 100U; k++) {
        out[k] = (uint16_t)(0xAB00U + k);
    }
    uint32_t taken = 0U;
    uint16_t n;
    while ((n = hal_link_write(out, 100U)) > 0U) {
        taken += n;
    }
    TEST_ASSERT_EQUAL_UINT32(SIM_LINK_OCTETS, taken);
    for (uint32_t k = 0U; k < taken; k++) { /* only the low 8 bits travel */
        TEST_ASSERT_EQUAL_HEX16(k % 100U, board.from_drive.octet[board.from_drive.tail++ % SIM_LINK_OCTETS]);
    }
    TEST_ASSERT_EQUAL_UINT16(100U, hal_link_write(out, 100U)); /* room again */
}

void test_board_link_gives_what_has_arrived_and_never_waits(void)
{
    uint16_t in[10];
    TEST_ASSERT_EQUAL_UINT16(0U, hal_link_read(in, 10U));
    for (uint16_t k = 0U; k < 13U; k++) {
        board.to_drive.octet[board.to_drive.head++ % SIM_LINK_OCTETS] = k;
    }
    TEST_ASSERT_EQUAL_UINT16(10U, hal_link_read(in, 10U));
    TEST_ASSERT_EQUAL_HEX16(9U, in[9]);
    TEST_ASSERT_EQUAL_UINT16(3U, hal_link_read(in, 10U));
    TEST_ASSERT_EQUAL_HEX16(12U, in[2]);
    TEST_ASSERT_EQUAL_UINT16(0U, hal_link_read(in, 10U));
}

/* ---- storage -------------------------------------------------------------------------------------------------------- */

void test_board_storage_starts_erased_and_keeps_what_is_written(void)
{
    const uint16_t words[4] = {1U, 2U, 0xFFFFU, 4U};
    uint16_t       back[5];
    TEST_ASSERT_EQUAL_INT(HAL_OK, hal_storage_write(1U, 8U, words, 4U));
    TEST_ASSERT_EQUAL_INT(HAL_OK, hal_storage_read(1U, 7U, back, 5U));

    TEST_ASSERT_EQUAL_HEX16(0xFFFFU, back[0]);
    TEST_ASSERT_EQUAL_HEX16_ARRAY(words, &back[1], 4U);
}

void test_board_storage_takes_whole_blocks_only(void)
{
    const uint16_t words[8] = {0U};
    uint16_t       back = 0U;
    TEST_ASSERT_EQUAL_INT(HAL_UNSUPPORTED, hal_storage_write(0U, 2U, words, 4U));
    TEST_ASSERT_EQUAL_INT(HAL_UNSUPPORTED, hal_storage_write(0U, 4U, words, 3U));
    TEST_ASSERT_EQUAL_INT(HAL_OK, hal_storage_read(0U, 4U, &back, 1U));
    TEST_ASSERT_EQUAL_HEX16(0xFFFFU, back);
    TEST_ASSERT_EQUAL_INT(HAL_OK, hal_storage_write(0U, 4U, words, 8U));
}

void test_board_storage_clears_bits_and_sets_none_until_erased(void)
{
    const uint16_t first[4] = {0x0F0FU, 0U, 0U, 0U};
    const uint16_t second[4] = {0xFF00U, 0U, 0U, 0U};
    uint16_t       back;
    TEST_ASSERT_EQUAL_INT(HAL_OK, hal_storage_write(0U, 0U, first, 4U));
    TEST_ASSERT_EQUAL_INT(HAL_OK, hal_storage_write(0U, 0U, second, 4U));
    TEST_ASSERT_EQUAL_INT(HAL_OK, hal_storage_read(0U, 0U, &back, 1U));
    TEST_ASSERT_EQUAL_HEX16(0x0F00U, back);

    TEST_ASSERT_EQUAL_INT(HAL_OK, hal_storage_erase(0U));
    TEST_ASSERT_EQUAL_INT(HAL_OK, hal_storage_read(0U, 0U, &back, 1U));
    TEST_ASSERT_EQUAL_HEX16(0xFFFFU, back);
}

void test_board_storage_erases_one_page_only(void)
{
    const uint16_t word[4] = {0x1234U, 0U, 0U, 0U};
    uint16_t       back;
    TEST_ASSERT_EQUAL_INT(HAL_OK, hal_storage_write(1U, 0U, word, 4U));
    TEST_ASSERT_EQUAL_INT(HAL_OK, hal_storage_erase(0U));
    TEST_ASSERT_EQUAL_INT(HAL_OK, hal_storage_erase(2U));
    TEST_ASSERT_EQUAL_INT(HAL_OK, hal_storage_read(1U, 0U, &back, 1U));

    TEST_ASSERT_EQUAL_HEX16(word[0], back);
}

void test_board_storage_refuses_what_is_outside_of_it(void)
{
    uint16_t       words[8] = {0U};
    const uint16_t pages = hal_storage_pages();
    const uint16_t size = hal_storage_page_words();
    TEST_ASSERT_EQUAL_INT(HAL_UNSUPPORTED, hal_storage_read(pages, 0U, words, 1U));
    TEST_ASSERT_EQUAL_INT(HAL_UNSUPPORTED, hal_storage_write(pages, 0U, words, 1U));
    TEST_ASSERT_EQUAL_INT(HAL_UNSUPPORTED, hal_storage_erase(pages));
    TEST_ASSERT_EQUAL_INT(HAL_UNSUPPORTED, hal_storage_read(0U, (uint16_t)(size - 7U), words, 8U));
    TEST_ASSERT_EQUAL_INT(HAL_UNSUPPORTED, hal_storage_write(0U, UINT16_MAX, words, 8U));
    TEST_ASSERT_EQUAL_INT(HAL_OK, hal_storage_read(0U, (uint16_t)(size - 8U), words, 8U));
}

void test_board_storage_is_busy_while_the_bridge_is_armed(void)
{
    const uint16_t word[4] = {0U};
    uint16_t       back;
    TEST_ASSERT_EQUAL_INT(HAL_OK, hal_inverter_arm());
    TEST_ASSERT_EQUAL_INT(HAL_BUSY, hal_storage_write(0U, 0U, word, 4U));
    TEST_ASSERT_EQUAL_INT(HAL_BUSY, hal_storage_erase(0U));
    TEST_ASSERT_EQUAL_INT(HAL_OK, hal_storage_read(0U, 0U, &back, 1U));
    TEST_ASSERT_EQUAL_HEX16(0xFFFFU, back);

    hal_inverter_disarm();
    TEST_ASSERT_EQUAL_INT(HAL_OK, hal_storage_write(0U, 0U, word, 4U));
}

void test_board_start_forgets_everything(void)
{
    const uint16_t word[4] = {0U};
    TEST_ASSERT_EQUAL_INT(HAL_OK, hal_storage_write(0U, 0U, word, 4U));
    TEST_ASSERT_EQUAL_INT(HAL_OK, hal_inverter_arm());
    board.disturbance.sample_lost = true;
    set(0.9f, 0.1f, 0.1f);
    sim_board_period(&board);
    start();

    uint16_t back;
    TEST_ASSERT_EQUAL_INT(HAL_OK, hal_storage_read(0U, 0U, &back, 1U));
    TEST_ASSERT_EQUAL_HEX16(0xFFFFU, back);
    TEST_ASSERT_FALSE(board.armed);
    TEST_ASSERT_FALSE(board.gates_on);
    TEST_ASSERT_EQUAL_UINT64(0U, board.gate_periods);
    TEST_ASSERT_EQUAL_DOUBLE(0.5, board.duty_next[0]);
    (void)read_ok();
}

/* ---- two boards ----------------------------------------------------------------------------------------------------- */

void test_board_functions_mean_the_board_that_was_selected(void)
{
    static sim_board_t other;
    TEST_ASSERT_NULL(sim_plant_start(&other.plant, &model, (const double (*)[SIM_EFFECT_PARAMS])effect_values, 4000.0, 1U));
    sim_board_start(&other);
    sim_board_select(&other);
    TEST_ASSERT_EQUAL_INT(HAL_OK, hal_inverter_arm());

    TEST_ASSERT_TRUE(other.armed);
    TEST_ASSERT_FALSE(board.armed);
}

/* ---- brake resistor ------------------------------------------------------------------------------------------------- */

/* 1 mF into 10 ohm at half of the time: a time constant of 20 ms, from 24 V, no source. Nobody calls again: 20 ms, and it is off. */
void test_board_brake_resistor_is_off_20_ms_after_the_last_call(void)
{
    model.dc_link_f = 1e-3;
    model.brake_ohm = 10.0;
    start();
    board.plant.outside.dc_link_v = 0.0;
    hal_brake_duty(0.5f);
    for (int k = 1; k <= 200; k++) {
        sim_board_period(&board);
        TEST_ASSERT_DOUBLE_WITHIN_MESSAGE(1e-6, 24.0 * exp(-1e-4 * k / 20e-3), sim_plant_dc_link_v(&board.plant),
                                          at("period %d", k));
    }
    const double left = sim_plant_dc_link_v(&board.plant);
    sim_board_period(&board);
    TEST_ASSERT_EQUAL_DOUBLE(left, sim_plant_dc_link_v(&board.plant));
    hal_brake_duty(2.0f);
    sim_board_period(&board);
    TEST_ASSERT_DOUBLE_WITHIN(1e-6, left * exp(-0.01), sim_plant_dc_link_v(&board.plant));
    hal_brake_duty((float)NAN);
    sim_board_period(&board);
    TEST_ASSERT_DOUBLE_WITHIN(1e-6, left * exp(-0.01), sim_plant_dc_link_v(&board.plant));
}

/* No firmware takes part: each channel has its own way to the gates. */
void test_board_channel_of_safe_torque_off_takes_the_gates_away_by_itself(void)
{
    for (uint16_t channels = 1U; channels <= HAL_STO_BOTH; channels++) {
        start();
        TEST_ASSERT_EQUAL_INT(HAL_OK, hal_inverter_arm());
        set(0.6f, 0.45f, 0.45f);
        sim_board_period(&board);
        sim_board_period(&board);
        const double before_a = id_a();
        TEST_ASSERT_TRUE(board.gates_on && (before_a > 1.0));
        board.disturbance.sto = channels;
        const uint64_t gates = board.gate_periods;
        sim_board_period(&board);
        TEST_ASSERT_TRUE_MESSAGE(id_a() < 0.5 * before_a, at("%g A", id_a())); /* the diodes, from this period on */
        TEST_ASSERT_EQUAL_UINT16(channels, hal_sto());
        TEST_ASSERT_EQUAL_INT(HAL_INVERTER_STO, hal_inverter_fault());
        hal_inverter_clear_fault();
        TEST_ASSERT_EQUAL_INT(HAL_SENSOR_FAULT, hal_inverter_arm());
        sim_board_period(&board);
        TEST_ASSERT_FALSE(board.gates_on);
        TEST_ASSERT_EQUAL_UINT64(gates, board.gate_periods);
    }
}
