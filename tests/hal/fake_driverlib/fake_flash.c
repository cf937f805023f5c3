/* Flash and its API. The clock goes on while a command runs. */
#include <string.h>

#include "F021_F2837xD_C28x.h"
#include "fake_chip.h"

#define FIRST 0x0B8000U

fake_flash_t fake_flash = {.ecc = true};

uint16_t *cell(uint32_t address)
{
    const uint32_t at = address - FIRST;
    fake_flash.broken = (uint16_t)(fake_flash.broken + ((at < FAKE_FLASH_WORDS) ? 0U : 1U));
    return &fake_flash.word[at % FAKE_FLASH_WORDS];
}

static void demand(bool met) { fake_flash.broken = (uint16_t)(fake_flash.broken + (met ? 0U : 1U)); }
static void demand_all(void) { demand(fake_flash.pump && fake_flash.eallow && !fake_flash.ecc && chip.intm); }

void fake_eallow(void) { fake_flash.eallow = true; }
void fake_edis(void) { fake_flash.eallow = false; }
void Flash_claimPumpSemaphore(uint32_t pumpSemBase, Flash_PumpOwnership wrapper)
{
    RECORD(pumpSemBase, (uint32_t)wrapper);
    fake_flash.pump = wrapper == FLASH_CPU1_WRAPPER;
}
void Flash_releasePumpSemaphore(uint32_t pumpSemBase)
{
    RECORD(pumpSemBase);
    fake_flash.pump = false;
}
void Flash_disableECC(uint32_t eccBase)
{
    demand(eccBase == FLASH0ECC_BASE);
    demand(!fake_flash.stale);
    fake_flash.ecc = false;
}
void Flash_enableECC(uint32_t eccBase)
{
    demand(eccBase == FLASH0ECC_BASE);
    fake_flash.ecc = true;
}

Fapi_StatusType Fapi_initializeAPI(void *poFlashControlRegister, uint32 u32HclkFrequency)
{
    demand_all();
    demand((poFlashControlRegister == F021_CPU0_BASE_ADDRESS) && (u32HclkFrequency == 200U)); /* MHz */
    fake_flash.initialised = true;
    return Fapi_Status_Success;
}

Fapi_StatusType Fapi_setActiveFlashBank(Fapi_FlashBankType oNewFlashBank)
{
    demand_all();
    demand(fake_flash.initialised && (oNewFlashBank == Fapi_FlashBank0));
    return Fapi_Status_Success;
}

static void begin(void)
{
    demand_all();
    fake_flash.stale = true;
    fake_flash.busy_until = (uint32_t)chip.cycles + fake_flash.busy_cyc;
}

Fapi_StatusType Fapi_issueAsyncCommandWithAddress(Fapi_FlashStateCommandsType oCommand, uint32 *pu32StartAddress)
{
    const size_t at = (size_t)((uint16_t *)(void *)pu32StartAddress - fake_flash.word);
    begin();
    demand((oCommand == Fapi_EraseSector) && ((at % 0x2000U) == 0U));
    (void)memset(&fake_flash.word[at], 0xFF, 0x2000U * sizeof fake_flash.word[0]);
    (void)memset(&fake_flash.programmed[at / 4U], 0, 0x2000U / 4U * sizeof fake_flash.programmed[0]);
    return Fapi_Status_Success;
}

Fapi_StatusType Fapi_issueProgrammingCommand(uint32 *pu32StartAddress, uint16 *pu16DataBuffer, uint16 u16DataBufferSizeInWords,
                                             uint16 *pu16EccBuffer, uint16 u16EccBufferSizeInBytes,
                                             Fapi_FlashProgrammingCommandsType oMode)
{
    const size_t at = (size_t)((uint16_t *)(void *)pu32StartAddress - fake_flash.word);
    begin();
    demand((u16DataBufferSizeInWords == 4U) && (pu16EccBuffer == NULL) && (u16EccBufferSizeInBytes == 0U));
    demand((oMode == Fapi_AutoEccGeneration) && ((at % 4U) == 0U) && !fake_flash.programmed[at / 4U]);
    (void)memcpy(&fake_flash.word[at], pu16DataBuffer, 4U * sizeof fake_flash.word[0]);
    fake_flash.programmed[at / 4U] = true;
    return Fapi_Status_Success;
}

Fapi_StatusType Fapi_checkFsmForReady(void)
{
    demand_all();
    chip.cycles += 2000U;
    return ((int32_t)((uint32_t)chip.cycles - fake_flash.busy_until) >= 0) ? Fapi_Status_FsmReady : Fapi_Status_FsmBusy;
}
Fapi_FlashStatusType Fapi_getFsmStatus(void) { return fake_flash.status; }
void                 Fapi_flushPipeline(void) { fake_flash.stale = false; }
