#include "tests/firmware/support/accesses.h"

#include <stdbool.h>
#include <stddef.h>

static struct {
    uint32_t count, wanted;
    void (*interrupt)(void);
    bool counting;
} run;

static void before_an_access(void)
{
    if (run.counting) {
        run.count++;
        if (run.count == run.wanted) {
            run.counting = false; /* the interrupt is not interrupted */
            run.interrupt();
        }
    }
}

uint32_t accesses_run(void (*code)(void), uint32_t number, void (*interrupt)(void))
{
    run.count = 0U;
    run.wanted = number;
    run.interrupt = interrupt;
    run.counting = true;
    code();
    run.counting = false;
    return run.count;
}

/* What the compiler calls; no header declares it. */
#pragma GCC diagnostic ignored "-Wmissing-prototypes"
#pragma GCC diagnostic ignored "-Wpedantic"
void __tsan_init(void) {}
void __tsan_func_entry(void *caller) { (void)caller; }
void __tsan_func_exit(void) {}

#define ACCESS(name)                                                                                                             \
    void __tsan_##name(void *at);                                                                                                \
    void __tsan_##name(void *at)                                                                                                 \
    {                                                                                                                            \
        (void)at;                                                                                                                \
        before_an_access();                                                                                                      \
    }
ACCESS(read1)
ACCESS(read2)
ACCESS(read4)
ACCESS(read8)
ACCESS(read16)
ACCESS(write1)
ACCESS(write2)
ACCESS(write4)
ACCESS(write8)
ACCESS(write16)
ACCESS(unaligned_read2)
ACCESS(unaligned_read4)
ACCESS(unaligned_read8)
ACCESS(unaligned_read16)
ACCESS(unaligned_write2)
ACCESS(unaligned_write4)
ACCESS(unaligned_write8)
ACCESS(unaligned_write16)

#define RANGE(name)                                                                                                              \
    void __tsan_##name(void *at, size_t size);                                                                                   \
    void __tsan_##name(void *at, size_t size)                                                                                    \
    {                                                                                                                            \
        (void)at;                                                                                                                \
        (void)size;                                                                                                              \
        before_an_access();                                                                                                      \
    }
RANGE(read_range)
RANGE(write_range)
