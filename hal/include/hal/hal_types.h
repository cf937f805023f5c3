/**
 * @file  hal/include/hal/hal_types.h
 * @brief What every HAL function may answer.
 *
 * The contract: plain C, no registers, no vendor types, no macros in front of prototypes. hal/f28379d implements it on
 * the chip, sim_host/board on the simulated machine, CMock in the tests. Signals are floats in SI units, angles
 * fractions of a turn.
 */
#ifndef HAL_HAL_TYPES_H
#define HAL_HAL_TYPES_H

#include <stdbool.h>
#include <stdint.h>

typedef enum {
    HAL_OK = 0,
    HAL_STALE,        /**< No new value since the last call. */
    HAL_SENSOR_FAULT, /**< The sensor says itself that it is wrong. */
    HAL_BUSY,         /**< Try again in a later pass of the main loop. */
    HAL_UNSUPPORTED,  /**< This board does not have it. */
    HAL_TRIPPED       /**< The value is good, and the bridge has a fault: hal_inverter_fault. */
} hal_status_t;

#endif
