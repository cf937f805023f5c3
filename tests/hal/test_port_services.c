/* Interrupt nesting, cycle counter, watchdog, link, storage. */
#include "tests/hal/support/started.h"

void setUp(void) { started(); }
void tearDown(void) {}

void test_current_interrupt_acknowledges_group_1_after_clearing_its_source(void)
{
    fake_forget_calls();

    period();

    const int cleared = CALLED("ADC_clearInterruptStatus", ADCA_BASE, ADC_INT_NUMBER1);
    const int acknowledged = CALLED("Interrupt_clearACKGroup", INTERRUPT_ACK_GROUP1);
    TEST_ASSERT_TRUE((cleared >= 0) && (acknowledged > cleared));
    TEST_ASSERT_FALSE(chip.pie_ack_group1);
    TEST_ASSERT_EQUAL(1, current_runs);
}

void test_speed_interrupt_runs_after_the_current_interrupt_that_asked_for_it(void)
{
    hal_clock_request_speed_isr();
    TEST_ASSERT_EQUAL_HEX16(INTERRUPT_CPU_INT14, IFR);

    period();

    TEST_ASSERT_EQUAL(1, current_runs);
    TEST_ASSERT_EQUAL(1, speed_runs);
    TEST_ASSERT_EQUAL_HEX16(0, IFR);
}

static int current_runs_inside_speed;

static void a_period_passes(void)
{
    TEST_ASSERT_EQUAL_HEX16(INTERRUPT_CPU_INT1, IER); /* nothing but the current interrupt is let in */
    const int before = current_runs;
    period();
    current_runs_inside_speed = current_runs - before;
}

void test_current_interrupt_preempts_the_speed_interrupt(void)
{
    current_runs_inside_speed = 0;
    IER |= 0x0100U; /* somebody's interrupt 9 */
    hal_clock_request_speed_isr();
    chip.on_eint = &a_period_passes;

    fake_interrupts();

    TEST_ASSERT_EQUAL(1, current_runs_inside_speed);
    TEST_ASSERT_EQUAL(1, speed_runs);
    TEST_ASSERT_EQUAL(2, chip.deepest);
    TEST_ASSERT_EQUAL_HEX16(0x2101, IER); /* as before */
}

void test_speed_interrupt_closes_interrupts_before_it_returns(void)
{
    fake_forget_calls();
    hal_clock_request_speed_isr();

    fake_interrupts();

    const int open = CALLED_AT_ALL("EINT");
    const int closed = CALLED_AT_ALL("DINT");
    TEST_ASSERT_TRUE((open >= 0) && (closed > open));
}

void test_speed_interrupt_does_not_interrupt_itself(void)
{
    hal_clock_request_speed_isr();
    chip.on_eint = &hal_clock_request_speed_isr; /* asked for again while it runs */

    fake_interrupts();

    TEST_ASSERT_EQUAL(2, speed_runs);
    TEST_ASSERT_EQUAL(1, chip.deepest);
}

void test_clock_counts_up_cpu_cycles_and_wraps(void)
{
    const uint32_t before = hal_clock_cyc();
    chip.cycles += 0xFFFFFFF0U;

    const uint32_t after = hal_clock_cyc();

    TEST_ASSERT_UINT32_WITHIN(16U, 0xFFFFFFF0U, after - before);
}

void test_watchdog_is_served_while_the_current_interrupt_lives(void)
{
    const uint32_t before = chip.watchdog_served;
    pass_ms(11);
    pass_ms(11);

    TEST_ASSERT_EQUAL_UINT32(before + 2U, chip.watchdog_served);
}

/* 20 steps of 512 x 4 cycles of a 10 MHz oscillator are 4.1 ms, which resets; its 52 ms end with 256 steps. */
void test_watchdog_is_served_every_10_ms_and_never_inside_its_window(void)
{
    TEST_ASSERT_EQUAL_UINT16(20U, chip.watchdog_window);
    const uint32_t before = chip.watchdog_served;
    for (int i = 0; i < 2000; i++) { /* 200 ms, one pass a period */
        period();
        port_background();
    }

    TEST_ASSERT_UINT32_WITHIN(1U, 20U, chip.watchdog_served - before);
    TEST_ASSERT_EQUAL(0, chip.watchdog_too_soon);
}

void test_watchdog_starves_without_current_interrupts(void)
{
    pass_ms(11);
    const uint32_t before = chip.watchdog_served;

    for (int i = 0; i < 5; i++) {
        chip.cycles += 4000000U;
        port_background();
    }

    TEST_ASSERT_EQUAL_UINT32(before, chip.watchdog_served);
}

void test_watchdog_starves_when_a_wanted_speed_interrupt_never_comes(void)
{
    IER = INTERRUPT_CPU_INT1;
    hal_clock_request_speed_isr();
    const uint32_t before = chip.watchdog_served;
    for (int i = 0; i < 10; i++) {
        pass_ms(11);
    }

    TEST_ASSERT_EQUAL_UINT32(before, chip.watchdog_served);
}

void test_link_is_625000_baud_8n1_on_the_probe_port(void)
{
    TEST_ASSERT_EQUAL(1, TIMES_CALLED("SCI_setConfig", SCIA_BASE, 50000000U, 625000U, 0x0007U));
}

void test_link_reads_what_has_arrived_and_no_more_than_asked(void)
{
    uint16_t octets[8];
    for (uint16_t i = 0; i < 5U; i++) {
        chip.rx[i] = (uint16_t)(0xA500U + i); /* rubbish above the octet */
    }
    chip.rx_count = 5U;
    TEST_ASSERT_EQUAL_UINT16(0U, hal_link_read(octets, 3U));
    port_link_pump();

    TEST_ASSERT_EQUAL_UINT16(3U, hal_link_read(octets, 3U));
    TEST_ASSERT_EQUAL_UINT16(2U, octets[2]);
    TEST_ASSERT_EQUAL_UINT16(2U, hal_link_read(octets, 8U));
    TEST_ASSERT_EQUAL_UINT16(0U, hal_link_read(octets, 8U));
}

void test_link_writes_until_the_fifo_is_full_and_the_rest_in_the_next_period(void)
{
    const uint16_t octets[4] = {0x1FFU, 2U, 3U, 4U};
    chip.tx_room = 3U;

    TEST_ASSERT_EQUAL_UINT16(4U, hal_link_write(octets, 4U));
    TEST_ASSERT_EQUAL_UINT16(0U, chip.tx_count);
    port_link_pump();
    TEST_ASSERT_EQUAL_UINT16(3U, chip.tx_count);
    TEST_ASSERT_EQUAL_HEX16(0xFF, chip.tx[0]);
    chip.tx_room = 16U;
    port_link_pump();
    TEST_ASSERT_EQUAL_UINT16(4U, chip.tx_count);
    TEST_ASSERT_EQUAL_HEX16(4, chip.tx[3]);
}

void test_link_moves_what_625000_baud_carry_and_no_more_than_8_octets_a_period(void)
{
    uint16_t octets[32];
    for (uint16_t i = 0; i < 20U; i++) {
        octets[i] = i;
        chip.rx[i] = i;
    }
    chip.rx_count = 15U;
    chip.tx_room = 16U;
    TEST_ASSERT_EQUAL_UINT16(20U, hal_link_write(octets, 20U));

    period();

    TEST_ASSERT_EQUAL_UINT16(8U, chip.tx_count); /* the line takes 6.25 */
    TEST_ASSERT_EQUAL_UINT16(8U, hal_link_read(octets, 32U));
}

void test_link_keeps_512_octets_and_counts_what_found_no_room(void)
{
    uint16_t octet = 0U;
    for (uint16_t i = 0; i < 513U; i++) {
        chip.rx[0] = i;
        chip.rx_count = 1U;
        port_link_pump();
    }
    TEST_ASSERT_EQUAL_UINT32(1U, hal_link_lost());
    for (uint16_t i = 0; i < 512U; i++) {
        TEST_ASSERT_EQUAL_UINT16(1U, hal_link_read(&octet, 1U));
        TEST_ASSERT_EQUAL_UINT16(i & 0xFFU, octet);
    }
    TEST_ASSERT_EQUAL_UINT16(0U, hal_link_read(&octet, 1U));
    for (uint16_t i = 0; i < 513U; i++) {
        TEST_ASSERT_EQUAL_UINT16((i < 512U) ? 1U : 0U, hal_link_write(&octet, 1U));
    }
}

void test_link_recovers_from_a_break(void)
{
    chip.rx_status = SCI_RXSTATUS_BREAK | SCI_RXSTATUS_ERROR;
    chip.rx_overflow = true;

    port_link_pump();

    TEST_ASSERT_EQUAL_HEX16(0, chip.rx_status);
    TEST_ASSERT_FALSE(chip.rx_overflow);
    TEST_ASSERT_EQUAL_UINT32(1U, hal_link_lost());
}

void test_storage_says_that_it_has_none(void)
{
    uint16_t word = 0U;
    TEST_ASSERT_EQUAL_UINT16(0U, hal_storage_pages());
    TEST_ASSERT_EQUAL_UINT16(0U, hal_storage_page_words());
    TEST_ASSERT_EQUAL(HAL_UNSUPPORTED, hal_storage_read(0U, 0U, &word, 1U));
    TEST_ASSERT_EQUAL(HAL_UNSUPPORTED, hal_storage_write(0U, 0U, &word, 1U));
    TEST_ASSERT_EQUAL(HAL_UNSUPPORTED, hal_storage_erase(0U));
}
