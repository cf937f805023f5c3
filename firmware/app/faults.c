#include "firmware/app/faults.h"

#include <stddef.h>

static const fault_info_t TABLE[FAULT_COUNT] = {
    {"none", DOC_TEXT("") DOC_TEXT("")},
#define FAULT(name, cause, check) {#name, DOC_TEXT(cause) DOC_TEXT(check)},
#include "firmware/app/faults.def"
#undef FAULT
};

const fault_info_t *faults_info(uint16_t index) { return (index < (uint16_t)FAULT_COUNT) ? &TABLE[index] : NULL; }
