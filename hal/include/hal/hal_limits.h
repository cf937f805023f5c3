/**
 * @file  hal/include/hal/hal_limits.h
 * @brief What the board bears and what it can see: no parameter of the drive goes beyond.
 */
#ifndef HAL_HAL_LIMITS_H
#define HAL_HAL_LIMITS_H

#include "hal/hal_types.h"

typedef struct {
    float current_a;      /**< Largest phase current: over_current_a, the current limits and the alignment stay within. */
    float dc_link_v;      /**< Largest dc-link voltage: over_voltage_v and voltage_limit_v stay within. */
    float speed_rad_s;    /**< Fastest shaft that the encoder's counter follows, mechanical: over_speed_rad_s stays within. */
    float offset_a;       /**< Zero error of a current sensor that is still a working sensor: offset_limit_a stays within. */
    float encoder_counts; /**< The one value of encoder_counts that this board is built for; 0: any. */
    bool  has_chopper;    /**< There is a switch for a brake resistor: hal_brake_duty. */
} hal_limits_t;

/** Maxima of this board, each > 0; they never change. From the main loop. */
void hal_limits(hal_limits_t *out);

#endif
