/* The watchdog is served by the main loop, and only when both interrupts have lived since it was served last. */
#include "hal/f28379d/parts.h"

port_life_t     port_life;
static uint16_t current_seen, speed_seen;

void port_watchdog_start(void)
{
    port_life.current_runs = 0U;
    port_life.speed_wishes = 0U;
    port_life.speed_runs = 0U;
    current_seen = 0U;
    speed_seen = 0U;
    SysCtl_setWatchdogMode(SYSCTL_WD_MODE_RESET);
    SysCtl_setWatchdogPrescaler(BOARD_WATCHDOG_PRESCALE);
    SysCtl_serviceWatchdog();
    SysCtl_enableWatchdog();
}

void port_watchdog_service(void)
{
    const uint16_t current = port_life.current_runs;
    const uint16_t speed = port_life.speed_runs;
    const bool     speed_lives =
        (speed != speed_seen) || (port_life.speed_wishes == speed); /* with speed_inline nobody asks for it */
    if ((current != current_seen) && speed_lives) {
        current_seen = current;
        speed_seen = speed;
        SysCtl_serviceWatchdog();
    }
}
