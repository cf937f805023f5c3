/**
 * @file  tests/hal/fake_driverlib/fake_memory.h
 * @brief Words of RAM and flash with the defects that memory has, for the self test of the port.
 */
#ifndef TESTS_HAL_FAKE_DRIVERLIB_FAKE_MEMORY_H
#define TESTS_HAL_FAKE_DRIVERLIB_FAKE_MEMORY_H

#include "hal/f28379d/self_test.h"

#define FAKE_MEMORY_FIRST UINT32_C(0xA000)
#define FAKE_MEMORY_WORDS 512U

typedef enum {
    FAKE_MEMORY_GOOD = 0,
    FAKE_MEMORY_STUCK_LOW, /* a bit of `at` */
    FAKE_MEMORY_STUCK_HIGH,
    FAKE_MEMORY_NO_RISE,      /* a bit of `at` does not go from 0 to 1 */
    FAKE_MEMORY_COUPLED,      /* a bit of `at` turns over when that of `by` rises */
    FAKE_MEMORY_COPIES,       /* a bit of `at` becomes that of `by` whenever this is written */
    FAKE_MEMORY_SAME_ADDRESS, /* `by` is the word of `at` */
    FAKE_MEMORY_BIT_FOLLOWS   /* a bit of `at` becomes that of the mask `by` in the same word */
} fake_defect_t;

typedef struct {
    uint16_t      word[FAKE_MEMORY_WORDS];
    fake_defect_t defect;
    uint32_t      at, by; /* counted from the first */
    uint16_t      bit;
    uint32_t      unmasked_writes; /* while an interrupt could come */
    uint32_t      masked_accesses, longest_masked;
} fake_memory_t;

extern fake_memory_t fake_memory;
extern port_places_t fake_places;

/** Good memory, nothing to test. */
void fake_memory_power_on(void);

#endif
