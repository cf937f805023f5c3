/**
 * @file  hal/include/hal/hal_storage.h
 * @brief Non-volatile pages, as 16-bit words, with the manners of flash that has an error correction.
 *
 * A page is erased as a whole, to all ones. A block of HAL_STORAGE_BLOCK_WORDS, aligned, is programmed once after that, as a
 * whole: its error correction is programmed with it, and another write would spoil that. What a block holds when the power
 * fails while it is written is anything, and may read differently each time; so does a page in the middle of an erase.
 */
#ifndef HAL_HAL_STORAGE_H
#define HAL_HAL_STORAGE_H

#include "hal/hal_types.h"

#define HAL_STORAGE_BLOCK_WORDS 4U

/** Pages that can be erased one by one, and words in each, whole blocks. 0 pages: this board stores nothing. */
uint16_t hal_storage_pages(void);
uint16_t hal_storage_page_words(void);
/** Read words, from anywhere. From the main loop. What the hardware cannot correct is HAL_SENSOR_FAULT, or wrong words. */
hal_status_t hal_storage_read(uint16_t page, uint16_t offset, uint16_t *words, uint16_t count);
/** Program blocks that were erased and not written since; @p offset and @p count are whole blocks. May take milliseconds, and
 *  may keep the interrupts away meanwhile: refuses with HAL_BUSY while the bridge is armed. */
hal_status_t hal_storage_write(uint16_t page, uint16_t offset, const uint16_t *words, uint16_t count);
/** Erase a page to all ones. May take a few 100 ms, as above. Refuses with HAL_BUSY while the bridge is armed. */
hal_status_t hal_storage_erase(uint16_t page);

#endif
