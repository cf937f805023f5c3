/* The watchdog is served by the main loop, and only when both interrupts have lived since it was served last. */
#include "hal/f28379d/parts.h"

static volatile uint16_t current_runs, speed_wishes, speed_runs;
static uint16_t          current_seen, speed_seen;

void port_watchdog_start(void)
{
    current_runs = 0U;
    speed_wishes = 0U;
    speed_runs = 0U;
    current_seen = 0U;
    speed_seen = 0U;
    SysCtl_setWatchdogMode(SYSCTL_WD_MODE_RESET);
    SysCtl_setWatchdogPrescaler(BOARD_WATCHDOG_PRESCALE);
    SysCtl_serviceWatchdog();
    SysCtl_enableWatchdog();
}

BOARD_RAM_CODE void port_watchdog_current_ran(void) { current_runs++; }
BOARD_RAM_CODE void port_watchdog_speed_wanted(void) { speed_wishes++; }
BOARD_RAM_CODE void port_watchdog_speed_ran(void) { speed_runs++; }

void port_watchdog_service(void)
{
    const uint16_t current = current_runs;
    const uint16_t speed = speed_runs;
    const bool     speed_lives = (speed != speed_seen) || (speed_wishes == speed); /* with speed_inline nobody asks for it */
    if ((current != current_seen) && speed_lives) {
        current_seen = current;
        speed_seen = speed;
        SysCtl_serviceWatchdog();
    }
}
