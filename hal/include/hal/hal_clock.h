/**
 * @file  hal/include/hal/hal_clock.h
 * @brief The cycle counter and the request for the speed interrupt.
 */
#ifndef HAL_HAL_CLOCK_H
#define HAL_HAL_CLOCK_H

#include "hal/hal_types.h"

/** Free-running counter of CPU cycles; differences only. Any context. */
uint32_t hal_clock_cyc(void);
/** Cycles per second, 200e6 on the F28379D. */
uint32_t hal_clock_hz(void);
/** Make the speed interrupt pending; it runs when no current interrupt does. From the current interrupt. */
void hal_clock_request_speed_isr(void);

#endif
