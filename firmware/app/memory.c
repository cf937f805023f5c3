/* What has been learned over the angle: read, replace, forget. Main loop only. memory_store.c keeps it over a power cycle.
 *
 * One table after the other: of the observer (aro), of repetitive control (rc_memory = angle), of position control (silc, src, and
 * rdc with rdc_learn_gain). Each as far as the set in force has it. */
#include "firmware/app/internal.h"

static bool is_idle(const drive_t *d) { return drive_is_idle(d) && !drive_is_saving(d); }

drive_learned_t drive_learned(const drive_t *d, uint16_t part)
{
    const drive_setup_t *const    s = d->setup;
    const drive_position_t *const o = &d->position;
    drive_learned_t               t = {NULL, (num_t)0, d->scale.current_a};
    if (part == 0U) {
        t.limit = s->observer.observer.memory.limit;
        if (s->observer.used && (s->observer.observer.kind == CTL_OBSERVER_ARO)) {
            t.grid = &d->observer.observer.state.memory.state.grid;
        }
    } else if (part == 1U) {
        t.limit = s->speed.rc.limit;
        t.base = d->scale.error_unit;
        if (s->speed.rc_used && (s->speed.rc.memory == CTL_RC_ANGLE)) {
            t.grid = &d->speed.rc.state.turn;
        }
    } else if (s->position.learns) {
        t.limit = s->position.learn.limit;
        t.grid = &o->learn.state.grid;
    } else if (s->position.method != DRIVE_POSITION_RDC) {
        t.limit = s->position.ilc.limit;
        t.base = d->scale.speed_rad_s;
        if (s->position.method != DRIVE_POSITION_PPI) {
            t.grid = (s->position.method == DRIVE_POSITION_SILC) ? &o->ilc.state.grid : &o->src.state.grid;
        }
    } else {
        /* rdc that does not learn */
    }
    return t;
}

drive_learned_t drive_learned_cell(const drive_t *d, uint16_t *cell)
{
    for (uint16_t part = 0U; part < DRIVE_LEARNED_PARTS; part++) {
        const drive_learned_t t = drive_learned(d, part);
        if (t.grid != NULL) {
            if (*cell < t.grid->cells) {
                return t;
            }
            *cell = (uint16_t)(*cell - t.grid->cells);
        }
    }
    return (drive_learned_t){NULL, (num_t)0, 0.0f};
}

uint16_t drive_memory_cells(const drive_t *d)
{
    uint16_t cells = UINT16_MAX;
    (void)drive_learned_cell(d, &cells); /* takes off what there is */
    return (uint16_t)(UINT16_MAX - cells);
}

float drive_memory_cell(const drive_t *d, uint16_t cell)
{
    const drive_learned_t t = drive_learned_cell(d, &cell);
    return (t.grid != NULL) ? (num_to_float(t.grid->cell[cell]) * t.base) : 0.0f;
}

uint16_t drive_memory_read(const drive_t *d, float *values, uint16_t room)
{
    const uint16_t cells = drive_memory_cells(d);
    const uint16_t n = (cells < room) ? cells : room;
    for (uint16_t i = 0U; i < n; i++) {
        values[i] = drive_memory_cell(d, i);
    }
    return n;
}

bool drive_memory_write(drive_t *d, const float *values, uint16_t cells)
{
    if ((cells == 0U) || !is_idle(d) || (cells != drive_memory_cells(d))) {
        return false;
    }
    bool write = false; /* all of them are judged before the first is written */
    do {
        for (uint16_t i = 0U; i < cells; i++) {
            uint16_t              at = i;
            const drive_learned_t t = drive_learned_cell(d, &at);
            const float           most = num_to_float(t.limit) * t.base * 1.000001f; /* rounded on the way */
            if (!((values[i] <= most) && (values[i] >= -most))) {
                return false;
            }
            if (write) {
                t.grid->cell[at] = num_clamp(num_from_float(values[i] / t.base), num_neg(t.limit), t.limit);
            }
        }
        write = !write;
    } while (write);
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
        ctl_rc_reset(&d->speed.rc, false);
    }
    const drive_learned_t t = drive_learned(d, DRIVE_LEARNED_PARTS - 1U);
    if (t.grid != NULL) {
        ctl_grid_clear(t.grid);
    }
    return true;
}
