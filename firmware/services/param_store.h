/**
 * @file  firmware/services/param_store.h
 * @brief The parameter set over a power cycle: two slots, and a save that a power failure cannot spoil.
 *
 * A save goes to the slot that is not the newest: erase, values, header from its end to its beginning; the first word of the
 * header makes the slot exist, and a check sum covers all of it. Until that word is written the older set is the newest; from
 * then on the new one. Values are kept with the hash of the schema: a set of another firmware does not exist.
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
    uint16_t              next; /**< Words done, in the order in which they are written. */
    bool                  active, erased;
} param_store_t;

/** Is there room for two sets on this board? */
bool param_store_present(void);
/** Begin to save. @return HAL_UNSUPPORTED without room, HAL_BUSY during another save. */
hal_status_t param_store_begin(param_store_t *s, const drive_params_t *params, uint32_t schema);
/** Go on: an erase, or a few words. @return HAL_BUSY: call again; HAL_OK: done; else failed, and the older set stands. */
hal_status_t param_store_step(param_store_t *s);
/** Newest good set over @p params. @return HAL_OK, HAL_STALE (none; @p params stays), HAL_UNSUPPORTED, or an error of the
 *  storage. Reads two slots, about 300 words each. */
hal_status_t param_store_load(drive_params_t *params, uint32_t schema);

#endif
