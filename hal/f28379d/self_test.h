/**
 * @file  hal/f28379d/self_test.h
 * @brief What the processor tests of itself: RAM, program, and its own operations. Each whole at the start, and slice by slice in the
 *        main loop. What fails stays until the next reset: HAL_INVERTER_RAM_TEST, _PROGRAM_TEST, _PROCESSOR_TEST.
 *
 * Not in a program for RAM: there is no room for it, and its program has neither check sums nor a copy to be compared with.
 */
#ifndef HAL_F28379D_SELF_TEST_H
#define HAL_F28379D_SELF_TEST_H

#include "crc_tbl.h" /* of TI's compiler: the tables that its linker makes */
#include "hal/f28379d/parts.h"

#define PORT_RAM_SLICE_WORDS 2U
#define PORT_PROGRAM_SLICE_WORDS 16U

/** Addresses of words. */
typedef struct {
    uint32_t first, words;
} port_region_t;

typedef struct {
    uint32_t run, load, words;
} port_copy_t;

/** Operands of the processor's test, so that a test can change one. */
typedef struct {
    uint16_t word[4];
    uint32_t dword[4];
    int32_t  number[2];
    float    real[6];
} port_operands_t;
/** What is tested; no more regions than those with words. */
typedef struct {
    const port_region_t *fresh; /**< RAM in which nothing is worth keeping at the start: tested whole then. */
    const port_region_t *ram;  /**< RAM that is tested slice by slice, its content kept; not the stack, on which the test runs. */
    const port_copy_t   *copy; /**< Program in RAM, and where it was copied from. */
    const CRC_TABLE     *sums; /**< Of the sections in flash; NULL: none are known. */
    uint16_t             fresh_count, ram_count, copy_count;
    const volatile port_operands_t *operands; /**< Of the processor's test: port_operands. */
} port_places_t;

/** March C- over words of RAM, with @p background and its complement: all of them keep both, no write changes another one, and each
 *  has an address of its own. Leaves the words as the march does. @return UINT32_MAX, or the address of a word that failed. */
uint32_t port_ram_march(uint32_t first, uint32_t words, uint16_t background);
/** March C- over PORT_RAM_SLICE_WORDS words, which are then as they were; interrupts are masked. @return As port_ram_march. */
uint32_t port_ram_slice(uint32_t first, uint16_t background);

/** A slice of the program. `at` is the address of the record or copy that differs. */
typedef enum { PORT_PROGRAM_GOES_ON = 0, PORT_PROGRAM_WHOLE, PORT_PROGRAM_DIFFERS } port_program_t;
void           port_program_begin(void);
port_program_t port_program_slice(const port_places_t *places, uint32_t *at);

extern const volatile port_operands_t port_operands;
/** What the operations make of them, folded into one number: PORT_PROCESSOR_SIGNATURE from port_operands. About 1900 cycles. */
uint32_t port_processor_signature(const volatile port_operands_t *of);
#define PORT_PROCESSOR_SIGNATURE UINT32_C(0xF4F34017) /* calculated in exact numbers, not by this code */

/** self_test_places.c: of the linker; elsewhere a test has its own. */
const port_places_t *port_self_test_places(void);

#ifdef __TMS320C28XX__
static inline uint16_t port_take(uint32_t address) { return *(const volatile uint16_t *)address; }
static inline void     port_put(uint32_t address, uint16_t word) { *(volatile uint16_t *)address = word; }
#else
uint16_t port_take(uint32_t address); /* of the fake's memory */
void     port_put(uint32_t address, uint16_t word);
#endif

#endif
