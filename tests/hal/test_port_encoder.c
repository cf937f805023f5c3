/* eQEP: angle with wrap and both directions, edges and their times, index, phase error. */
#include <math.h>

#include "tests/hal/support/started.h"

#define COUNT_RAD 0.00157079633f /* 2 pi / 4000 */
#define TICK_CYC 2               /* resolution of the edge timer */

void setUp(void)
{
    started();
    period();
}
void tearDown(void) {}

/* The encoder shows @p position from now on, and passed its last edge @p ago cycles before the next zero. */
static void turn_to(uint32_t position, int16_t direction, uint32_t ago)
{
    chip.qep_position = position;
    chip.qep_direction = direction;
    chip.qep_edge_cycles = chip.cycles + 20000U - ago;
    period();
}

static float rad(void) { return (float)((double)sample.theta_m * 6.283185307179586 / 4294967296.0); }

void test_decoder_counts_every_edge_of_a_turn_and_starts_over(void)
{
    TEST_ASSERT_EQUAL(1, TIMES_CALLED("EQEP_setDecoderConfig", EQEP1_BASE, 0U));
    TEST_ASSERT_EQUAL(1, TIMES_CALLED("EQEP_setPositionCounterConfig", EQEP1_BASE, EQEP_POSITION_RESET_MAX_POS, 3999U));
    TEST_ASSERT_EQUAL(1, TIMES_CALLED("EQEP_setLatchMode", EQEP1_BASE, EQEP_LATCH_CNT_READ_BY_CPU | EQEP_LATCH_RISING_INDEX));
    TEST_ASSERT_EQUAL(1, TIMES_CALLED("EQEP_setCaptureConfig", EQEP1_BASE, EQEP_CAPTURE_CLK_DIV_2, EQEP_UNIT_POS_EVNT_DIV_1));
}

void test_angle_of_every_count_is_its_part_of_a_turn(void)
{
    for (uint32_t count = 0U; count < 4000U; count += 13U) {
        chip.qep_position = count;
        period();

        const double want = (double)count / 4000.0 * 4294967296.0;
        TEST_ASSERT_TRUE(fabs((double)sample.theta_m - want) <= 1.1); /* cut, and 2^-16 of a step a count */
    }
}

void test_edge_is_read_with_interrupts_off_and_leaves_them_as_they_were(void)
{
    hal_encoder_edge_t read;
    fake_forget_calls();
    chip.intm = false;
    TEST_ASSERT_EQUAL(HAL_OK, hal_encoder_edge(&read));
    TEST_ASSERT_FALSE(chip.intm);
    TEST_ASSERT_TRUE(CALLED_AT_ALL("Interrupt_disableGlobal") >= 0);

    chip.intm = true; /* inside an interrupt */
    TEST_ASSERT_EQUAL(HAL_OK, hal_encoder_edge(&read));
    TEST_ASSERT_TRUE(chip.intm);
}

void test_angle_is_counts_of_a_turn(void)
{
    turn_to(1000U, 1, 100U);

    TEST_ASSERT_FLOAT_WITHIN(1e-6f, 1.57079633f, rad());
}

void test_angle_wraps_upwards_while_edges_count_on(void)
{
    turn_to(1999U, 1, 100U);
    turn_to(3998U, 1, 100U);
    turn_to(2U, 1, 100U);

    TEST_ASSERT_FLOAT_WITHIN(1e-6f, 2.0f * COUNT_RAD, rad());
    TEST_ASSERT_EQUAL_INT32(4002, edge.edge_count);
}

void test_angle_wraps_downwards_while_edges_count_on(void)
{
    turn_to(3997U, -1, 100U);

    TEST_ASSERT_FLOAT_WITHIN(1e-5f, 6.28318531f - (3.0f * COUNT_RAD), rad());
    TEST_ASSERT_EQUAL_INT32(-2, edge.edge_count); /* at -3 now; the edge between -3 and -2 was the last */
}

void test_edge_has_one_position_whichever_way_it_is_passed(void)
{
    turn_to(10U, 1, 100U);
    TEST_ASSERT_EQUAL_INT32(10, edge.edge_count);

    turn_to(9U, -1, 100U); /* back over the same edge */

    TEST_ASSERT_EQUAL_INT32(10, edge.edge_count);
}

void test_edge_time_is_when_it_was_passed(void)
{
    turn_to(5U, 1, 12346U);

    const uint32_t passed = (uint32_t)(chip.qep_edge_cycles - chip.timer_start);
    TEST_ASSERT_UINT32_WITHIN(TICK_CYC + 8 /* reading the clock */, passed, edge.edge_cyc);
}

void test_edge_time_stays_while_there_is_no_new_edge(void)
{
    turn_to(5U, 1, 7000U);
    const hal_encoder_edge_t before = edge;

    for (int i = 0; i < 20; i++) { /* the capture timer wraps meanwhile */
        period();
    }

    TEST_ASSERT_EQUAL_UINT32(before.edge_cyc, edge.edge_cyc);
    TEST_ASSERT_EQUAL_INT32(before.edge_count, edge.edge_count);
}

void test_speed_from_edges_is_exact_to_a_tick(void)
{
    /* 3 counts per period of which the last is passed at different times: 60 counts between two edges 400 000 cycles apart */
    turn_to(3U, 1, 500U);
    const hal_encoder_edge_t first = edge;
    for (uint32_t i = 2U; i <= 20U; i++) {
        turn_to(3U * i, 1, 100U * i);
    }
    turn_to(63U, 1, 500U);

    TEST_ASSERT_EQUAL_INT32(60, edge.edge_count - first.edge_count);
    /* every clock read of the fake takes 4 cycles: 20 periods of it */
    const uint32_t apart = (uint32_t)(edge.edge_cyc - first.edge_cyc);
    TEST_ASSERT_UINT32_WITHIN(1000U, 400000U, apart);
}

void test_index_gives_the_angle_at_which_it_was_passed(void)
{
    TEST_ASSERT_EQUAL_UINT16(0U, edge.index_passes);
    chip.qep_index = 3000U;
    chip.qep_flags = EQEP_INT_INDEX_EVNT_LATCH;

    turn_to(1500U, 1, 100U);

    TEST_ASSERT_EQUAL_UINT16(1U, edge.index_passes);
    TEST_ASSERT_FLOAT_WITHIN(1e-5f, 4.71238898f, edge.index_rad);
    TEST_ASSERT_EQUAL_HEX16(0, chip.qep_flags);
}

void test_index_stays_seen(void)
{
    chip.qep_index = 3000U;
    chip.qep_flags = EQEP_INT_INDEX_EVNT_LATCH;
    period();
    period();

    TEST_ASSERT_EQUAL_UINT16(1U, edge.index_passes);
}

/* 65535 turns in one direction take 3 minutes at 360 r/s: from there on 1, since 0 means that none was seen */
void test_index_is_counted_in_every_turn_and_never_back_to_none(void)
{
    for (uint32_t turn = 1U; turn <= 65540U; turn++) {
        chip.qep_index = 3000U + (turn & 1U);
        chip.qep_flags = EQEP_INT_INDEX_EVNT_LATCH;
        period();
        if ((turn == 2U) || (turn == 65535U) || (turn == 65536U)) {
            TEST_ASSERT_EQUAL_UINT16((turn > 65535U) ? 1U : (uint16_t)turn, edge.index_passes);
        }
    }
    TEST_ASSERT_FLOAT_WITHIN(1e-5f, 4.71238898f, edge.index_rad);
}

static void phase_error(void)
{
    chip.qep_flags = EQEP_INT_PHASE_ERROR;
    period();
}

void test_phase_errors_are_a_sensor_fault_when_four_come_within_100_ms(void)
{
    for (int k = 0; k < 3; k++) {
        phase_error();
        TEST_ASSERT_EQUAL_HEX16(0, chip.qep_flags);
        TEST_ASSERT_EQUAL(HAL_OK, sample_status);
    }
    phase_error();
    TEST_ASSERT_EQUAL(HAL_SENSOR_FAULT, sample_status);
    TEST_ASSERT_EQUAL(HAL_SENSOR_FAULT, edge_status);
    port_background();
    TEST_ASSERT_EQUAL_UINT32(4U, port_health()->phase_errors);

    period();

    TEST_ASSERT_EQUAL(HAL_OK, sample_status);
    TEST_ASSERT_EQUAL(HAL_OK, edge_status);
}

void test_phase_errors_far_apart_are_only_counted(void)
{
    for (int k = 0; k < 12; k++) { /* three in 100 ms, again and again */
        phase_error();
        TEST_ASSERT_EQUAL(HAL_OK, sample_status);
        for (int i = 0; i < 500; i++) {
            period();
        }
    }
    port_background();
    TEST_ASSERT_EQUAL_UINT32(12U, port_health()->phase_errors);
}

void test_encoder_pins_have_no_pull_ups_behind_the_level_shifter(void)
{
    TEST_ASSERT_FALSE(chip.pulled_up[20] || chip.pulled_up[21] || chip.pulled_up[99]);
}
