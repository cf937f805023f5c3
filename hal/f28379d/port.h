/**
 * @file  hal/f28379d/port.h
 * @brief What the main of the board calls besides the contract of hal/include. No vendor types.
 *
 * Order: port_init, drive_init, port_start. Until port_start no interrupt runs and no watchdog bites; until
 * hal_inverter_arm the one-shot trip holds all six gate inputs low.
 */
#ifndef HAL_F28379D_PORT_H
#define HAL_F28379D_PORT_H

#include <stdbool.h>
#include <stdint.h>

#ifdef __TMS320C28XX__
#define PORT_ISR __interrupt
#define PORT_RAM_CODE __attribute__((ramfunc))
#else /* the same source on the host */
#define PORT_ISR
#define PORT_RAM_CODE
#endif

#define PORT_PWM_HZ 10000U

/** Limits that this board sets, for the parameters of the drive. */
typedef struct {
    float offset_limit_a, over_current_a, over_voltage_v, over_speed_rad_s, encoder_counts;
} port_limits_t;

/** Status words of the gate driver as read last, for a debugger and the bench. */
typedef struct {
    uint16_t warnings, vds, ic, vgs; /**< Registers 1 to 4, 11 bits each. */
    bool     answers;                /**< It answered, and all settings read back as they were written. */
} port_driver_status_t;

/** Events that nothing else reports, counted since the start, for a debugger and the bench. */
typedef struct {
    uint32_t ram_corrected, flash_corrected; /**< Memory errors of one bit. */
    uint32_t phase_errors;                   /**< Of the encoder interface. */
    uint32_t lost_periods;                   /**< PWM periods without a current interrupt. */
    uint32_t failed_address;                 /**< Where the self test of RAM or program has failed. */
} port_health_t;

typedef enum {
    PORT_OK = 0,
    PORT_NO_CLOCK,    /**< The PLL did not lock on the crystal. Nothing else has been set up: port_stop_with_code. */
    PORT_TRIP_UNARMED /**< The one-shot trip did not show in the flags: gates and driver stay off for good; the rest runs. */
} port_status_t;

/** Set up the whole chip with the bridge held off. Takes about 10 ms, and 100 ms more when the gate driver does not answer. */
port_status_t port_init(void);
/** Connect and enable the two interrupts, start the PWM clock and the watchdog. */
void port_start(void (*current_isr)(void), void (*speed_isr)(void));
/** One pass of the main loop: watchdog, status of the gate driver. */
void port_background(void);

/** First and last thing in the current interrupt: latch encoder and converter; acknowledge. */
void port_current_begin(void);
void port_current_end(void);
/** Around the body of the speed interrupt: only the current interrupt may interrupt it. */
void port_speed_begin(void);
void port_speed_end(void);

void                        port_limits(port_limits_t *out);
const port_driver_status_t *port_driver_status(void);
const port_health_t        *port_health(void);
/** Never returns: flashes the red diode @p status times, pauses, and again. Needs no clock but the internal one. */
void port_stop_with_code(port_status_t status);
/** Words of the stack that have been in use since the start, at the most; 0 where nobody counts them. */
uint16_t port_stack_used(void);
/** Why the last reset happened: bits of the reset cause register, as found by port_init. */
uint32_t port_reset_cause(void);

#endif
