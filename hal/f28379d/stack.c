/* How deep the stack has been: its words are filled with a pattern at the start, and a pass of the main loop checks some of
 * them for what is left of it. The stack of the C28x grows upwards. */
#include "hal/f28379d/parts.h"

#define PATTERN 0x5AC3U
#define PER_PASS 32U
#define IN_USE_WORDS 64U /* above a local variable of port_stack_start: the frame that fills must not be filled */

static uint16_t *first;
static uint16_t  words;    /* of the stack */
static uint16_t  used;     /* words below the highest that was written */
static uint16_t  checking; /* the next word to check, counted from the first */

void port_stack_watch(uint16_t *from, uint16_t count, uint16_t in_use)
{
    first = from;
    words = count;
    used = (in_use < count) ? in_use : count;
    checking = count;
    for (uint16_t i = used; i < count; i++) {
        from[i] = PATTERN;
    }
}

void port_stack_check(void)
{
    for (uint16_t n = 0U; (n < PER_PASS) && (checking > used); n++) {
        checking--;
        if (first[checking] != PATTERN) {
            used = (uint16_t)(checking + 1U); /* everything below counts as used */
        }
    }
    if (checking <= used) {
        checking = words;
    }
}

uint16_t port_stack_used(void) { return used; }

#ifdef __TMS320C28XX__
extern uint16_t StackRunStart, StackRunSize; /* linker file; the size is the address of its symbol */

void port_stack_start(void)
{
    volatile uint16_t here = 0U;
    const uint16_t    depth = (uint16_t)((uint32_t)&here - (uint32_t)&StackRunStart);
    port_stack_watch(&StackRunStart, (uint16_t)(uint32_t)&StackRunSize, (uint16_t)(depth + IN_USE_WORDS));
}
#else
void port_stack_start(void) { /* the stack of the host is not ours: tests watch one of their own */ }
#endif
