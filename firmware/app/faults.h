/**
 * @file  firmware/app/faults.h
 * @brief The list of faults, made from faults.def. The first fault wins; every other one is a consequence or can wait.
 */
#ifndef FIRMWARE_APP_FAULTS_H
#define FIRMWARE_APP_FAULTS_H

#include <stdint.h>

#include "firmware/app/doc_text.h"

typedef enum {
    FAULT_none = 0,
#define FAULT(name, cause, check) FAULT_##name,
#include "firmware/app/faults.def"
#undef FAULT
    FAULT_COUNT
} drive_fault_t;

typedef struct {
    const char *name;
    DOC_MEMBER(const char *cause;)
    DOC_MEMBER(const char *check;)
} fault_info_t;

/** Row of the list; NULL beyond its end. */
const fault_info_t *faults_info(uint16_t index);

#endif
