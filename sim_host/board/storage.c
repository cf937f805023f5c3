/* The non-volatile pages of the virtual board: flash, as the contract has it. */
#include "hal/hal_storage.h"

#include <string.h>

#include "sim_host/board/board.h"

void sim_board_erase(sim_board_t *board) { memset(board->storage, 0xFF, sizeof board->storage); }

static bool storage_is_blocks(uint16_t offset, uint16_t count)
{
    return ((offset % HAL_STORAGE_BLOCK_WORDS) == 0U) && ((count % HAL_STORAGE_BLOCK_WORDS) == 0U);
}

static bool storage_has(uint16_t page, uint16_t offset, uint16_t count)
{
    return (page < SIM_STORAGE_PAGES) && ((uint32_t)offset + count <= SIM_STORAGE_WORDS);
}

uint16_t hal_storage_pages(void)
{
    trace_count(sim_board_selected()->trace, TRACE_hal_storage_pages, SIM_STORAGE_PAGES);
    return SIM_STORAGE_PAGES;
}

uint16_t hal_storage_page_words(void)
{
    trace_count(sim_board_selected()->trace, TRACE_hal_storage_page_words, SIM_STORAGE_WORDS);
    return SIM_STORAGE_WORDS;
}

hal_status_t hal_storage_read(uint16_t page, uint16_t offset, uint16_t *words, uint16_t count)
{
    const hal_status_t status = storage_has(page, offset, count) ? HAL_OK : HAL_UNSUPPORTED;
    if (status == HAL_OK) {
        memcpy(words, &sim_board_selected()->storage[page][offset], count * sizeof words[0]);
    }
    trace_storage_read(sim_board_selected()->trace, status, words, count);
    return status;
}

static hal_status_t may_write(bool there)
{
    const hal_status_t unless_armed = sim_board_selected()->armed ? HAL_BUSY : HAL_OK;
    return there ? unless_armed : HAL_UNSUPPORTED;
}

hal_status_t hal_storage_write(uint16_t page, uint16_t offset, const uint16_t *words, uint16_t count)
{
    const hal_status_t status = may_write(storage_has(page, offset, count) && storage_is_blocks(offset, count));
    for (uint16_t i = 0; (status == HAL_OK) && (i < count); i++) { /* programming clears bits and sets none, as in flash */
        sim_board_selected()->storage[page][offset + i] &= words[i];
    }
    trace_storage_write(sim_board_selected()->trace, status, words, count);
    return status;
}

hal_status_t hal_storage_erase(uint16_t page)
{
    const hal_status_t status = may_write(page < SIM_STORAGE_PAGES);
    if (status == HAL_OK) {
        memset(sim_board_selected()->storage[page], 0xFF, sizeof sim_board_selected()->storage[page]);
    }
    trace_status(sim_board_selected()->trace, TRACE_hal_storage_erase, (uint16_t)status);
    return status;
}
