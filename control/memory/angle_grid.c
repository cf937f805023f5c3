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

void ctl_grid_clear(ctl_grid_t *self)
{
    for (uint16_t i = 0U; i < self->cells; i++) {
        self->cell[i] = (num_t)0;
    }
}

/* part / whole within [0, 1], both >= 0 and whole > 0, in 2^-32 cells */
static num_t ratio(int64_t part, int64_t whole)
{
#ifdef EVENSPIN_FIXED
    return (num_t)((part * INT64_C(0x1000000)) / whole); /* part is one cell at most: 2^32 2^24 fits */
#else
    return (num_t)part / (num_t)whole;
#endif
}

ctl_grid_walk_t ctl_grid_walk(const ctl_grid_t *self, angle_t from, num_t v_from, angle_t to, num_t v_to)
{
    const uint64_t start = (uint64_t)from * self->cells;
    const uint32_t inside = (uint32_t)start; /* part of a cell above the point below */
    const int32_t  turn = (int32_t)(to - from);
    const int64_t  travel = ((turn < 0) ? -(int64_t)turn : (int64_t)turn) * self->cells;
    const uint16_t below = (uint16_t)(start >> 32);

    ctl_grid_walk_t w = {below, 0U, self->cells, turn >= 0, v_from, (num_t)0};
    int64_t         first; /* way to the first point */
    if (w.up) {
        first = ONE_CELL - (int64_t)inside;
        w.index = (uint16_t)(((below + 1U) < self->cells) ? (below + 1U) : 0U);
    } else if (inside != 0U) {
        first = (int64_t)inside;
    } else {
        first = ONE_CELL;
        w.index = (uint16_t)((below > 0U) ? (below - 1U) : (self->cells - 1U));
    }
    if (travel >= first) {
        const num_t rise = num_sub(v_to, v_from);
        w.left = (uint16_t)(((travel - first) >> 32) + 1);
        w.value = num_mac(v_from, rise, ratio(first, travel));
        w.slope = (w.left > 1U) ? num_mul(rise, ratio(ONE_CELL, travel)) : (num_t)0;
    }
    return w;
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

num_t ctl_grid_read_cubic(const ctl_grid_t *self, angle_t angle)
{
    const ctl_grid_spot_t spot = ctl_grid_spot(self, angle);
    uint16_t              i = (uint16_t)((spot.below > 0U) ? (spot.below - 1U) : (self->cells - 1U));
    num_t                 a[CTL_LAGRANGE_TAPS];
    num_t                 sum = (num_t)0;

    ctl_lagrange(3U, num_add(NUM_C(1.0f), angle_to_turns(spot.inside)), a);
    for (uint16_t k = 0U; k < CTL_LAGRANGE_TAPS; k++) {
        sum = num_mac(sum, a[k], self->cell[i]);
        i = ctl_grid_next(self, i);
    }
    return sum;
}
