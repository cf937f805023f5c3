/**
 * @file  hal/include/hal/hal_storage.h
 * @brief Non-volatile pages for parameters, as 16-bit words.
 */
#ifndef HAL_HAL_STORAGE_H
#define HAL_HAL_STORAGE_H

#include "hal/hal_types.h"

/** Pages that can be erased one by one, and words in each. 0 pages: this board stores nothing. */
uint16_t hal_storage_pages(void);
uint16_t hal_storage_page_words(void);
/** Read words. From the main loop. */
hal_status_t hal_storage_read(uint16_t page, uint16_t offset, uint16_t *words, uint16_t count);
/** Program words that were erased before. May take milliseconds: refuses with HAL_BUSY while the bridge is armed. */
hal_status_t hal_storage_write(uint16_t page, uint16_t offset, const uint16_t *words, uint16_t count);
/** Erase a page to all ones. Refuses with HAL_BUSY while the bridge is armed. */
hal_status_t hal_storage_erase(uint16_t page);

#endif
