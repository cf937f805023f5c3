/**
 * @file  hal/include/hal/hal_encoder.h
 * @brief The last encoder edge and when it was, for speed by the M/T method.
 */
#ifndef HAL_HAL_ENCODER_H
#define HAL_HAL_ENCODER_H

#include "hal/hal_types.h"

typedef struct {
    int32_t  edge_count;   /**< Position of the newest edge, counts; wraps at 2^32. Independent of the direction of the motion. */
    uint32_t edge_cyc;     /**< When it was passed, on hal_clock_cyc. */
    uint16_t index_passes; /**< How often the index pulse has been passed since start-up; 0: not yet; after 65535 comes 1. */
    float
        index_rad; /**< Count at which it was passed last, as shaft angle, rad, [0, 2 pi): another one after counts were lost. */
} hal_encoder_edge_t;

/**
 * Newest edge, as of the newest current interrupt. From either interrupt, at most 60 cycles; it is one edge, whole, even when
 * the current interrupt comes in between.
 * @return HAL_OK, HAL_SENSOR_FAULT (phase errors: both tracks changed at once, more often than a disturbance makes them).
 */
hal_status_t hal_encoder_edge(hal_encoder_edge_t *out);

#endif
