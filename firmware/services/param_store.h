/**
 * @file  firmware/services/param_store.h
 * @brief The parameter set over a power cycle: the part STORE_PARAMETERS of the store, tagged with the hash of the schema, so
 *        that a set of another firmware does not exist.
 */
#ifndef FIRMWARE_SERVICES_PARAM_STORE_H
#define FIRMWARE_SERVICES_PARAM_STORE_H

#include "firmware/app/parameters.h"
#include "firmware/storage/store.h"

/** Is there room for a set on this board? */
bool param_store_present(void);
/** Begin to save; @p params must not change during it. @return HAL_UNSUPPORTED without room, HAL_BUSY during another save. */
hal_status_t param_store_begin(store_t *s, const drive_params_t *params, uint32_t schema);
/** Go on with any save: an erase, or a few blocks. @return HAL_BUSY: call again; HAL_OK: done; else failed, and the older set stands. */
hal_status_t param_store_step(store_t *s);
/** Newest set that reads as it was saved. @return HAL_OK; HAL_STALE, HAL_UNSUPPORTED: none, @p params stays; HAL_SENSOR_FAULT:
 *  what is there does not read as it was saved, and @p params is of no use. */
hal_status_t param_store_load(const store_t *s, drive_params_t *params, uint32_t schema);

#endif
