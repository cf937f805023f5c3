/* CPU timer 1 as the cycle counter. It counts down; the contract counts up. */
#include "hal/hal_clock.h"

#include "hal/f28379d/parts.h"

void port_clock_init(void)
{
    CPUTimer_stopTimer(CPUTIMER1_BASE);
    CPUTimer_setPeriod(CPUTIMER1_BASE, UINT32_C(0xFFFFFFFF));
    CPUTimer_setPreScaler(CPUTIMER1_BASE, 0U);
    CPUTimer_setEmulationMode(CPUTIMER1_BASE,
                              CPUTIMER_EMULATIONMODE_RUNFREE); /* the motor does not stop at a breakpoint either */
    CPUTimer_reloadTimerCounter(CPUTIMER1_BASE);
    CPUTimer_startTimer(CPUTIMER1_BASE);
}

BOARD_RAM_CODE uint32_t hal_clock_cyc(void) { return UINT32_C(0xFFFFFFFF) - CPUTimer_getTimerCount(CPUTIMER1_BASE); }

uint32_t hal_clock_hz(void) { return BOARD_SYSCLK_HZ; }

/* CPU line 14, CPU timer 2, whose timer stands: no PIE, no acknowledge, and a lower priority than the converter. */
BOARD_RAM_CODE void hal_clock_request_speed_isr(void)
{
    port_life.speed_wishes++;
    IFR |= INTERRUPT_CPU_INT14;
}
