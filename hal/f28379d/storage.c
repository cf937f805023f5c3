/* This port stores nothing: programming flash needs a library that is not part of driverlib and stops execution from the
 * bank, which has to be tried on a board first. The drive is told so; it does not pretend. */
#include "hal/hal_storage.h"

uint16_t hal_storage_pages(void) { return 0U; }
uint16_t hal_storage_page_words(void) { return 0U; }

hal_status_t hal_storage_read(uint16_t page, uint16_t offset, uint16_t *words, uint16_t count)
{
    (void)page;
    (void)offset;
    (void)words;
    (void)count;
    return HAL_UNSUPPORTED;
}

hal_status_t hal_storage_write(uint16_t page, uint16_t offset, const uint16_t *words, uint16_t count)
{
    (void)page;
    (void)offset;
    (void)words;
    (void)count;
    return HAL_UNSUPPORTED;
}

hal_status_t hal_storage_erase(uint16_t page)
{
    (void)page;
    return HAL_UNSUPPORTED;
}
