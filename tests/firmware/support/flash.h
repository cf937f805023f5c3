/**
 * @file  tests/firmware/support/flash.h
 * @brief A model of flash with error correction behind the stubs of hal_storage, which loses power at a block or an erase.
 *
 * Pages are erased as a whole, blocks of four words programmed once and aligned; a test fails when that is not kept. A block
 * in which the power went, and the cells of a page whose erase was cut, read one way or the other, again at every read; and
 * with `ecc` such a block may be reported as not correctable instead. The same words may be programmed again over a block
 * that was cut, which then is sound.
 */
#ifndef TESTS_FIRMWARE_SUPPORT_FLASH_H
#define TESTS_FIRMWARE_SUPPORT_FLASH_H

#include <stdbool.h>
#include <stdint.h>

#define FLASH_PAGES 3U
#define FLASH_WORDS 1024U
#define FLASH_BLOCKS (FLASH_WORDS / 4U)

/** What the cells are: saved and put back as a whole by tests that try every cut. */
typedef struct {
    uint16_t word[FLASH_PAGES][FLASH_WORDS];
    uint16_t unsure[FLASH_PAGES][FLASH_WORDS]; /* bits that read one way or the other */
    uint16_t meant[FLASH_PAGES][FLASH_WORDS];  /* what was being written into a block that was cut */
    uint16_t state[FLASH_PAGES][FLASH_BLOCKS]; /* 0 erased, 1 programmed, 2 cut, 3 in an erase that was cut */
    uint32_t erased[FLASH_PAGES];              /* how often */
} flash_cells_t;

typedef struct {
    flash_cells_t cells;
    uint16_t      pages, page_words;  /* as the board tells */
    uint32_t      changes;            /* blocks written and pages erased */
    int32_t       until_power_fails;  /* changes until nothing happens any more; negative: never */
    bool          torn;               /* the change in which the power goes is half done */
    bool          ecc;                /* what was cut may read as not correctable */
    int32_t       until_error;        /* changes until the storage refuses; negative: never */
    uint16_t      odd_page, odd_word; /* a cell of which... */
    uint16_t      stuck;              /* ...these bits read 0 whatever was written... */
    uint16_t      unsteady;           /* ...and these read one way or the other */
    uint32_t      reads;              /* calls so far */
    int32_t       bad_read;           /* the call that fails, with any words; negative: none */
    int32_t       dead_block;         /* block of the whole storage that cannot be read any more; negative: none */
    int32_t       dead_reads;         /* so often, and then it can; negative: never */
    uint32_t      chance;
} flash_t;

extern flash_t flash;

/** Connect the stubs; erased, powered. */
void flash_start(void);
/** The power is back. */
void flash_power_up(void);
/** A number below @p below, the same in every run. */
uint32_t flash_pick(uint32_t below);

#endif
