#include "control/memory/kept_order.h"

void ctl_kept_order_clear(ctl_kept_order_t *self)
{
    static const ctl_kept_order_t NONE = {0};
    *self = NONE;
}

/* n / N turns; over all cells the rounding adds up to N / 2^33 turns. */
static angle_t angle_per_cell(const ctl_grid_t *grid, uint16_t order) { return (angle_t)(((uint64_t)order << 32) / grid->cells); }

/* Equation (1). */
static void measure(const ctl_grid_t *grid, uint16_t order, num_t *a, num_t *b)
{
    const num_t   share = num_div(NUM_C(2.0f), num_from_int((int16_t)grid->cells));
    const angle_t each = angle_per_cell(grid, order);
    angle_t       angle = 0U;
    *a = (num_t)0;
    *b = (num_t)0;
    for (uint16_t i = 0U; i < grid->cells; i++) {
        num_t sine, cosine;
        angle_sincos(angle, &sine, &cosine);
        const num_t m = num_mul(share, grid->cell[i]);
        *a = num_mac(*a, m, cosine);
        *b = num_mac(*b, m, sine);
        angle += each;
    }
}

/* Equation (2). */
static void take_out(const ctl_grid_t *grid, uint16_t order, num_t a, num_t b, num_t limit)
{
    const angle_t each = angle_per_cell(grid, order);
    angle_t       angle = 0U;
    for (uint16_t i = 0U; i < grid->cells; i++) {
        num_t sine, cosine;
        angle_sincos(angle, &sine, &cosine);
        const num_t gathered = num_mac(num_mul(a, cosine), b, sine);
        grid->cell[i] = num_clamp(num_sub(grid->cell[i], gathered), num_neg(limit), limit);
        angle += each;
    }
}

/* Cells from one to another, the shorter way round. */
static int16_t cells_between(const ctl_grid_t *grid, uint16_t from, uint16_t to)
{
    const int16_t cells = (int16_t)grid->cells;
    const int16_t moved = (int16_t)((int16_t)to - (int16_t)from);
    if (moved > (cells / 2)) {
        return (int16_t)(moved - cells);
    }
    return (moved < -(cells / 2)) ? (int16_t)(moved + cells) : moved;
}

void ctl_kept_order_step(ctl_kept_order_t *self, const ctl_grid_t *grid, uint16_t order, uint16_t at, num_t limit)
{
    if (!ctl_kept_order_fits(grid, order)) {
        ctl_kept_order_clear(self);
        return;
    }
    if (order != self->order) {
        ctl_kept_order_clear(self);
        self->order = order;
        measure(grid, order, &self->a0, &self->b0);
        self->last = at;
        self->known = order;
        return;
    }
    self->travel = (int16_t)(self->travel + cells_between(grid, self->last, at));
    self->last = at;
    const int16_t cells = (int16_t)grid->cells;
    if ((self->travel >= cells) || (self->travel <= -cells)) {
        num_t a, b;
        self->travel = (int16_t)((self->travel > 0) ? (self->travel - cells) : (self->travel + cells));
        measure(grid, order, &a, &b);
        take_out(grid, order, num_sub(a, self->a0), num_sub(b, self->b0), limit);
    }
}
