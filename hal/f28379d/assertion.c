/* What driverlib calls in a debug build when an argument is wrong: the bridge off, and the place kept for the debugger. */
#include "hal/f28379d/parts.h"

port_assertion_t port_assertion;

void port_assertion_failed(const char *file, uint32_t line)
{
    hal_inverter_disarm();
    if (port_assertion.count == 0U) { /* the first one is the cause */
        port_assertion.file = file;
        port_assertion.line = line;
    }
    if (port_assertion.count < UINT16_MAX) {
        port_assertion.count++;
    }
}

/* The name is driverlib's (debug.h). Nothing goes on: no interrupt, and no watchdog that would wipe the place. */
void __error__(const char *filename, uint32_t line)
{
    DINT;
    port_assertion_failed(filename, line);
    SysCtl_disableWatchdog();
    for (;;) {
        NOP;
    }
}
