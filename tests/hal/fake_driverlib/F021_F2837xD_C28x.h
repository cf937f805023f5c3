/**
 * @file  tests/hal/fake_driverlib/F021_F2837xD_C28x.h
 * @brief As much of TI's flash API (F021, SPNU629) as the port calls: names and arguments, and a flash of its own.
 *
 * The fake demands what the API demands: pump, EALLOW, no error correction, no interrupt; blocks programmed once.
 */
#ifndef TESTS_HAL_FAKE_DRIVERLIB_F021_F2837XD_C28X_H
#define TESTS_HAL_FAKE_DRIVERLIB_F021_F2837XD_C28X_H

#include <stdbool.h>
#include <stdint.h>

typedef uint32_t uint32;
typedef uint16_t uint16;
typedef enum { Fapi_Status_Success = 0, Fapi_Status_FsmBusy, Fapi_Status_FsmReady, Fapi_Error_Fail } Fapi_StatusType;
typedef enum { Fapi_FlashBank0 = 0 } Fapi_FlashBankType;
typedef enum { Fapi_EraseSector = 0x06 } Fapi_FlashStateCommandsType;
typedef enum { Fapi_AutoEccGeneration = 0 } Fapi_FlashProgrammingCommandsType;
typedef uint32 Fapi_FlashStatusType;
#define F021_CPU0_BASE_ADDRESS ((void *)0x5F800)

Fapi_StatusType Fapi_initializeAPI(void *poFlashControlRegister, uint32 u32HclkFrequency);
Fapi_StatusType Fapi_setActiveFlashBank(Fapi_FlashBankType oNewFlashBank);
Fapi_StatusType Fapi_issueAsyncCommandWithAddress(Fapi_FlashStateCommandsType oCommand, uint32 *pu32StartAddress);
Fapi_StatusType Fapi_issueProgrammingCommand(uint32 *pu32StartAddress, uint16 *pu16DataBuffer, uint16 u16DataBufferSizeInWords,
                                             uint16 *pu16EccBuffer, uint16 u16EccBufferSizeInBytes,
                                             Fapi_FlashProgrammingCommandsType oMode);
Fapi_StatusType Fapi_checkFsmForReady(void);
Fapi_FlashStatusType Fapi_getFsmStatus(void);
void                 Fapi_flushPipeline(void);

/* ---- the flash behind it ---- */
#define FAKE_FLASH_WORDS (3U * 0x2000U)
typedef struct {
    uint16_t word[FAKE_FLASH_WORDS];
    bool     programmed[FAKE_FLASH_WORDS / 4U];
    bool     pump, ecc, eallow, initialised, stale; /* stale: prefetched words may be read */
    uint32_t busy_cyc, busy_until;                  /* of each command */
    uint32_t status;                                /* what the state machine says at the end */
    uint16_t broken;                                /* demands that were not met */
} fake_flash_t;
extern fake_flash_t fake_flash;
#ifndef __TMS320C28XX__ /* there it is an address */
uint16_t *cell(uint32_t address);
#endif

#endif
