#include "control/memory/kept_order.h"

void ctl_kept_order_clear(ctl_kept_order_t *self)
{
    static const ctl_kept_order_t NONE = {0};
    *self = NONE;
}

/* n / N turns; over all cells the rounding adds up to N / 2^33 turns. */
static angle_t angle_per_cell(const ctl_grid_t *grid, uint16_t order) { return (angle_t)(((uint64_t)order << 32) / grid->cells); }

/* (2) with a and b in the place of the differences, then (1) of what is left: 0 and 0 only measure. */
static void take_out(const ctl_grid_t *grid, uint16_t order, num_t *a, num_t *b, num_t limit)
{
    const num_t   part = angle_to_turns(UINT32_MAX / grid->cells); /* 1 / N; N itself may be beyond what fixed point holds */
    const num_t   share = num_add(part, part);
    const angle_t each = angle_per_cell(grid, order);
    const num_t   by_cosine = *a;
    const num_t   by_sine = *b;
    angle_t       angle = 0U;
    *a = (num_t)0;
    *b = (num_t)0;
    for (uint16_t i = 0U; i < grid->cells; i++) {
        num_t sine, cosine;
        angle_sincos(angle, &sine, &cosine);
        const num_t gathered = num_mac(num_mul(by_cosine, cosine), by_sine, sine);
        const num_t left = num_clamp(num_sub(grid->cell[i], gathered), num_neg(limit), limit);
        const num_t m = num_mul(share, left);
        grid->cell[i] = left;
        *a = num_mac(*a, m, cosine);
        *b = num_mac(*b, m, sine);
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

/* One of the orders: take its size, or take out what has been added to it. */
static void keep(ctl_kept_order_t *self, const ctl_grid_t *grid, uint16_t k, num_t limit)
{
    const uint16_t order = (uint16_t)((self->order + k) - (CTL_KEPT_ORDERS / 2U));
    num_t          a = (num_t)0;
    num_t          b = (num_t)0;
    if (ctl_kept_order_fits(grid, order)) {
        take_out(grid, order, &a, &b, limit);
        if (self->known == 0U) {
            self->a0[k] = a;
            self->b0[k] = b;
        }
        a = num_sub(a, self->a0[k]);
        b = num_sub(b, self->b0[k]);
        take_out(grid, order, &a, &b, limit);
    }
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
        self->last = at;
        self->left = CTL_KEPT_ORDERS;
    }
    const int16_t cells = (int16_t)grid->cells;
    self->travel = (int16_t)(self->travel + cells_between(grid, self->last, at));
    self->last = at;
    if ((self->travel >= cells) || (self->travel <= -cells)) {
        self->travel = (int16_t)((self->travel > 0) ? (self->travel - cells) : (self->travel + cells));
        self->left = CTL_KEPT_ORDERS;
    }
    if (self->left > 0U) {
        self->left--;
        keep(self, grid, self->left, limit);
        self->known = (self->left == 0U) ? order : self->known;
    }
}
