/**
 * @file  hal/include/hal/hal_reset.h
 * @brief Why the processor last started.
 */
#ifndef HAL_HAL_RESET_H
#define HAL_HAL_RESET_H

#include "hal/hal_types.h"

typedef enum {
    HAL_RESET_UNKNOWN = 0,
    HAL_RESET_POWER_UP,
    HAL_RESET_PIN,      /**< From outside: reset button, supervisor, debugger. */
    HAL_RESET_WATCHDOG, /**< The program did not go on as it should. */
    HAL_RESET_OTHER
} hal_reset_t;

/** Cause of the last reset; constant while the program runs. Any context. */
hal_reset_t hal_reset_cause(void);

#endif
