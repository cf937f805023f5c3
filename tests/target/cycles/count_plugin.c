/* QEMU plugin: how many instructions of the program under test run between two marks of driver.c.
 *
 *   -plugin count_plugin.so,low=ADDRESS,high=ADDRESS,mark=ADDRESS,out=FILE
 *
 * The driver's own code lies at [low, high) and is not counted. It marks by a store into an array at `mark`: element 0 begins
 * a call, element k ends one and adds it to row k. FILE gets a line a row: row, calls, sum, largest. Instructions that an IT
 * block skips are counted: they take their cycle on the core, too.
 *
 * Packaged QEMU supports plugins but ships no header: what is used of its interface is declared here. */
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#ifndef PLUGIN_INTERFACE
#define PLUGIN_INTERFACE 1
#endif
#define EXPORT __attribute__((visibility("default")))
#define ROWS 256

typedef uint64_t plugin_id_t;
struct qemu_plugin_tb;
struct qemu_plugin_insn;
enum { NO_REGISTERS = 0, WRITES = 2 };

void   qemu_plugin_register_vcpu_tb_trans_cb(plugin_id_t id, void (*translated)(plugin_id_t, struct qemu_plugin_tb *));
void   qemu_plugin_register_vcpu_tb_exec_cb(struct qemu_plugin_tb *tb, void (*run)(unsigned, void *), int flags, void *user);
void   qemu_plugin_register_vcpu_mem_cb(struct qemu_plugin_insn *insn, void (*access)(unsigned, uint32_t, uint64_t, void *),
                                        int flags, int kind, void *user);
void   qemu_plugin_register_atexit_cb(plugin_id_t id, void (*at_exit)(plugin_id_t, void *), void *user);
size_t qemu_plugin_tb_n_insns(const struct qemu_plugin_tb *tb);
struct qemu_plugin_insn *qemu_plugin_tb_get_insn(const struct qemu_plugin_tb *tb, size_t index);
uint64_t                 qemu_plugin_insn_vaddr(const struct qemu_plugin_insn *insn);

EXPORT int qemu_plugin_version = PLUGIN_INTERFACE;
EXPORT int qemu_plugin_install(plugin_id_t id, const void *machine, int argc, char **argv);

static uint64_t    low, high, mark, executed, begun;
static const char *out;
static struct {
    uint64_t calls, sum, max;
} row[ROWS];

static void run(unsigned cpu, void *instructions)
{
    (void)cpu;
    executed += (uintptr_t)instructions;
}

static void store(unsigned cpu, uint32_t info, uint64_t address, void *user)
{
    (void)cpu;
    (void)info;
    (void)user;
    const uint64_t k = address - mark;
    if (k == 0U) {
        begun = executed;
    } else if (k < ROWS) {
        const uint64_t took = executed - begun;
        row[k].calls++;
        row[k].sum += took;
        row[k].max = (took > row[k].max) ? took : row[k].max;
    }
}

static void translated(plugin_id_t id, struct qemu_plugin_tb *tb)
{
    (void)id;
    const size_t   count = qemu_plugin_tb_n_insns(tb);
    const uint64_t start = qemu_plugin_insn_vaddr(qemu_plugin_tb_get_insn(tb, 0U));
    if ((start < low) || (start >= high)) {
        qemu_plugin_register_vcpu_tb_exec_cb(tb, run, NO_REGISTERS, (void *)(uintptr_t)count);
        return;
    }
    for (size_t k = 0U; k < count; k++) {
        qemu_plugin_register_vcpu_mem_cb(qemu_plugin_tb_get_insn(tb, k), store, NO_REGISTERS, WRITES, NULL);
    }
}

static void at_exit(plugin_id_t id, void *user)
{
    (void)id;
    (void)user;
    FILE *const file = fopen(out, "w");
    if (file == NULL) {
        return;
    }
    for (unsigned k = 1U; k < ROWS; k++) {
        if (row[k].calls > 0U) {
            (void)fprintf(file, "%u\t%llu\t%llu\t%llu\n", k, (unsigned long long)row[k].calls, (unsigned long long)row[k].sum,
                          (unsigned long long)row[k].max);
        }
    }
    (void)fclose(file);
}

static const char *value_of(const char *argument, const char *name)
{
    const size_t n = strlen(name);
    return ((strncmp(argument, name, n) == 0) && (argument[n] == '=')) ? &argument[n + 1U] : NULL;
}

int qemu_plugin_install(plugin_id_t id, const void *machine, int argc, char **argv)
{
    (void)machine;
    for (int k = 0; k < argc; k++) {
        const char *value;
        if ((value = value_of(argv[k], "low")) != NULL) {
            low = strtoull(value, NULL, 0);
        } else if ((value = value_of(argv[k], "high")) != NULL) {
            high = strtoull(value, NULL, 0);
        } else if ((value = value_of(argv[k], "mark")) != NULL) {
            mark = strtoull(value, NULL, 0);
        } else if ((value = value_of(argv[k], "out")) != NULL) {
            out = strdup(value);
        }
    }
    if ((out == NULL) || (high == 0U) || (mark == 0U)) {
        return -1;
    }
    qemu_plugin_register_vcpu_tb_trans_cb(id, translated);
    qemu_plugin_register_atexit_cb(id, at_exit, NULL);
    return 0;
}
