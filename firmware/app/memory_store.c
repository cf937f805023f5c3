/* What the angle observer has learned, over a power cycle. Main loop only.
 *
 * Storage holds two slots. A save goes to the one that is not the newest: erase, data, header but for its first word; then all of
 * it is read back; then the first word makes the slot exist, and is read back, too. The check sum covers everything. So a power
 * failure leaves the older save, and so does a cell that does not keep what was written. A restore reads every word once, into
 * room that the observer does not use, and takes what it has checked. */
#include <stddef.h>

#include "firmware/app/internal.h"
#include "firmware/app/storage_map.h"
#include "hal/hal_storage.h"

#define SLOTS 2U
#define HEADER_WORDS 4U /* magic, sequence, cells, check sum */
#define MAGIC UINT16_C(0xA201)
#define ATTEMPTS 3U
#define WORDS_PER_STEP 16U

static bool is_idle(const drive_t *d)
{
    return (d->state == DRIVE_READY) || (d->state == DRIVE_FAULT) || (d->state == DRIVE_INIT);
}

static uint16_t pages_per_slot(void)
{
    const uint16_t pages = hal_storage_pages();
    return (pages > STORAGE_PARAMETER_PAGES) ? (uint16_t)((pages - STORAGE_PARAMETER_PAGES) / SLOTS) : 0U;
}

static bool table_fits(const drive_t *d)
{
    const uint32_t room = (uint32_t)pages_per_slot() * hal_storage_page_words();
    return room >= (HEADER_WORDS + (2U * (uint32_t)d->setup->observer.capacity));
}

/* CRC-16/CCITT-FALSE over words, high octet first. */
static uint16_t crc_word(uint16_t crc, uint16_t word)
{
    uint16_t c = (uint16_t)(crc ^ word);
    for (uint16_t bit = 0U; bit < 16U; bit++) {
        c = (uint16_t)(((c & 0x8000U) != 0U) ? (((uint32_t)c << 1) ^ 0x1021U) : ((uint32_t)c << 1));
    }
    return c;
}

static hal_status_t at(uint16_t slot, uint16_t index, uint16_t *page, uint16_t *offset)
{
    const uint16_t words = hal_storage_page_words();
    if (words == 0U) {
        return HAL_UNSUPPORTED;
    }
    const uint16_t in_slot = (uint16_t)(index / words);
    *page = (uint16_t)((slot * pages_per_slot()) + in_slot);
    *offset = (uint16_t)(index - (in_slot * words));
    return (in_slot < pages_per_slot()) ? HAL_OK : HAL_UNSUPPORTED;
}

static hal_status_t read_word(uint16_t slot, uint16_t index, uint16_t *word)
{
    uint16_t           page = 0U;
    uint16_t           offset = 0U;
    const hal_status_t s = at(slot, index, &page, &offset);
    return (s == HAL_OK) ? hal_storage_read(page, offset, word, 1U) : s;
}

static hal_status_t write_word(uint16_t slot, uint16_t index, uint16_t word)
{
    uint16_t           page = 0U;
    uint16_t           offset = 0U;
    const hal_status_t s = at(slot, index, &page, &offset);
    return (s == HAL_OK) ? hal_storage_write(page, offset, &word, 1U) : s;
}

/* One value as two words: ampere times 2^16, which does not depend on the numeric of the build. */
static int32_t pack(float amps) { return (int32_t)((amps * 65536.0f) + ((amps < 0.0f) ? -0.5f : 0.5f)); }

typedef struct {
    uint16_t word[HEADER_WORDS];
} header_t;

static hal_status_t read_header(const drive_t *d, uint16_t slot, header_t *h)
{
    for (uint16_t i = 0U; i < HEADER_WORDS; i++) {
        const hal_status_t s = read_word(slot, i, &h->word[i]);
        if (s != HAL_OK) {
            return s;
        }
    }
    return ((h->word[0] == MAGIC) && (h->word[2] == d->setup->observer.capacity)) ? HAL_OK : HAL_STALE;
}

static num_t value_of(const drive_t *d, uint16_t high, uint16_t low)
{
    const int32_t value = (int32_t)(((uint32_t)high << 16) | low);
    const num_t   x = num_from_float(((float)value / 65536.0f) * d->scale.inv_current);
    return num_clamp(x, num_neg(d->setup->observer.observer.memory.limit), d->setup->observer.observer.memory.limit);
}

/* The values behind a header, each word read once, into @p to if anybody wants them. @return HAL_OK; HAL_STALE: not what was
 * saved; or an error of the storage. */
static hal_status_t read_values(const drive_t *d, uint16_t slot, const header_t *h, num_t *to)
{
    uint16_t crc = crc_word(crc_word(UINT16_MAX, h->word[1]), h->word[2]);
    for (uint16_t i = 0U; i < h->word[2]; i++) {
        uint16_t word[2] = {0U, 0U};
        for (uint16_t k = 0U; k < 2U; k++) {
            const hal_status_t s = read_word(slot, (uint16_t)(HEADER_WORDS + (2U * i) + k), &word[k]);
            if (s != HAL_OK) {
                return s;
            }
            crc = crc_word(crc, word[k]);
        }
        if (to != NULL) {
            to[i] = value_of(d, word[0], word[1]);
        }
    }
    return (crc == h->word[3]) ? HAL_OK : HAL_STALE;
}

/* The newest table that reads as it was saved: its slot, sequence and values. @return HAL_OK; HAL_STALE: there is none; or an
 * error of the storage. */
static hal_status_t read_newest(const drive_t *d, uint16_t *found, uint16_t *sequence, num_t *to)
{
    header_t           h[SLOTS];
    const hal_status_t there[SLOTS] = {read_header(d, 0U, &h[0]), read_header(d, 1U, &h[1])};
    const bool   second = (there[1] == HAL_OK) && ((there[0] != HAL_OK) || ((uint16_t)(h[1].word[1] - h[0].word[1]) < 0x8000U));
    hal_status_t worst = HAL_STALE;
    for (uint16_t k = 0U; k < SLOTS; k++) {
        const uint16_t slot = (second ? 1U : 0U) ^ k;
        hal_status_t   s = there[slot];
        for (uint16_t attempt = 0U; (there[slot] == HAL_OK) && (attempt < ATTEMPTS); attempt++) {
            s = read_values(d, slot, &h[slot], to);
            if (s == HAL_OK) {
                *found = slot;
                *sequence = h[slot].word[1];
                return HAL_OK;
            }
        }
        worst = (s != HAL_STALE) ? s : worst;
    }
    return worst;
}

/* ---- save, in steps ----------------------------------------------------------------------------------------------------- */

hal_status_t drive_memory_save_begin(drive_t *d)
{
    drive_saving_t *const w = &d->saving;
    if (drive_memory_cells(d) == 0U) {
        return HAL_UNSUPPORTED;
    }
    if (!is_idle(d) || w->active) {
        return HAL_BUSY;
    }
    if (!table_fits(d)) {
        return HAL_UNSUPPORTED; /* nothing is erased for it */
    }
    uint16_t last = SLOTS;
    uint16_t sequence = 0U;
    (void)read_newest(d, &last, &sequence, NULL);
    w->cells = drive_memory_cells(d);
    w->slot = (last == 0U) ? 1U : 0U;
    w->sequence = (uint16_t)(sequence + 1U);
    w->crc = crc_word(crc_word(UINT16_MAX, w->sequence), w->cells);
    w->erased = 0U;
    w->next = 0U;
    w->active = true;
    return HAL_OK;
}

/* The word at an index of the slot; the check sum has to be that of all values when it is asked for. */
static uint16_t word_at(const drive_t *d, uint16_t index)
{
    const drive_saving_t *const w = &d->saving;
    const uint16_t              header[HEADER_WORDS] = {MAGIC, w->sequence, w->cells, w->crc};
    if (index < HEADER_WORDS) {
        return header[index];
    }
    const uint16_t at_value = (uint16_t)(index - HEADER_WORDS);
    const uint32_t value = (uint32_t)pack(drive_memory_cell(d, (uint16_t)(at_value >> 1)));
    return ((at_value & 1U) == 0U) ? (uint16_t)(value >> 16) : (uint16_t)(value & 0xFFFFU);
}

/* One word: values upwards, header downwards but for its first word; the same again, read back; the first word, and read back. */
static hal_status_t do_word(drive_t *d)
{
    drive_saving_t *const w = &d->saving;
    const uint16_t        values = (uint16_t)(2U * w->cells);
    const uint16_t        body = (uint16_t)(values + (HEADER_WORDS - 1U));
    const bool            writes = (w->next < body) || (w->next == (uint16_t)(2U * body));
    const uint16_t n = (w->next < body) ? w->next : ((w->next < (uint16_t)(2U * body)) ? (uint16_t)(w->next - body) : body);
    const uint16_t index = (n < values) ? (uint16_t)(HEADER_WORDS + n) : (uint16_t)((body - n));
    const uint16_t word = word_at(d, index);
    w->next++;
    if (writes) {
        w->crc = (index >= HEADER_WORDS) ? crc_word(w->crc, word) : w->crc;
        return write_word(w->slot, index, word);
    }
    uint16_t           found = 0U;
    const hal_status_t s = read_word(w->slot, index, &found);
    return ((s == HAL_OK) && (found != word)) ? HAL_SENSOR_FAULT : s;
}

hal_status_t drive_memory_save_step(drive_t *d)
{
    drive_saving_t *const w = &d->saving;
    hal_status_t          s = HAL_OK;
    if (!w->active) {
        return HAL_OK;
    }
    const uint16_t all = (uint16_t)(2U * ((2U * w->cells) + HEADER_WORDS));
    if (!is_idle(d) || (drive_memory_cells(d) != w->cells)) {
        s = HAL_BUSY; /* the table is no longer what it was when the save began */
    } else if (w->erased < pages_per_slot()) {
        s = hal_storage_erase((uint16_t)((w->slot * pages_per_slot()) + w->erased));
        w->erased++;
    } else {
        for (uint16_t k = 0U; (k < WORDS_PER_STEP) && (w->next < all) && (s == HAL_OK); k++) {
            s = do_word(d);
        }
    }
    w->active = (s == HAL_OK) && (w->next < all);
    return s;
}

hal_status_t drive_memory_save(drive_t *d)
{
    hal_status_t s = drive_memory_save_begin(d);
    while ((s == HAL_OK) && d->saving.active) {
        s = drive_memory_save_step(d);
    }
    return s;
}

/* ---- restore ---------------------------------------------------------------------------------------------------------------- */

hal_status_t drive_memory_restore(drive_t *d)
{
    const uint16_t cells = drive_memory_cells(d);
    if (cells == 0U) {
        return HAL_UNSUPPORTED;
    }
    if (!is_idle(d) || d->saving.active) {
        return HAL_BUSY;
    }
    if (!table_fits(d)) {
        return HAL_UNSUPPORTED;
    }
    ctl_grid_t *const  grid = &d->observer.observer.state.memory.state.grid;
    num_t *const       aside = &d->observer_memory[DRIVE_OBSERVER_CAPACITY / 2U]; /* the table has at most 2048 cells */
    uint16_t           slot = SLOTS;
    uint16_t           sequence = 0U;
    const hal_status_t s = read_newest(d, &slot, &sequence, aside);
    for (uint16_t i = 0U; (i < cells) && (s == HAL_OK); i++) {
        grid->cell[i] = aside[i];
    }
    return s;
}
