/**
 * @file  hal/include/hal/hal_inverter.h
 * @brief The bridge: duties, arming, and the hardware's own faults.
 */
#ifndef HAL_HAL_INVERTER_H
#define HAL_HAL_INVERTER_H

#include "hal/hal_types.h"

typedef struct {
    float a, b, c; /**< High-side on-time per period, each in [0, 1]. */
} hal_duty_t;

/** What the hardware itself has found, besides what the firmware checks. */
typedef enum {
    HAL_INVERTER_FINE = 0,
    HAL_INVERTER_OVER_CURRENT, /**< Comparator tripped the PWM, or the gate driver found a switch in short circuit. */
    HAL_INVERTER_DRIVER_FAULT, /**< Gate driver pulls its fault line. */
    HAL_INVERTER_OVER_TEMPERATURE,
    HAL_INVERTER_DRIVER_SUPPLY, /**< Gate driver warns of its supply: too low or too high. */
    HAL_INVERTER_DRIVER_LINK,   /**< Gate driver does not answer, or does not hold the settings that were written. */
    HAL_INVERTER_TRIP_PATH,     /**< What has to switch the bridge off without the processor did not do so in the self test. */
    HAL_INVERTER_CURRENT_SUM,   /**< The phase currents do not add up to zero: a sensor reads wrong. */
    HAL_INVERTER_LATE,          /**< No current interrupt for two PWM periods. */
    HAL_INVERTER_HALTED,        /**< A debugger halted the processor. */
    HAL_INVERTER_CLOCK,         /**< The clock of the processor failed. */
    HAL_INVERTER_MEMORY,        /**< A memory error that could not be corrected, or a bad interrupt vector. */
    HAL_INVERTER_STO, /**< A channel of the input for safe torque off asks for it, and its hardware has taken the gates away. */
    /* The processor's tests of itself, at the start and slice by slice in the main loop. They stand until the next reset. */
    HAL_INVERTER_RAM_TEST,       /**< A word of RAM does not keep what is written, or changes with another one. */
    HAL_INVERTER_PROGRAM_TEST,   /**< The program is not the one that was linked. */
    HAL_INVERTER_PROCESSOR_TEST, /**< An operation of the processor gives a wrong result. */
    HAL_INVERTER_FAULTS
} hal_inverter_fault_t;

/** Takes effect at the start of the next PWM period. Values outside [0, 1] are cut. From the current interrupt. */
hal_status_t hal_inverter_set_duty(const hal_duty_t *duty);
/** Let the gates follow the duties, from the next period on. From the main loop. @return HAL_SENSOR_FAULT while a hardware fault stands. */
hal_status_t hal_inverter_arm(void);
/** All gates off within one PWM period. Cannot fail; any context; idempotent. */
void hal_inverter_disarm(void);
/** First hardware fault since the last hal_inverter_clear_fault. Any context. */
hal_inverter_fault_t hal_inverter_fault(void);
/** Forget the hardware fault and set the power stage up again; the fault comes back if its cause stands. From the main loop, disarmed;
 *  up to 10 ms. */
void hal_inverter_clear_fault(void);

#define HAL_STO_CHANNELS 2U
#define HAL_STO_BOTH 3U
/** Channels of the input for safe torque off that ask for it: bit 0 the first, bit 1 the second. Each of them alone takes the gates
 *  away by hardware that no program can overrule; this is its diagnosis. From the main loop, in every pass; does not wait. A board
 *  without this input has none that asks: 0. */
uint16_t hal_sto(void);

/** Mean on-time of the switch of a brake resistor across the dc link, [0, 1]; what is outside is cut, NaN is off. It holds for 20 ms: then the
 *  board switches off unless there was another call, so that no program that has stopped burns the resistor. Independent of the
 *  bridge. From the speed interrupt; at most 50 cycles. Does nothing on a board without (hal_limits: has_chopper). */
void hal_brake_duty(float duty);

#endif
