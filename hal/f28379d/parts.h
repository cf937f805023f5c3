/**
 * @file  hal/f28379d/parts.h
 * @brief What the files of the port share among themselves, in the order in which port_init calls it.
 */
#ifndef HAL_F28379D_PARTS_H
#define HAL_F28379D_PARTS_H

#include "hal/f28379d/board.h"
#include "hal/f28379d/port.h"
#include "hal/hal_inverter.h"

/* system.c */
bool port_system_init(void);

/* pins.c: everything but the six gates; gates last, when the trip is armed */
void port_pins_init(void);
void port_pins_connect_gates(void);

/* clock.c */
void port_clock_init(void);

/* pwm.c */
void  port_pwm_init(void);  /* counters stand */
void  port_pwm_start(void); /* all three at once */
float port_pwm_duty_max(uint16_t *phase); /* largest duty around the newest sample, and whose it is */
void  port_pwm_sampled(void);             /* from now on the duties set next count */

/* trip.c */
void port_trip_init(void);          /* ends with the one-shot trip set */
bool port_trip_is_set(void);        /* on all three modules */
bool port_trip_self_test(void);     /* each comparator trips each module; leaves the trip set */
void port_trip_release_if_armed(void);
void port_trip_note(hal_inverter_fault_t fault);
bool port_trip_bridge_is_off(void);

/* sampling.c, encoder.c */
void port_sampling_init(void);
void port_sampling_take(void);
void  port_encoder_init(void);
void  port_encoder_latch(void);
float port_encoder_angle_rad(void);
bool  port_encoder_failed(void);

/* gate_driver.c */
bool                 port_driver_init(void);
bool                 port_driver_is_well(hal_inverter_fault_t *reason); /* reads all status words: about 80 us */
void                 port_driver_clear(void);
void                 port_driver_poll(void);
hal_inverter_fault_t port_driver_reason(const port_driver_status_t *status);

/* link.c */
void port_link_init(void);
void port_link_pump(void); /* current interrupt: octets between the FIFOs and the main loop */

/* interrupts.c */
void     port_interrupts_init(void);

/* watchdog.c: proofs of life */
void port_watchdog_start(void);
void port_watchdog_service(void);
void port_watchdog_current_ran(void);
void port_watchdog_speed_wanted(void);
void port_watchdog_speed_ran(void);

#endif
