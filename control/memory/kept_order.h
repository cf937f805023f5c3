/**
 * @file  control/memory/kept_order.h
 * @brief Holds one order of a learned waveform and its two neighbours as they were, while learning of all others goes on.
 *
 *     a = 2 / N sum m_i cos(2 pi n i / N),  b = 2 / N sum m_i sin(2 pi n i / N)                          (1)
 *     m_i <- m_i - (a - a_0) cos(2 pi n i / N) - (b - b_0) sin(2 pi n i / N)                             (2)
 *
 * At first (1) takes a_0 and b_0 (`known`). Then, once a turn, when each cell has been learned as often as any other, (1) and (2)
 * take out again what order n has gathered, whatever it is, and so for n - 1 and n + 1: what order n stands for changes a little
 * within a turn, and that lies beside it. Other orders are orthogonal to these and stay as they are; in the middle
 * of a turn what is taken out would not be where it was learned, and would leave orders further away.
 *
 * For the main loop, beside an interrupt that writes cells, each of which is one word: a cell that it writes between the reading
 * and the writing of (2) loses this one step of learning.
 *
 * Total    every order; one that N cells cannot hold (2 n >= N), and 0, is not kept. The result stays within +-limit.
 * Cost     a call: nothing to speak of, but in three calls a turn 2 N sines and cosines with 5 products each.
 */
#ifndef CONTROL_MEMORY_KEPT_ORDER_H
#define CONTROL_MEMORY_KEPT_ORDER_H

#include "control/memory/angle_grid.h"

#define CTL_KEPT_ORDERS 3U /**< n - 1 to n + 1. */

typedef struct {
    uint16_t order;  /**< The one that is being kept; 0: none. */
    uint16_t known;  /**< `order` once a_0 and b_0 are known, else 0. */
    uint16_t last;   /**< Cell at which the interrupt was. */
    int16_t  travel; /**< Cells since the last turn. */
    uint16_t left;   /**< Orders whose turn it still is, one a call. */
    num_t    a0[CTL_KEPT_ORDERS], b0[CTL_KEPT_ORDERS];
} ctl_kept_order_t;

/** Can N cells hold it apart from others? */
static inline bool ctl_kept_order_fits(const ctl_grid_t *grid, uint16_t order)
{
    return (order > 0U) && ((2U * (uint32_t)order) < grid->cells);
}
/** Forget it. */
void ctl_kept_order_clear(ctl_kept_order_t *self);
/** CTL_KEPT_ORDERS calls until all is known. @param order to keep, another one than before begins again. @param at cell at which the
 *  interrupt is: it has moved less than half a turn since the last call. */
void ctl_kept_order_step(ctl_kept_order_t *self, const ctl_grid_t *grid, uint16_t order, uint16_t at, num_t limit);

#endif
