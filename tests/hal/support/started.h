/**
 * @file  tests/hal/support/started.h
 * @brief The port, started on a healthy chip, with a current interrupt that only takes its sample.
 */
#ifndef TESTS_HAL_SUPPORT_STARTED_H
#define TESTS_HAL_SUPPORT_STARTED_H

#include "fake_chip.h"
#include "hal/f28379d/board.h"
#include "hal/f28379d/parts.h"
#include "hal/f28379d/port.h"
#include "hal/hal_clock.h"
#include "hal/hal_encoder.h"
#include "hal/hal_inverter.h"
#include "hal/hal_link.h"
#include "hal/hal_sample.h"
#include "hal/hal_storage.h"
#include "unity.h"

extern hal_sample_t       sample; /* of the last current interrupt */
extern hal_status_t       sample_status;
extern hal_encoder_edge_t edge;
extern hal_status_t       edge_status;
extern int                current_runs, speed_runs;
extern hal_duty_t         duty; /* set in every current interrupt */

/** Power on, port_init, port_start. */
void started(void);
/** One PWM period: 20000 cycles later the counters are at zero. */
void period(void);
/** So many milliseconds of PWM periods, and then one pass of the main loop. */
void pass_ms(int ms);
/** Arm, and let the period begin that carries it out. */
void arm(void);
bool all_gates_follow(void);
bool all_gates_low(void);
/** Pin voltages of the shunt amplifiers for these currents. */
void phase_currents(double a, double b, double c);

#endif
