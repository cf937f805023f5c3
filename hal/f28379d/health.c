/* What goes wrong in the processor itself: memory errors, the clock, an interrupt vector; and locks on what must not change. */
#include "hal/f28379d/parts.h"

#define FLASH_ERRORS_MAX UINT16_C(0xFFFF) /* no interrupt: the count is read */

static port_health_t        health;
static hal_inverter_fault_t last_run;

/* Where the processor goes instead of to a handler whose address reads differently in the two copies of the vector table. It is
 * jumped to, not called: nothing returns. */
BOARD_RAM_CODE static void bad_vector(void)
{
    for (;;) {
        hal_inverter_disarm();
        NOP;
    }
}

static hal_inverter_fault_t meaning(uint16_t nmi)
{
    if ((nmi & SYSCTL_NMI_CLOCKFAIL) != 0U) {
        return HAL_INVERTER_CLOCK;
    }
    if ((nmi & (SYSCTL_NMI_RAMUNCERR | SYSCTL_NMI_FLUNCERR | SYSCTL_NMI_PIEVECTERR)) != 0U) {
        return HAL_INVERTER_MEMORY;
    }
    return HAL_INVERTER_FINE;
}

/* The shadow of the flags outlives the reset by the watchdog of the NMI; it says nothing after any other reset. */
void port_health_init(void)
{
    const port_health_t none = {0U, 0U, 0U, 0U, 0U};
    health = none;
    last_run = ((port_reset_cause() & SYSCTL_CAUSE_NMIWDRS) != 0U) ? meaning(SysCtl_getNMIShadowFlagStatus()) : HAL_INVERTER_FINE;
    EALLOW;
    HWREG(CPUSYS_BASE + SYSCTL_O_PIEVERRADDR) = (uint32_t)(uintptr_t)&bad_vector;
    EDIS;
    SysCtl_enableNMIGlobalInterrupt();
    Flash_setErrorThreshold(FLASH0ECC_BASE, FLASH_ERRORS_MAX);
}

hal_inverter_fault_t port_health_of_last_run(void) { return last_run; }

void port_health_check(void)
{
    health.ram_corrected = MemCfg_getCorrErrorCount();
    health.flash_corrected = Flash_getErrorCount(FLASH0ECC_BASE);
    health.phase_errors = port_encoder_errors;
    health.lost_periods = port_sampling_lost;
    health.failed_address = port_self_test_address();
}

const port_health_t *port_health(void) { return &health; }

/* Until the next reset. The comparators' levels stay open: a motor may need other ones. */
void port_lock_registers(void)
{
    XBAR_lockInput(XBAR_INPUT1);
    XBAR_lockEPWM();
    GPIO_lockPortConfig(GPIO_PORT_A, (UINT32_C(0x3F) << BOARD_PIN_PWM_FIRST) | (UINT32_C(1) << BOARD_PIN_NFAULT));
}
