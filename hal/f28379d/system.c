/* From reset to 200 MHz, and the order in which the parts start. */
#include "hal/f28379d/parts.h"
#include "hal/hal_reset.h"

#ifdef _FLASH
#include <string.h>

/* Addresses from the linker file; the size is the address of its symbol. */
extern uint16_t RamfuncsLoadStart, RamfuncsLoadSize, RamfuncsRunStart;
extern uint16_t SwitchLoadStart, SwitchLoadSize, SwitchRunStart;
#endif

#define MODULE_COUNT(list) (sizeof(list) / sizeof((list)[0]))

static uint32_t reset_cause;

static void enable_modules(void)
{
    static const SysCtl_PeripheralPCLOCKCR MODULE[] = {
        SYSCTL_PERIPH_CLK_TIMER1, SYSCTL_PERIPH_CLK_TIMER2, SYSCTL_PERIPH_CLK_EPWM1, SYSCTL_PERIPH_CLK_EPWM2,
        SYSCTL_PERIPH_CLK_EPWM3,  SYSCTL_PERIPH_CLK_EQEP1,  SYSCTL_PERIPH_CLK_SCIA,  SYSCTL_PERIPH_CLK_SPIA,
        SYSCTL_PERIPH_CLK_ADCA,   SYSCTL_PERIPH_CLK_ADCB,   SYSCTL_PERIPH_CLK_ADCC,  SYSCTL_PERIPH_CLK_CMPSS1,
        SYSCTL_PERIPH_CLK_CMPSS3, SYSCTL_PERIPH_CLK_CMPSS6, SYSCTL_PERIPH_CLK_ECAP1};
    for (uint16_t i = 0U; i < (uint16_t)MODULE_COUNT(MODULE); i++) {
        SysCtl_enablePeripheral(MODULE[i]); /* without its clock a module ignores writes and reads as zero */
    }
    SysCtl_delay(BOARD_US(1U));
}

/* Flash code itself. The copies come before everything else of the program, so that no jump table is read before it is
 * there: until here only the C start-up has run. The watchdog is off since codestart.asm. */
bool port_system_init(void)
{
#ifdef _FLASH
    (void)memcpy(&SwitchRunStart, &SwitchLoadStart, (size_t)&SwitchLoadSize);
    (void)memcpy(&RamfuncsRunStart, &RamfuncsLoadStart, (size_t)&RamfuncsLoadSize);
#endif
    SysCtl_disableWatchdog();
    reset_cause = SysCtl_getResetCause();
    SysCtl_clearResetCause(reset_cause);
#ifdef _FLASH
    Flash_initModule(FLASH0CTRL_BASE, FLASH0ECC_BASE, BOARD_FLASH_WAITS); /* runs from RAM */
#endif
    if (!SysCtl_setClock(BOARD_CLOCK_CONFIG)) {
        return false;
    }
    SysCtl_setLowSpeedClock(SYSCTL_LSPCLK_PRESCALE_4);
    SysCtl_setEPWMClockDivider(SYSCTL_EPWMCLK_DIV_2); /* 100 MHz, the most an ePWM takes */
    enable_modules();
#ifndef _FLASH
    SysCtl_deviceCal(); /* a debugger's reset leaves out the boot ROM, which loads the trims of converters and oscillators */
#endif
    return true;
}

uint32_t port_reset_cause(void) { return reset_cause; }

/* The watchdog pulls the reset pin, too, and a drive that may have failed must not appear as one that was just switched on. */
hal_reset_t hal_reset_cause(void)
{
    if ((reset_cause & (SYSCTL_CAUSE_WDRS | SYSCTL_CAUSE_NMIWDRS)) != 0U) {
        return HAL_RESET_WATCHDOG;
    }
    if ((reset_cause & SYSCTL_CAUSE_POR) != 0U) {
        return HAL_RESET_POWER_UP;
    }
    if ((reset_cause & SYSCTL_CAUSE_XRS) != 0U) {
        return HAL_RESET_PIN;
    }
    return (reset_cause != 0U) ? HAL_RESET_OTHER : HAL_RESET_UNKNOWN;
}

port_status_t port_init(void)
{
    port_stack_start();
    if (!port_system_init()) {
        return PORT_NO_CLOCK;
    }
    port_self_test_start();
    port_interrupts_init();
    port_pins_init(); /* EN_GATE low; gates are inputs */
    port_clock_init();
    port_health_init();
    port_led_init();

    SysCtl_disablePeripheral(SYSCTL_PERIPH_CLK_TBCLKSYNC);
    port_pwm_init();
    port_trip_init();
    const bool holds = port_trip_is_set(); /* before anything else can have set it */
    port_guard_init();
    port_sampling_init();
    port_encoder_init();
    port_link_init();
    if (!holds) {
        port_trip_give_up(); /* the gates stay inputs, EN_GATE low; the link reports why */
        hal_inverter_clear_fault();
        return PORT_TRIP_UNARMED;
    }
    port_pins_connect_gates();
    (void)port_driver_init(); /* the amplifiers live from here on */
    (void)port_trip_self_test();
    hal_inverter_clear_fault(); /* notes which part has failed */
    port_trip_note(port_health_of_last_run());
    return PORT_OK;
}

void port_limits(port_limits_t *out)
{
    out->offset_limit_a = BOARD_OFFSET_LIMIT_A;
    out->over_current_a = BOARD_OVER_CURRENT_A;
    out->over_voltage_v = BOARD_OVER_VOLTAGE_V;
    out->over_speed_rad_s = BOARD_OVER_SPEED_RAD_S;
    out->encoder_counts = (float)BOARD_ENCODER_COUNTS;
}
