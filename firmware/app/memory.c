/* What the angle observer has learned: read, replace, forget, keep over a power cycle. Main loop only.
 *
 * Storage holds two slots. A save goes to the older one: erase, data, and last the header, whose check sum covers
 * everything; a slot without a good header does not exist. So a power failure leaves the older save. */
#include "firmware/app/internal.h"
#include "firmware/app/storage_map.h"
#include "hal/hal_storage.h"

#define SLOTS 2U
#define HEADER_WORDS 4U /* magic, sequence, cells, check sum */
#define MAGIC UINT16_C(0xA201)

static bool has_table(const drive_t *d) { return d->setup.observer_used && (d->setup.observer.kind == CTL_OBSERVER_ARO); }
static bool is_idle(const drive_t *d) { return (d->state == DRIVE_READY) || (d->state == DRIVE_FAULT) || (d->state == DRIVE_INIT); }

uint16_t drive_memory_cells(const drive_t *d) { return has_table(d) ? d->observer.observer.state.memory.state.grid.cells : (uint16_t)0U; }

float drive_memory_cell(const drive_t *d, uint16_t cell)
{
    const ctl_grid_t *const grid = &d->observer.observer.state.memory.state.grid;
    return (cell < drive_memory_cells(d)) ? (num_to_float(grid->cell[cell]) * d->scale.current_a) : 0.0f;
}

uint16_t drive_memory_read(const drive_t *d, float *amps, uint16_t room)
{
    const uint16_t cells = drive_memory_cells(d);
    const uint16_t n = (cells < room) ? cells : room;
    for (uint16_t i = 0U; i < n; i++) {
        amps[i] = drive_memory_cell(d, i);
    }
    return n;
}

bool drive_memory_write(drive_t *d, const float *amps, uint16_t cells)
{
    if (!has_table(d) || !is_idle(d) || (cells != d->setup.observer_capacity)) {
        return false;
    }
    const float limit = d->params.observer_limit_a;
    for (uint16_t i = 0U; i < cells; i++) {
        if (!((amps[i] <= limit) && (amps[i] >= -limit))) {
            return false;
        }
    }
    ctl_grid_t *const grid = &d->observer.observer.state.memory.state.grid;
    for (uint16_t i = 0U; i < cells; i++) {
        grid->cell[i] = num_from_float(amps[i] * d->scale.inv_current);
    }
    return true;
}

bool drive_memory_clear(drive_t *d)
{
    if (!is_idle(d)) {
        return false;
    }
    if (d->setup.observer_used) {
        ctl_observer_reset(&d->observer.observer, false);
    }
    if (d->setup.rc_used) {
        ctl_rc_reset(&d->speed.rc);
    }
    return true;
}

/* ---- storage ------------------------------------------------------------------------------------------------------- */

static uint16_t pages_per_slot(void)
{
    const uint16_t pages = hal_storage_pages();
    return (pages > STORAGE_PARAMETER_PAGES) ? (uint16_t)((pages - STORAGE_PARAMETER_PAGES) / SLOTS) : 0U;
}

static bool table_fits(const drive_t *d)
{
    const uint32_t room = (uint32_t)pages_per_slot() * hal_storage_page_words();
    return room >= (HEADER_WORDS + (2U * (uint32_t)d->setup.observer_capacity));
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

/* Sequence of a slot with a good header and check sum, else false. */
static bool inspect(const drive_t *d, uint16_t slot, uint16_t *sequence)
{
    uint16_t header[HEADER_WORDS] = {0U, 0U, 0U, 0U};
    for (uint16_t i = 0U; i < HEADER_WORDS; i++) {
        if (read_word(slot, i, &header[i]) != HAL_OK) {
            return false;
        }
    }
    if ((header[0] != MAGIC) || (header[2] != d->setup.observer_capacity)) {
        return false;
    }
    uint16_t crc = crc_word(crc_word(UINT16_MAX, header[1]), header[2]);
    for (uint16_t i = 0U; i < (uint16_t)(2U * header[2]); i++) {
        uint16_t word = 0U;
        if (read_word(slot, (uint16_t)(HEADER_WORDS + i), &word) != HAL_OK) {
            return false;
        }
        crc = crc_word(crc, word);
    }
    *sequence = header[1];
    return crc == header[3];
}

/* Slot of the newest good save, or SLOTS. */
static uint16_t newest(const drive_t *d, uint16_t *sequence)
{
    uint16_t found = SLOTS;
    for (uint16_t slot = 0U; slot < SLOTS; slot++) {
        uint16_t s = 0U;
        if (inspect(d, slot, &s) && ((found == SLOTS) || ((uint16_t)(s - *sequence) < 0x8000U))) {
            found = slot;
            *sequence = s;
        }
    }
    return found;
}

hal_status_t drive_memory_save(drive_t *d)
{
    if (!has_table(d)) {
        return HAL_UNSUPPORTED;
    }
    if (!is_idle(d)) {
        return HAL_BUSY;
    }
    if (!table_fits(d)) {
        return HAL_UNSUPPORTED; /* nothing is erased for it */
    }
    uint16_t       sequence = 0U;
    const uint16_t last = newest(d, &sequence);
    const uint16_t slot = (last == 0U) ? 1U : 0U;
    hal_status_t   s = HAL_OK;
    for (uint16_t p = 0U; (p < pages_per_slot()) && (s == HAL_OK); p++) {
        s = hal_storage_erase((uint16_t)((slot * pages_per_slot()) + p));
    }
    const ctl_grid_t *const grid = &d->observer.observer.state.memory.state.grid;
    sequence++;
    uint16_t crc = crc_word(crc_word(UINT16_MAX, sequence), grid->cells);
    for (uint16_t i = 0U; (i < grid->cells) && (s == HAL_OK); i++) {
        const uint32_t value = (uint32_t)pack(num_to_float(grid->cell[i]) * d->scale.current_a);
        const uint16_t word[2] = {(uint16_t)(value >> 16), (uint16_t)(value & 0xFFFFU)};
        for (uint16_t k = 0U; (k < 2U) && (s == HAL_OK); k++) {
            s = write_word(slot, (uint16_t)(HEADER_WORDS + (2U * i) + k), word[k]);
            crc = crc_word(crc, word[k]);
        }
    }
    const uint16_t header[HEADER_WORDS] = {MAGIC, sequence, grid->cells, crc};
    for (uint16_t i = HEADER_WORDS; (i > 0U) && (s == HAL_OK); i--) { /* the magic word last */
        s = write_word(slot, (uint16_t)(i - 1U), header[i - 1U]);
    }
    return s;
}

hal_status_t drive_memory_restore(drive_t *d)
{
    if (!has_table(d)) {
        return HAL_UNSUPPORTED;
    }
    if (!is_idle(d)) {
        return HAL_BUSY;
    }
    if (!table_fits(d)) {
        return HAL_UNSUPPORTED;
    }
    uint16_t       sequence = 0U;
    const uint16_t slot = newest(d, &sequence);
    if (slot == SLOTS) {
        return HAL_STALE; /* nothing was ever saved for this number of cells */
    }
    ctl_grid_t *const grid = &d->observer.observer.state.memory.state.grid;
    const num_t       limit = d->setup.observer.memory.limit;
    for (uint16_t i = 0U; i < grid->cells; i++) {
        uint16_t           high = 0U;
        uint16_t           low = 0U;
        const hal_status_t a = read_word(slot, (uint16_t)(HEADER_WORDS + (2U * i)), &high);
        const hal_status_t b = read_word(slot, (uint16_t)(HEADER_WORDS + (2U * i) + 1U), &low);
        if ((a != HAL_OK) || (b != HAL_OK)) { /* it could be read a moment ago; better nothing than half of each */
            ctl_observer_reset(&d->observer.observer, false);
            return (a != HAL_OK) ? a : b;
        }
        const int32_t value = (int32_t)(((uint32_t)high << 16) | low);
        const num_t   x = num_from_float(((float)value / 65536.0f) * d->scale.inv_current);
        grid->cell[i] = num_clamp(x, num_neg(limit), limit);
    }
    return HAL_OK;
}
