/**
 * @file  firmware/app/combinations.h
 * @brief Which parameters do not go together: the rules of combinations.def.
 */
#ifndef FIRMWARE_APP_COMBINATIONS_H
#define FIRMWARE_APP_COMBINATIONS_H

#include "firmware/app/parameters.h"

typedef struct {
    const char *name, *why;   /**< `why` stands behind the two values; "" on the chip. */
    uint16_t    param, other; /**< Of the parameter table. */
} combination_info_t;

/** Row of the list; NULL beyond its end. */
const combination_info_t *combinations_info(uint16_t index);
/** The first rule that a set of parameters in their ranges breaks; beyond the end of the list when it breaks none. Main loop. */
uint16_t combinations_broken(const drive_params_t *p);

#endif
