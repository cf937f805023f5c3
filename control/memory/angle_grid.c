#include "control/memory/angle_grid.h"

#include "control/numeric/lagrange.h"

#define ONE_CELL INT64_C(0x100000000) /* positions count 2^-32 of a cell */

ctl_diag_t ctl_grid_init(ctl_grid_t *self, num_t *memory, uint16_t cells)
{
    if (self == NULL) {
        return ctl_diag(CTL_ERR_NULL, 0U, (num_t)0);
    }
    if (memory == NULL) {
        return ctl_diag(CTL_ERR_NULL, CTL_GRID_MEMORY, (num_t)0);
    }
    if ((cells < 4U) || (cells > 4096U)) {
        return ctl_diag_count(CTL_ERR_MEMORY, CTL_GRID_CELLS, cells);
    }
    self->cell = memory;
    self->cells = cells;
    self->cells_real = (float)cells;
    ctl_grid_clear(self);
    return ctl_diag_ok();
}

void ctl_grid_clear(const ctl_grid_t *self)
{
    for (uint16_t i = 0U; i < self->cells; i++) {
        self->cell[i] = (num_t)0;
    }
}

/* What the two functions below share; inline, since the current and the speed interrupt run it once a sample. */
static inline void begin_walk(const ctl_grid_t *self, angle_t from, num_t v_from, angle_t to, num_t v_to, ctl_grid_walk_t *w)
{
    const uint64_t start = (uint64_t)from * self->cells;
    const uint32_t inside = (uint32_t)start; /* part of a cell above the point below */
    const int32_t  turn = (int32_t)(to - from);
    const uint32_t travel = angle_size(to - from);
    const uint64_t travel_cells = (uint64_t)travel * self->cells;
    const uint16_t below = (uint16_t)(start >> 32);

    uint32_t before; /* the travel to the first point less 2^-32 cells: it lies within [1, 2^32] */
    w->index = below;
    w->left = 0U;
    w->cells = self->cells;
    w->up = turn >= 0;
    w->value = v_from;
    w->slope = (num_t)0;
    if (w->up) {
        before = UINT32_MAX - inside;
        w->index = (uint16_t)(((below + 1U) < self->cells) ? (below + 1U) : 0U);
    } else {
        before = inside - 1U; /* from a point on: a whole cell to the next one */
        if (inside == 0U) {
            w->index = (uint16_t)((below > 0U) ? (below - 1U) : (self->cells - 1U));
        }
    }
    if (travel_cells > before) {
        const num_t rise = num_sub(v_to, v_from);
        w->left = (uint16_t)(((travel_cells - before - 1U) >> 32) + 1U);
#ifdef EVENSPIN_FIXED
        w->value = num_mac(v_from, rise, (num_t)(((int64_t)before + 1) * INT64_C(0x1000000) / (int64_t)travel_cells));
        w->slope = (w->left > 1U) ? num_mul(rise, (num_t)((ONE_CELL * INT64_C(0x1000000)) / (int64_t)travel_cells)) : (num_t)0;
#else
        const float per_part = 1.0f / ((float)travel * self->cells_real); /* parts of 2^-32 cells; travel > 0 here */
        w->value = num_mac(v_from, rise, ((float)before + 1.0f) * per_part);
        w->slope = rise * (4294967296.0f * per_part); /* not used where it is steep: then one point is all */
#endif
    }
}

ctl_grid_walk_t ctl_grid_walk(const ctl_grid_t *self, angle_t from, num_t v_from, angle_t to, num_t v_to)
{
    ctl_grid_walk_t w;
    begin_walk(self, from, v_from, to, v_to, &w);
    return w;
}

/* `count` cells from @p at on upwards; four at a time, since the end of the loop costs more than a cell. @return the next value. */
static inline num_t write_up(num_t *at, uint16_t count, num_t value, num_t slope)
{
    num_t v = value;
    for (uint16_t fours = (uint16_t)(count >> 2); fours > 0U; fours--) {
        at[0] = v;
        v = num_add(v, slope);
        at[1] = v;
        v = num_add(v, slope);
        at[2] = v;
        v = num_add(v, slope);
        at[3] = v;
        v = num_add(v, slope);
        at += 4;
    }
    for (uint16_t left = (uint16_t)(count & 3U); left > 0U; left--) {
        *at = v;
        v = num_add(v, slope);
        at++;
    }
    return v;
}

/* The same downwards: the first cell lies before @p at. */
static inline num_t write_down(num_t *end, uint16_t count, num_t value, num_t slope)
{
    num_t *at = end;
    num_t  v = value;
    for (uint16_t fours = (uint16_t)(count >> 2); fours > 0U; fours--) {
        at -= 4;
        at[3] = v;
        v = num_add(v, slope);
        at[2] = v;
        v = num_add(v, slope);
        at[1] = v;
        v = num_add(v, slope);
        at[0] = v;
        v = num_add(v, slope);
    }
    for (uint16_t left = (uint16_t)(count & 3U); left > 0U; left--) {
        at--;
        *at = v;
        v = num_add(v, slope);
    }
    return v;
}

void ctl_grid_write(const ctl_grid_t *self, angle_t from, num_t v_from, angle_t to, num_t v_to)
{
    ctl_grid_walk_t w;
    begin_walk(self, from, v_from, to, v_to, &w);
    const uint16_t room = w.up ? (uint16_t)(self->cells - w.index) : (uint16_t)(w.index + 1U); /* before the end */
    const uint16_t first = (w.left < room) ? w.left : room;
    if (w.up) {
        const num_t v = write_up(&self->cell[w.index], first, w.value, w.slope);
        if (first < w.left) {
            (void)write_up(self->cell, (uint16_t)(w.left - first), v, w.slope);
        }
    } else {
        const num_t v = write_down(&self->cell[room], first, w.value, w.slope);
        if (first < w.left) {
            (void)write_down(&self->cell[self->cells], (uint16_t)(w.left - first), v, w.slope);
        }
    }
}

bool ctl_grid_walk_next(ctl_grid_walk_t *walk, uint16_t *index, num_t *value)
{
    if (walk->left == 0U) {
        return false;
    }
    *index = walk->index;
    *value = walk->value;
    walk->left--;
    walk->value = num_add(walk->value, walk->slope);
    if (walk->up) {
        walk->index = (uint16_t)(((walk->index + 1U) < walk->cells) ? (walk->index + 1U) : 0U);
    } else {
        walk->index = (uint16_t)((walk->index > 0U) ? (walk->index - 1U) : (walk->cells - 1U));
    }
    return true;
}

#ifdef EVENSPIN_FIXED
num_t ctl_grid_read_cubic(const ctl_grid_t *self, angle_t angle)
{
    const ctl_grid_position_t position = ctl_grid_position(self, angle);
    uint16_t                  i = (uint16_t)((position.below > 0U) ? (position.below - 1U) : (self->cells - 1U));
    num_t                     a[CTL_LAGRANGE_TAPS];
    num_t                     sum = (num_t)0;

    ctl_lagrange(3U, num_add(NUM_C(1.0f), angle_to_turns(position.inside)), a);
    for (uint16_t k = 0U; k < CTL_LAGRANGE_TAPS; k++) {
        sum = num_mac(sum, a[k], self->cell[i]);
        i = ctl_grid_next(self, i);
    }
    return sum;
}
#else
num_t ctl_grid_read_cubic(const ctl_grid_t *self, angle_t angle) { return ctl_grid_read_cubic_raw(self, angle); }
#endif
