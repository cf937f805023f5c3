/**
 * @file  tests/firmware/support/flash.h
 * @brief Non-volatile storage behind the stubs of hal_storage: it clears bits, is erased by pages, and loses power.
 */
#ifndef TESTS_FIRMWARE_SUPPORT_FLASH_H
#define TESTS_FIRMWARE_SUPPORT_FLASH_H

#include <stdbool.h>
#include <stdint.h>

#define FLASH_PAGES 4U
#define FLASH_WORDS 512U

typedef struct {
    uint16_t word[FLASH_PAGES][FLASH_WORDS];
    uint16_t pages, page_words;  /* as the board tells */
    uint32_t changes;            /* words written and pages erased */
    int32_t  until_power_fails;  /* changes until nothing happens any more; negative: never */
    uint32_t torn;               /* not 0: seed for the change in which the power goes, which is half done */
    int32_t  until_error;        /* changes until the storage refuses; negative: never */
    uint16_t odd_page, odd_word; /* a cell of which... */
    uint16_t stuck;              /* ...these bits read 0 whatever was written... */
    uint16_t unsteady;           /* ...and these read one way or the other */
    uint32_t chance;
} flash_t;

extern flash_t flash;

/** Connect the stubs; erased, powered. */
void flash_start(void);

#endif
