/**
 * @file  firmware/app/combinations.h
 * @brief Which parameters do not go together: the rules of combinations.def.
 */
#ifndef FIRMWARE_APP_COMBINATIONS_H
#define FIRMWARE_APP_COMBINATIONS_H

#include "firmware/app/doc_text.h"
#include "firmware/app/parameters.h"

typedef struct {
    DOC_MEMBER(const char *name;)
    DOC_MEMBER(const char *why;) /**< Stands behind the two values. */
    uint16_t param, other;       /**< Of the parameter table. */
} combination_info_t;

/** Row of the list; NULL beyond its end. */
const combination_info_t *combinations_info(uint16_t index);
/** The first rule that a set of parameters in their ranges breaks; beyond the end of the list when it breaks none. Main loop. */
uint16_t combinations_broken(const drive_params_t *p);

#endif
