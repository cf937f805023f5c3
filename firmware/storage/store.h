/**
 * @file  firmware/storage/store.h
 * @brief One store for what lives through power-off: parameters and learned table, saved together, the old set or the new one.
 *
 * A save writes a whole set, the part that it does not change copied from the newest set. Sets stand one behind the other in
 * a page:
 *
 *     head      magic, number (32 bits), words of both parts, tag of the first part (32 bits), check
 *     parts     padded to whole blocks with zeros, which no check sum covers
 *     trailer   check sum of each part
 *     commit    a block of its own, written last: magic, number, check sum over head and trailer; only then the set exists
 *     confirm   the same again
 *
 * Before the commit all of it is read back. A set exists when its commit or its confirm reads right. A commit that the power
 * has cut may read 0 once and 1 once; a confirm shows that the commit had been finished, so a set that counts gets it
 * before anything else is erased. Each page begins with a block that counts its erases.
 *
 * The first save after power-up takes a fresh page, because a block may have been begun that does not show it, and never the
 * page with the newest set: so pages wear evenly, and there must be two. CRC-32/ISCSI everywhere.
 */
#ifndef FIRMWARE_STORAGE_STORE_H
#define FIRMWARE_STORAGE_STORE_H

#include "hal/hal_storage.h"

#define STORE_BLOCKS_PER_STEP 4U

/** The parts of a set. */
typedef enum { STORE_PARAMETERS = 0, STORE_TABLE, STORE_PARTS } store_part_t;

/** Word @p index of what is saved; must be the same from begin to the last step. */
typedef uint16_t (*store_give_t)(const void *from, uint16_t index);
/** Word @p index of what is loaded, in order. */
typedef void (*store_take_t)(void *to, uint16_t index, uint16_t word);

/** What the head of a set says, and where it stands. */
typedef struct {
    uint32_t sequence, tag;
    uint16_t words[STORE_PARTS];
    uint16_t page, at;
} store_set_t;

/** All zeros: power-up. */
typedef struct {
    bool         active; /**< A save is in progress. */
    bool         open;   /**< The page of `set` was begun since power-up: the next set may stand behind. */
    uint16_t     next_at;
    bool         doubtful; /**< The last confirm did not read right: nothing more into this page. */
    uint16_t     failures; /**< Saves that failed since power-up. */
    uint32_t     erases;   /**< Of the page that was erased most. */
    store_set_t  set;      /**< The one that is being saved, or was last. */
    store_set_t  source;   /**< Set from which the other part is copied. */
    store_part_t part;     /**< Part that is saved from `give` and `from`. */
    store_give_t give;
    const void  *from;
    uint32_t     crc[STORE_PARTS], wanted, read_back[STORE_PARTS];
    uint16_t     phase, next;
} store_t;

/** Begin again as at power-up; a save in progress is dropped, the older set stands. */
void store_reset(store_t *s);
/** Is there room for a set with so many words? */
bool store_fits(uint16_t parameter_words, uint16_t table_words);
/** Save one part. @return HAL_OK; HAL_UNSUPPORTED without room; HAL_BUSY during another save. */
hal_status_t store_begin(store_t *s, store_part_t part, uint32_t tag, uint16_t words, store_give_t give, const void *from);
/** Go on: an erase, or a few blocks. @return HAL_OK; an error has ended the save, and the older set stands. */
hal_status_t store_step(store_t *s);
/** Load one part of the newest set that has it with this tag (parameters only) and size, and reads as it was saved. @return
 *  HAL_OK; HAL_STALE: there is none, nothing was taken; HAL_SENSOR_FAULT: there is one that cannot be read, and what was taken
 *  is of no use; HAL_BUSY during a save; HAL_UNSUPPORTED. */
hal_status_t store_load(const store_t *s, store_part_t part, uint32_t tag, uint16_t words, store_take_t take, void *to);

#endif
