/* Parameters and learned table in three sectors of flash, with TI's flash API (F021, SPNU629), where the build has found it.
 * Without it the board stores nothing, and says so.
 *
 * CPU1 has one bank: while it is programmed or erased nothing can be fetched or read from it. So what runs here, and the API, lie
 * in RAM, and the interrupts are kept away; the bridge is off, else refused, and held off by the one-shot trip. The error
 * correction is off around programming and reading: programming reads TI's own OTP, whose correction bits are wrong (errata), and
 * a block in which the power went would end in an NMI. Whether a block is right is judged by the store's check sums. */
#include "hal/hal_storage.h"

#include <stddef.h>

#include "hal/f28379d/parts.h"
#include "hal/hal_clock.h"

#ifdef EVENSPIN_FLASH_API
#include "F021_F2837xD_C28x.h"

#define FIRST_SECTOR UINT32_C(0x0B8000) /* K, L, M: linker/f28379d_flash.cmd keeps them free */
#define SECTORS 3U
#define SECTOR_WORDS 0x2000U
#define SERVE_CYC (BOARD_SYSCLK_HZ / 50U)            /* every 20 ms: the watchdog bites after 52 ms */
#define PATIENCE_CYC (UINT32_C(2) * BOARD_SYSCLK_HZ) /* longer than any erase: then the watchdog is no longer served */

#ifdef __TMS320C28XX__
static inline uint16_t *cell(uint32_t address) { return (uint16_t *)address; }
#else
uint16_t *cell(uint32_t address); /* of the fake's flash */
#endif

uint16_t hal_storage_pages(void) { return SECTORS; }
uint16_t hal_storage_page_words(void) { return SECTOR_WORDS; }

static bool has(uint16_t page, uint16_t offset, uint16_t count)
{
    return (page < SECTORS) && (((uint32_t)offset + count) <= SECTOR_WORDS);
}

static uint32_t address_of(uint16_t page, uint16_t offset) { return FIRST_SECTOR + ((uint32_t)page * SECTOR_WORDS) + offset; }

/* Until the state machine of the flash has finished; a long erase does not end in a reset, one without an end does. */
BOARD_RAM_CODE static bool finished(void)
{
    const uint32_t began = hal_clock_cyc();
    uint32_t       served = began;
    while (Fapi_checkFsmForReady() != Fapi_Status_FsmReady) {
        const uint32_t now = hal_clock_cyc();
        if (((now - served) >= SERVE_CYC) && ((now - began) < PATIENCE_CYC)) {
            port_watchdog_serve();
            served = now;
        }
    }
    return Fapi_getFsmStatus() == 0U;
}

/* @p words NULL: erase the sector. One command, with everything that it needs before and after. */
BOARD_RAM_CODE static hal_status_t change(uint32_t address, const uint16_t *words)
{
    uint16_t block[HAL_STORAGE_BLOCK_WORDS];
    for (uint16_t i = 0U; (i < HAL_STORAGE_BLOCK_WORDS) && (words != NULL); i++) {
        block[i] = words[i]; /* the source may lie in flash, the API may not read it there */
    }
    const bool were_off = Interrupt_disableGlobal();
    Flash_claimPumpSemaphore(FLASHPUMPSEMAPHORE_BASE, FLASH_CPU1_WRAPPER);
    Flash_disableECC(FLASH0ECC_BASE);
    EALLOW;
    bool good = Fapi_initializeAPI(F021_CPU0_BASE_ADDRESS, BOARD_SYSCLK_HZ / UINT32_C(1000000)) == Fapi_Status_Success;
    good = good && (Fapi_setActiveFlashBank(Fapi_FlashBank0) == Fapi_Status_Success);
    if (good) {
        const Fapi_StatusType issued = (words == NULL)
                                           ? Fapi_issueAsyncCommandWithAddress(Fapi_EraseSector, (uint32 *)(void *)cell(address))
                                           : Fapi_issueProgrammingCommand((uint32 *)(void *)cell(address), block,
                                                                          HAL_STORAGE_BLOCK_WORDS, 0, 0U, Fapi_AutoEccGeneration);
        good = finished() && (issued == Fapi_Status_Success);
        Fapi_flushPipeline(); /* what was prefetched is no longer true */
    }
    EDIS;
    Flash_enableECC(FLASH0ECC_BASE);
    Flash_releasePumpSemaphore(FLASHPUMPSEMAPHORE_BASE);
    port_sampling_resume(); /* the periods that went by were nobody's loss */
    if (!were_off) {
        (void)Interrupt_enableGlobal();
    }
    return good ? HAL_OK : HAL_SENSOR_FAULT;
}

BOARD_RAM_CODE hal_status_t hal_storage_read(uint16_t page, uint16_t offset, uint16_t *words, uint16_t count)
{
    if (!has(page, offset, count)) {
        return HAL_UNSUPPORTED;
    }
    const volatile uint16_t *const from = cell(address_of(page, offset));
    Flash_disableECC(FLASH0ECC_BASE);
    for (uint16_t i = 0U; i < count; i++) {
        words[i] = from[i];
    }
    Flash_enableECC(FLASH0ECC_BASE);
    return HAL_OK;
}

hal_status_t hal_storage_write(uint16_t page, uint16_t offset, const uint16_t *words, uint16_t count)
{
    hal_status_t s = HAL_OK;
    if (!has(page, offset, count) || ((offset % HAL_STORAGE_BLOCK_WORDS) != 0U) || ((count % HAL_STORAGE_BLOCK_WORDS) != 0U)) {
        return HAL_UNSUPPORTED;
    }
    for (uint16_t i = 0U; (i < count) && (s == HAL_OK); i = (uint16_t)(i + HAL_STORAGE_BLOCK_WORDS)) {
        s = port_trip_bridge_is_off() ? change(address_of(page, (uint16_t)(offset + i)), &words[i]) : HAL_BUSY;
    }
    return s;
}

hal_status_t hal_storage_erase(uint16_t page)
{
    if (page >= SECTORS) {
        return HAL_UNSUPPORTED;
    }
    return port_trip_bridge_is_off() ? change(address_of(page, 0U), NULL) : HAL_BUSY;
}

#else

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

#endif
