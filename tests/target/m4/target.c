/* What a Cortex-M4F test program stands on: reset, FPU on, then newlib with semihosting. */
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

extern char __stack, __bss_start__, __bss_end__;
void        reset(void);
void        trap(void);
int         main(void);
void        initialise_monitor_handles(void);

#define CPACR (*(volatile uint32_t *)0xE000ED88U)

__attribute__((section(".vectors"), used)) static const void *const vectors[16] = {
    &__stack,           (const void *)reset, (const void *)trap, (const void *)trap,
    (const void *)trap, (const void *)trap,  (const void *)trap};

__attribute__((noreturn, used)) static void run(void)
{
    (void)memset(&__bss_start__, 0, (size_t)(&__bss_end__ - &__bss_start__));
    initialise_monitor_handles();
    exit(main());
}

void reset(void)
{
    CPACR |= 0xF00000U;
    __asm volatile("dsb\n isb" ::: "memory");
    run();
}

void trap(void) { _Exit(125); }
void _init(void);
void _fini(void);
void _init(void) {}
void _fini(void) {}
