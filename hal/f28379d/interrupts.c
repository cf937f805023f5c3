/* Two interrupts, nested by hand: the chip has no preemption by priority.
 *
 *   INT1   ADC A 1, 10 kHz: the current interrupt; nothing interrupts it
 *   INT14  requested by software, 1 kHz: the speed interrupt; opens itself to INT1 only
 *
 * Everything else, illegal instructions included, forces the trip and waits for the watchdog; so does the NMI, whose own watchdog
 * resets the processor after a third of a millisecond because nobody clears its flags. */
#include "hal/f28379d/parts.h"

#define VECTOR_FIRST 13U /* CPU timer 1 */
#define VECTOR_LAST 223U /* PIE 12.16 */
#define CODE_FAULT 3U    /* of the red diode; 1 and 2 are port_status_t */

PORT_ISR void port_unexpected_isr(void);

BOARD_RAM_CODE PORT_ISR void port_unexpected_isr(void)
{
    for (;;) {
        hal_inverter_disarm();
        NOP;
    }
}

void port_interrupts_init(void)
{
    Interrupt_initModule();
    Interrupt_initVectorTable();
    for (uint16_t vector = VECTOR_FIRST; vector <= VECTOR_LAST; vector++) {
        Interrupt_register((uint32_t)vector << 16, &port_unexpected_isr);
    }
}

void port_start(void (*current_isr)(void), void (*speed_isr)(void))
{
    port_lock_registers();
    Interrupt_register(INT_ADCA1, current_isr);
    Interrupt_register(INT_TIMER2, speed_isr);
    Interrupt_enable(INT_ADCA1);
    Interrupt_enable(INT_TIMER2);
    port_pwm_start();
    port_watchdog_start();
    EINT;
    ERTM;
}

BOARD_RAM_CODE void port_current_begin(void)
{
    port_encoder_latch(); /* first: the angle belongs to the sample of a microsecond ago */
    port_guard_feed();
    port_trip_release_if_armed();
    GPIO_writePin(BOARD_PIN_PROBE, 1U);
    port_sampling_take();
    port_pwm_sampled();
}

BOARD_RAM_CODE void port_current_end(void)
{
    port_link_pump();
    port_life.current_runs++;
    GPIO_writePin(BOARD_PIN_PROBE, 0U);
    Interrupt_clearACKGroup(INTERRUPT_ACK_GROUP1);
}

/* Entering has saved IER, the return restores it. INT14 bypasses the PIE: nothing to acknowledge. */
BOARD_RAM_CODE void port_speed_begin(void)
{
    IER &= INTERRUPT_CPU_INT1;
    EINT;
}

BOARD_RAM_CODE void port_speed_end(void)
{
    DINT; /* an interrupt that enabled interrupts disables them before it returns (errata) */
    port_life.speed_runs++;
}

static void note_slow_faults(void)
{
    port_driver_ask_why();
    if (port_trip_armed && port_sampling_sum_is_off()) {
        hal_inverter_disarm();
        port_trip_note(HAL_INVERTER_CURRENT_SUM);
    }
}

void port_background(void)
{
    port_watchdog_service();
    if (!port_trip_is_given_up()) {
        port_driver_poll();
    }
    note_slow_faults();
    port_health_check();
    port_led_show(port_trip_is_given_up() ? (uint16_t)PORT_TRIP_UNARMED
                                          : ((port_trip_latched != HAL_INVERTER_FINE) ? CODE_FAULT : (uint16_t)PORT_OK),
                  port_trip_armed);
    port_stack_check();
    port_self_test_slice();
}
