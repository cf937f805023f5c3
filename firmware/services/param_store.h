/**
 * @file  firmware/services/param_store.h
 * @brief The parameter set over a power cycle: two slots, and a save that a power failure cannot spoil.
 *
 * A save goes to the slot that is not the newest: erase, values, header from its end to its second word; all of that is read
 * back; then the first word of the header makes the slot exist, and is read back, too. A check sum covers all of it. Until that
 * first word is written the older set is the newest; from then on the new one. A cell that does not keep what was written makes
 * the save fail. A load reads every word once and takes what it has checked. Values are kept with the hash of the schema: a set of another firmware does not exist.
 */
#ifndef FIRMWARE_SERVICES_PARAM_STORE_H
#define FIRMWARE_SERVICES_PARAM_STORE_H

#include "firmware/app/parameters.h"
#include "hal/hal_types.h"

#define PARAM_STORE_WORDS_PER_STEP 16U

typedef struct {
    const drive_params_t *params; /**< Must not change during a save. */
    uint32_t              schema, crc;
    uint16_t              slot, sequence;
    uint16_t              next; /**< Words written and read back so far, in that order. */
    bool                  active, erased;
} param_store_t;

/** Is there room for two sets on this board? */
bool param_store_present(void);
/** Begin to save. @return HAL_UNSUPPORTED without room, HAL_BUSY during another save. */
hal_status_t param_store_begin(param_store_t *s, const drive_params_t *params, uint32_t schema);
/** Go on: an erase, or a few words. @return HAL_BUSY: call again; HAL_OK: done; else failed, and the older set stands. */
hal_status_t param_store_step(param_store_t *s);
/** Newest set that reads as it was saved. @return HAL_OK; HAL_STALE, HAL_UNSUPPORTED: none, @p params stays; HAL_SENSOR_FAULT:
 *  what is there does not read as it was saved, and @p params is of no use. Reads at most 6 times 300 words. */
hal_status_t param_store_load(drive_params_t *params, uint32_t schema);

#endif
