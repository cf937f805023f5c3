#include "tests/firmware/support/accesses.h"

#include <stdbool.h>
#include <stddef.h>

static struct {
    uint32_t count, wanted;
    void (*interrupt)(void);
    bool counting;
    void (*written)(const void *at, size_t size);
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

void accesses_watch(void (*code)(void), void (*written)(const void *at, size_t size))
{
    run.written = written;
    code();
    run.written = NULL;
}

static void before_a_write(const void *at, size_t size)
{
    before_an_access();
    if (run.written != NULL) {
        run.written(at, size);
    }
}

/* What the compiler calls; no header declares it. */
#pragma GCC diagnostic ignored "-Wmissing-prototypes"
#pragma GCC diagnostic ignored "-Wpedantic"
void __tsan_init(void) {}
void __tsan_func_entry(void *caller) { (void)caller; }
void __tsan_func_exit(void) {}

#define ACCESS(bytes)                                                                                                            \
    void __tsan_read##bytes(void *at);                                                                                           \
    void __tsan_read##bytes(void *at)                                                                                            \
    {                                                                                                                            \
        (void)at;                                                                                                                \
        before_an_access();                                                                                                      \
    }                                                                                                                            \
    void __tsan_write##bytes(void *at);                                                                                          \
    void __tsan_write##bytes(void *at) { before_a_write(at, (size_t)(bytes)); }
ACCESS(1)
ACCESS(2)
ACCESS(4)
ACCESS(8)
ACCESS(16)

#define UNALIGNED(bytes)                                                                                                         \
    void __tsan_unaligned_read##bytes(void *at);                                                                                 \
    void __tsan_unaligned_read##bytes(void *at)                                                                                  \
    {                                                                                                                            \
        (void)at;                                                                                                                \
        before_an_access();                                                                                                      \
    }                                                                                                                            \
    void __tsan_unaligned_write##bytes(void *at);                                                                                \
    void __tsan_unaligned_write##bytes(void *at) { before_a_write(at, (size_t)(bytes)); }
UNALIGNED(2)
UNALIGNED(4)
UNALIGNED(8)
UNALIGNED(16)

void __tsan_read_range(void *at, size_t size);
void __tsan_read_range(void *at, size_t size)
{
    (void)at;
    (void)size;
    before_an_access();
}
void __tsan_write_range(void *at, size_t size);
void __tsan_write_range(void *at, size_t size) { before_a_write(at, size); }
