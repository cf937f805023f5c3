/* What has been learned over the angle, over a power cycle: the part STORE_TABLE of the store. Main loop only. A restore reads
 * every word once, into room that nobody uses, and takes what has been checked. The first value says which tables it is of. */
#include "firmware/app/internal.h"

static bool is_idle(const drive_t *d)
{
    return (d->state == DRIVE_READY) || (d->state == DRIVE_FAULT) || (d->state == DRIVE_INIT);
}

/* One value as two words, the high one first: times 2^16, cut to what 32 bits hold, which does not depend on the numeric of the build. */
static int32_t pack(float x)
{
    const float cut = (x < 32000.0f) ? ((x > -32000.0f) ? x : -32000.0f) : 32000.0f;
    return (int32_t)((cut * 65536.0f) + ((cut < 0.0f) ? -0.5f : 0.5f));
}

/* Of which methods and sizes the tables are. */
static uint32_t layout(const drive_t *d)
{
    uint32_t sum = 0U;
    for (uint16_t part = 0U; part < DRIVE_LEARNED_PARTS; part++) {
        const ctl_grid_t *const grid = drive_learned(d, part).grid;
        const uint16_t          method = (part < 2U) ? part : (uint16_t)(1U + (uint16_t)d->setup->position.method);
        sum = (grid != NULL) ? ((sum * UINT32_C(65521)) + ((uint32_t)method << 12) + grid->cells) : sum;
    }
    return sum;
}

static uint16_t table_word(const void *from, uint16_t i)
{
    const drive_t *const d = (const drive_t *)from;
    const uint32_t       value = (i < 2U) ? layout(d) : (uint32_t)pack(drive_memory_cell(d, (uint16_t)((i >> 1) - 1U)));
    return ((i & 1U) == 0U) ? (uint16_t)(value >> 16) : (uint16_t)(value & 0xFFFFU);
}

static num_t value_of(const drive_learned_t *t, uint32_t value)
{
    const num_t x = num_from_float((float)(int32_t)value / (65536.0f * t->base));
    return num_clamp(x, num_neg(t->limit), t->limit);
}

/* Room from there on is used: by the ring of ro, or by the tables. */
static uint16_t used_room(const drive_t *d)
{
    const drive_setup_t *const s = d->setup;
    const uint16_t observer = (s->observer.used && (s->observer.observer.kind != CTL_OBSERVER_DOB)) ? s->observer.capacity : 0U;
    return (uint16_t)(observer + ((s->position.method != DRIVE_POSITION_PPI) ? (2U * s->position.cells) : 0U));
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
    return store_begin(&d->storage, STORE_TABLE, 0U, (uint16_t)(2U * (cells + 1U)), table_word, d);
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
    bool     fits; /**< The tables are those that were saved. */
} loading_t;

static void take_cell(void *to, uint16_t i, uint16_t word)
{
    loading_t *const l = (loading_t *)to;
    if ((i & 1U) == 0U) {
        l->high = word;
    } else {
        const uint32_t value = ((uint32_t)l->high << 16) | word;
        if (i < 2U) {
            l->fits = value == layout(l->drive);
        } else {
            uint16_t              cell = (uint16_t)((i >> 1) - 1U);
            num_t *const          to_cell = &l->staged[cell];
            const drive_learned_t t = drive_learned_cell(l->drive, &cell);
            *to_cell = value_of(&t, value);
        }
    }
}

hal_status_t drive_memory_restore(drive_t *d)
{
    const uint16_t cells = drive_memory_cells(d);
    if ((cells == 0U) || (((uint32_t)used_room(d) + cells) > DRIVE_OBSERVER_CAPACITY)) {
        return HAL_UNSUPPORTED;
    }
    if (!is_idle(d)) {
        return HAL_BUSY;
    }
    loading_t          loading = {d, &d->observer_memory[DRIVE_OBSERVER_CAPACITY - cells], 0U, false};
    const hal_status_t s = store_load(&d->storage, STORE_TABLE, 0U, (uint16_t)(2U * (cells + 1U)), take_cell, &loading);
    if ((s == HAL_OK) && !loading.fits) {
        return HAL_STALE; /* as many values, but of other tables */
    }
    for (uint16_t i = 0U; (i < cells) && (s == HAL_OK); i++) {
        uint16_t              at = i;
        const drive_learned_t t = drive_learned_cell(d, &at);
        t.grid->cell[at] = loading.staged[i];
    }
    return s;
}
