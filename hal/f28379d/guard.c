/* A current interrupt that does not come leaves the last voltage on the motor, and only the hardware can see it for sure: eCAP1
 * counts cycles in its PWM mode, every current interrupt restarts the count, and a pulse that it gets to in spite of that sets
 * the one-shot of all modules:
 *
 *   eCAP1 output -> ePWM X-BAR trip 5 -> digital compare B1 -> one-shot of ePWM1..3
 *
 * Active low with a compare value just below the period: the output is high in the last few microseconds only. It never stops:
 * when nobody feeds it the pulse comes again and again, and the output is never left high. */
#include "hal/f28379d/parts.h"

void port_guard_init(void)
{
    ECAP_stopCounter(BOARD_GUARD_BASE);
    ECAP_setEmulationMode(BOARD_GUARD_BASE, ECAP_EMULATION_FREE_RUN);
    ECAP_enableAPWMMode(BOARD_GUARD_BASE);
    ECAP_setAPWMPolarity(BOARD_GUARD_BASE, ECAP_APWM_ACTIVE_LOW);
    ECAP_setAPWMPeriod(BOARD_GUARD_BASE, BOARD_GUARD_CYC + BOARD_GUARD_PULSE_CYC);
    ECAP_setAPWMCompare(BOARD_GUARD_BASE, BOARD_GUARD_CYC);
    ECAP_setPhaseShiftCount(BOARD_GUARD_BASE, 0U); /* what a software sync loads */
    ECAP_enableLoadCounter(BOARD_GUARD_BASE);
    ECAP_startCounter(BOARD_GUARD_BASE);
    XBAR_setEPWMMuxConfig(XBAR_TRIP5, XBAR_EPWM_MUX00_ECAP1_OUT);
    XBAR_enableEPWMMux(XBAR_TRIP5, XBAR_MUX00);
}
