/* What the angle observer has learned: read, replace, forget. Main loop only. memory_store.c keeps it over a power cycle. */
#include "firmware/app/internal.h"

static bool has_table(const drive_t *d) { return drive_memory_cells(d) > 0U; }
static bool is_idle(const drive_t *d) { return drive_is_idle(d) && !drive_is_saving(d); }

uint16_t drive_memory_cells(const drive_t *d)
{
    const bool aro = d->setup->observer.used && (d->setup->observer.observer.kind == CTL_OBSERVER_ARO);
    return aro ? d->observer.observer.state.memory.state.grid.cells : (uint16_t)0U;
}

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
    if (!has_table(d) || !is_idle(d) || (cells != d->setup->observer.capacity)) {
        return false;
    }
    const float limit = d->params->observer_limit_a;
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
    if (d->setup->observer.used) {
        ctl_observer_reset(&d->observer.observer, false);
    }
    if (d->setup->speed.rc_used) {
        ctl_rc_reset(&d->speed.rc);
    }
    return true;
}
