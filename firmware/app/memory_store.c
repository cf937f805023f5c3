/* What the angle observer has learned, over a power cycle: the part STORE_TABLE of the store. Main loop only. A restore reads
 * every word once, into room that the observer does not use, and takes what has been checked. */
#include "firmware/app/internal.h"

static bool is_idle(const drive_t *d)
{
    return (d->state == DRIVE_READY) || (d->state == DRIVE_FAULT) || (d->state == DRIVE_INIT);
}

/* One value as two words, the high one first: ampere times 2^16, which does not depend on the numeric of the build. */
static int32_t pack(float amps) { return (int32_t)((amps * 65536.0f) + ((amps < 0.0f) ? -0.5f : 0.5f)); }

static uint16_t table_word(const void *from, uint16_t i)
{
    const uint32_t value = (uint32_t)pack(drive_memory_cell((const drive_t *)from, i >> 1));
    return ((i & 1U) == 0U) ? (uint16_t)(value >> 16) : (uint16_t)(value & 0xFFFFU);
}

static num_t value_of(const drive_t *d, uint16_t high, uint16_t low)
{
    const int32_t value = (int32_t)(((uint32_t)high << 16) | low);
    const num_t   x = num_from_float(((float)value / 65536.0f) * d->scale.inv_current);
    return num_clamp(x, num_neg(d->setup->observer.observer.memory.limit), d->setup->observer.observer.memory.limit);
}

hal_status_t drive_memory_save_begin(drive_t *d)
{
    const uint16_t cells = drive_memory_cells(d);
    if (cells == 0U) {
        return HAL_UNSUPPORTED;
    }
    if (!is_idle(d) || d->storage.active) {
        return HAL_BUSY;
    }
    d->saved_cells = cells;
    return store_begin(&d->storage, STORE_TABLE, 0U, (uint16_t)(2U * cells), table_word, d);
}

hal_status_t drive_memory_save_step(drive_t *d)
{
    if (!d->storage.active) {
        return HAL_OK;
    }
    if ((d->storage.part == STORE_TABLE) && (!is_idle(d) || (drive_memory_cells(d) != d->saved_cells))) {
        store_reset(&d->storage); /* the table is no longer what it was when the save began */
        return HAL_BUSY;
    }
    return store_step(&d->storage);
}

hal_status_t drive_memory_save(drive_t *d)
{
    hal_status_t s = drive_memory_save_begin(d);
    while ((s == HAL_OK) && d->storage.active) {
        s = drive_memory_save_step(d);
    }
    return s;
}

typedef struct {
    drive_t *drive;
    num_t   *staged;
    uint16_t high;
} loading_t;

static void take_cell(void *to, uint16_t i, uint16_t word)
{
    loading_t *const l = (loading_t *)to;
    if ((i & 1U) == 0U) {
        l->high = word;
    } else {
        l->staged[i >> 1] = value_of(l->drive, l->high, word);
    }
}

hal_status_t drive_memory_restore(drive_t *d)
{
    const uint16_t cells = drive_memory_cells(d);
    if (cells == 0U) {
        return HAL_UNSUPPORTED;
    }
    if (!is_idle(d)) {
        return HAL_BUSY;
    }
    ctl_grid_t *const  grid = &d->observer.observer.state.memory.state.grid;
    loading_t          loading = {d, &d->observer_memory[DRIVE_OBSERVER_CAPACITY - cells],
                                  0U}; /* a third of it at most, as the position loop */
    const hal_status_t s = store_load(&d->storage, STORE_TABLE, 0U, (uint16_t)(2U * cells), take_cell, &loading);
    for (uint16_t i = 0U; (i < cells) && (s == HAL_OK); i++) {
        grid->cell[i] = loading.staged[i];
    }
    return s;
}
