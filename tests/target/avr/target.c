/* What an AVR test program stands on: characters out, an end, and what avr-libc lacks. */
#include <avr/interrupt.h>
#include <avr/io.h>
#include <avr/sleep.h>
#include <stdint.h>
#include <stdlib.h>

#include "target.h"

void target_putchar(int c) { GPIOR0 = (uint8_t)c; }

void exit(int status)
{
    GPIOR1 = (uint8_t)((status > 0) ? ((status < 100) ? status : 100) : ((status < 0) ? 101 : 0));
    cli();
    for (;;) {
        sleep_mode();
    }
}

void abort(void) { exit(102); }

/* avr-libc ends with lround; fixed-point tests ask for more than its 31 bits only where they saturate. */
long long llround(double x) { return (long long)((x < 0.0) ? (x - 0.5) : (x + 0.5)); }
