/**
 * @file  tests/hal/support/virtual_chip.h
 * @brief The program of the board on the fake chip, with the simulated motor on its pins.
 *
 *     plant -> voltages at the converter pins, edges at the eQEP -> port, drive -> compare registers, one-shot -> plant
 *
 * Nothing passes by the port: the plant sees the registers of the ePWMs and the state of the one-shots only.
 */
#ifndef TESTS_HAL_SUPPORT_VIRTUAL_CHIP_H
#define TESTS_HAL_SUPPORT_VIRTUAL_CHIP_H

#include "fake_chip.h"
#include "firmware/app/drive.h"
#include "hal/f28379d/port.h"
#include "sim_host/plant/plant.h"
#include "unity.h"

/* firmware/main_f28379d.c */
int           board_main(void);
port_status_t main_start(void);
void          main_pass(void);
drive_t      *main_drive(void);

extern sim_plant_t plant;
extern double      amplifier_offset_v[3]; /* zero errors of phases A, B, C */
extern double      amplifier_gain[3];     /* of their nominal gain */
extern double      short_circuit_a;       /* additional current through the shunt of phase A */
extern bool        encoder_reversed;      /* tracks swapped */
extern uint32_t    periods_with_gates_on;
extern uint32_t    longest_hunger; /* periods between two services of the watchdog, at most */

/** A healthy chip and a motor at rest at @p angle_rad; nothing runs yet. */
void world_begin(double angle_rad);
/** One PWM period of chip and motor, without the main loop. */
void world_period(void);
/** Periods with one pass of the main loop each. */
void world_run(int periods);
/** Take back the cycles by which the program is late, so that the next period begins in time. */
void world_make_up_time(void);

#endif
