#include "tests/firmware/support/flash.h"

#include <string.h>

#include "mock_hal_storage.h"
#include "unity.h"

flash_t flash;

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

static hal_status_t reads(uint16_t page, uint16_t offset, uint16_t *words, uint16_t count, int calls)
{
    (void)calls;
    check(page, offset, count);
    (void)memcpy(words, &flash.word[page][offset], count * sizeof words[0]);
    if ((page == flash.odd_page) && (offset <= flash.odd_word) && (flash.odd_word < ((uint32_t)offset + count))) {
        uint16_t *const odd = &words[flash.odd_word - offset];
        flash.chance = (flash.chance * 1664525U) + 1013904223U;
        *odd = (uint16_t)((*odd & (uint16_t)~flash.stuck) ^ (flash.unsteady & (uint16_t)(flash.chance >> 16)));
    }
    return HAL_OK;
}

/* Bits that the failing power lets through. */
static uint16_t some_bits(void)
{
    flash.torn = (flash.torn * 1664525U) + 1013904223U;
    return (uint16_t)(flash.torn >> 16);
}

typedef enum { DONE, HALF, NOT_AT_ALL } power_t;

static power_t power(void)
{
    if (flash.until_power_fails < 0) {
        return DONE;
    }
    if (flash.until_power_fails > 0) {
        flash.until_power_fails--;
        return DONE;
    }
    const bool half = flash.torn != 0U;
    if (half) {
        (void)some_bits();
    }
    return half ? HALF : NOT_AT_ALL;
}

static bool refuses(void)
{
    flash.changes++;
    return (flash.until_error >= 0) && (flash.changes > (uint32_t)flash.until_error);
}

static hal_status_t writes(uint16_t page, uint16_t offset, const uint16_t *words, uint16_t count, int calls)
{
    (void)calls;
    check(page, offset, count);
    TEST_ASSERT_EQUAL_UINT16_MESSAGE(1U, count, "the tests count single words");
    if (refuses()) {
        return HAL_BUSY;
    }
    uint16_t *const to = &flash.word[page][offset];
    switch (power()) {
    case DONE:
        TEST_ASSERT_EQUAL_HEX16_MESSAGE(0xFFFFU, *to, "programmed without being erased");
        *to &= words[0];
        break;
    case HALF:
        *to &= (uint16_t)(words[0] | some_bits());
        flash.torn = 0U; /* and then it is dark */
        break;
    default:
        break;
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
    const power_t p = power();
    for (uint16_t i = 0U; (i < FLASH_WORDS) && (p != NOT_AT_ALL); i++) {
        flash.word[page][i] |= (p == DONE) ? 0xFFFFU : some_bits();
    }
    if (p == HALF) {
        flash.torn = 0U;
    }
    return HAL_OK;
}

void flash_start(void)
{
    (void)memset(flash.word, 0xFF, sizeof flash.word);
    flash.pages = FLASH_PAGES;
    flash.page_words = FLASH_WORDS;
    flash.changes = 0U;
    flash.until_power_fails = -1;
    flash.torn = 0U;
    flash.until_error = -1;
    flash.stuck = 0U;
    flash.unsteady = 0U;
    hal_storage_pages_Stub(pages);
    hal_storage_page_words_Stub(page_words);
    hal_storage_read_Stub(reads);
    hal_storage_write_Stub(writes);
    hal_storage_erase_Stub(erases);
}
