#include "tests/firmware/support/flash.h"

#include <string.h>

#include "hal/hal_storage.h"
#include "mock_hal_storage.h"
#include "unity.h"

enum { ERASED = 0, PROGRAMMED, CUT, ERASE_CUT };

flash_t flash;

uint32_t flash_pick(uint32_t below)
{
    flash.chance = (flash.chance * 1664525U) + 1013904223U;
    return (uint32_t)(((uint64_t)flash.chance * below) >> 32);
}

static uint16_t some_bits(void) { return (uint16_t)flash_pick(65536U); }

static uint16_t pages(int calls)
{
    (void)calls;
    return flash.pages;
}

static uint16_t page_words(int calls)
{
    (void)calls;
    return flash.page_words;
}

static void check(uint16_t page, uint16_t offset, uint16_t count)
{
    TEST_ASSERT_TRUE_MESSAGE((page < flash.pages) && ((uint32_t)offset + count <= flash.page_words), "outside of the storage");
}

/* Tests are compiled at -O0; what takes most of the time of this one is not. */
#pragma GCC push_options
#pragma GCC         optimize("O1")
static hal_status_t reads(uint16_t page, uint16_t offset, uint16_t *words, uint16_t count, int calls)
{
    (void)calls;
    check(page, offset, count);
    const flash_cells_t *const c = &flash.cells;
    bool                       lost = false;
    for (uint16_t i = 0U; i < count; i++) {
        const uint16_t at = (uint16_t)(offset + i);
        words[i] = c->word[page][at];
        if (c->unsure[page][at] != 0U) {
            words[i] ^= (uint16_t)(c->unsure[page][at] & some_bits());
            lost = lost || (flash.ecc && (flash_pick(4U) == 0U));
        }
        if ((page == flash.odd_page) && (at == flash.odd_word)) {
            words[i] = (uint16_t)((words[i] & (uint16_t)~flash.stuck) ^ (flash.unsteady & some_bits()));
        }
    }
    flash.reads++;
    const int32_t first = (int32_t)((page * FLASH_BLOCKS) + (offset / HAL_STORAGE_BLOCK_WORDS));
    const int32_t last = (int32_t)((page * FLASH_BLOCKS) + ((offset + count - 1U) / HAL_STORAGE_BLOCK_WORDS));
    const bool    dead = (flash.dead_block >= first) && (flash.dead_block <= last) && (flash.dead_reads != 0);
    flash.dead_reads -= (dead && (flash.dead_reads > 0)) ? 1 : 0;
    if ((flash.bad_read == (int32_t)(flash.reads - 1U)) || dead) {
        for (uint16_t i = 0U; i < count; i++) {
            words[i] = some_bits();
        }
        lost = true;
    }
    return lost ? HAL_SENSOR_FAULT : HAL_OK;
}

typedef enum { DONE, HALF, NOT_AT_ALL } power_t;

#pragma GCC pop_options

static power_t power(void)
{
    if (flash.until_power_fails < 0) {
        return DONE;
    }
    if (flash.until_power_fails > 0) {
        flash.until_power_fails--;
        return DONE;
    }
    const bool half = flash.torn;
    flash.torn = false; /* and then it is dark */
    return half ? HALF : NOT_AT_ALL;
}

static bool refuses(void)
{
    flash.changes++;
    return (flash.until_error >= 0) && (flash.changes > (uint32_t)flash.until_error);
}

static void program(uint16_t page, uint16_t offset, const uint16_t *words, bool whole)
{
    flash_cells_t *const c = &flash.cells;
    uint16_t *const      state = &c->state[page][offset / HAL_STORAGE_BLOCK_WORDS];
    for (uint16_t i = 0U; i < HAL_STORAGE_BLOCK_WORDS; i++) {
        uint16_t *const word = &c->word[page][offset + i];
        uint16_t *const unsure = &c->unsure[page][offset + i];
        if (*state == (uint16_t)CUT) {
            TEST_ASSERT_EQUAL_HEX16_MESSAGE(c->meant[page][offset + i], words[i], "other words over a block that was cut");
        } else {
            TEST_ASSERT_EQUAL_INT_MESSAGE(ERASED, *state, "programmed without being erased");
        }
        c->meant[page][offset + i] = words[i];
        *unsure = whole ? 0U : (uint16_t)(~words[i] & (*unsure | some_bits())); /* cells that do not hold enough charge yet */
        *word = whole ? words[i] : (uint16_t)(*word & (words[i] | *unsure | some_bits()));
    }
    *state = whole ? (uint16_t)PROGRAMMED : (uint16_t)CUT;
}

static hal_status_t writes(uint16_t page, uint16_t offset, const uint16_t *words, uint16_t count, int calls)
{
    (void)calls;
    check(page, offset, count);
    TEST_ASSERT_EQUAL_UINT16_MESSAGE(0U, offset % HAL_STORAGE_BLOCK_WORDS, "not the beginning of a block");
    TEST_ASSERT_EQUAL_UINT16_MESSAGE(HAL_STORAGE_BLOCK_WORDS, count, "the tests count single blocks");
    if (refuses()) {
        return HAL_BUSY;
    }
    const power_t p = power();
    if (p != NOT_AT_ALL) {
        program(page, offset, words, p == DONE);
    }
    return HAL_OK;
}

static hal_status_t erases(uint16_t page, int calls)
{
    (void)calls;
    check(page, 0U, 1U);
    if (refuses()) {
        return HAL_BUSY;
    }
    const power_t        p = power();
    flash_cells_t *const c = &flash.cells;
    if (p == DONE) {
        (void)memset(c->word[page], 0xFF, sizeof c->word[page]);
        (void)memset(c->unsure[page], 0, sizeof c->unsure[page]);
        (void)memset(c->state[page], 0, sizeof c->state[page]);
        c->erased[page]++;
    } else if (p == HALF) {
        const uint16_t share = some_bits(); /* how far it got */
        for (uint16_t i = 0U; i < FLASH_WORDS; i++) {
            c->unsure[page][i] |= (uint16_t)(~c->word[page][i] & (some_bits() | share));
            c->state[page][i / HAL_STORAGE_BLOCK_WORDS] = ERASE_CUT;
        }
    } else {
        /* dark */
    }
    return HAL_OK;
}

void flash_power_up(void)
{
    flash.until_power_fails = -1;
    flash.torn = false;
}

void flash_start(void)
{
    (void)memset(&flash, 0, sizeof flash);
    (void)memset(flash.cells.word, 0xFF, sizeof flash.cells.word);
    flash.pages = FLASH_PAGES;
    flash.page_words = FLASH_WORDS;
    flash.until_power_fails = -1;
    flash.until_error = -1;
    flash.bad_read = -1;
    flash.dead_block = -1;
    flash.dead_reads = -1;
    hal_storage_pages_Stub(pages);
    hal_storage_page_words_Stub(page_words);
    hal_storage_read_Stub(reads);
    hal_storage_write_Stub(writes);
    hal_storage_erase_Stub(erases);
}
