/**
 * @file  tests/target/cycles/port.h
 * @brief The dearest call seen of each function of the port that the drive's interrupts call, in tenths of a cycle, without
 *        the call itself.
 */
#ifndef TESTS_TARGET_CYCLES_PORT_H
#define TESTS_TARGET_CYCLES_PORT_H

#include <stdint.h>

typedef struct {
    uint64_t sample_read, encoder_edge, set_duty, inverter_fault, clock_cyc, request_speed_isr;
} port_cost_t;

extern port_cost_t port_cost;

/** Run the port for 2000 periods; fills port_cost. @return 0, or not when it does not start. */
int port_cases(void (*note_case)(const char *name, uint64_t cost));

#endif
