/* The watchdog is served by the main loop, and only when both interrupts have lived since it was served last. It has a window: a
 * program that has run away into the code that serves it does so too soon. */
#include "hal/f28379d/parts.h"
#include "hal/hal_clock.h"

port_life_t     port_life;
static uint16_t current_seen, speed_seen;
static uint32_t served_cyc;

void port_watchdog_start(void)
{
    port_life.current_runs = 0U;
    port_life.speed_wishes = 0U;
    port_life.speed_runs = 0U;
    current_seen = 0U;
    speed_seen = 0U;
    SysCtl_setWatchdogMode(SYSCTL_WD_MODE_RESET);
    SysCtl_setWatchdogPrescaler(BOARD_WATCHDOG_PRESCALE);
    SysCtl_setWatchdogWindowValue(0U);
    SysCtl_serviceWatchdog(); /* the window is open: nobody knows what the counter is at */
    SysCtl_setWatchdogWindowValue(BOARD_WATCHDOG_WINDOW);
    SysCtl_enableWatchdog();
    served_cyc = hal_clock_cyc();
}

/* Whoever serves it says so: the main loop, right after a long command of the flash, would else serve it inside the window. */
BOARD_RAM_CODE void port_watchdog_serve(void)
{
    served_cyc = hal_clock_cyc();
    SysCtl_serviceWatchdog();
}

void port_watchdog_service(void)
{
    const uint16_t current = port_life.current_runs;
    const uint16_t speed = port_life.speed_runs;
    const bool     speed_lives =
        (speed != speed_seen) || (port_life.speed_wishes == speed); /* with speed_inline nobody asks for it */
    if ((current != current_seen) && speed_lives && ((hal_clock_cyc() - served_cyc) >= BOARD_WATCHDOG_SERVE_CYC)) {
        current_seen = current;
        speed_seen = speed;
        port_watchdog_serve();
    }
}
