/**
 * @file  control/memory/angle_grid.h
 * @brief A waveform over one turn of an angle, in the caller's memory: every grid point that a motion passes is
 *        visited, with the value interpolated between the two samples; read-out at any angle.
 *
 * Cell i stands for the angle i / cells of a turn. The turn may be mechanical or electrical: the caller's choice.
 *
 * Total    every angle is valid. A step of half a turn or more cannot be told from one the other way; the shorter way
 *          is taken. Reversal and standstill need no care: a point is visited when it is reached or passed.
 * Cost     read-out: linear 2 products, cubic 15. A walk: up to 2 divisions, then 1 sum per point passed, at most
 *          cells / 2 points; never more than cells * (speed * T_s) / turn + 1.
 * Error    a visited value is off by less than 3e-7 per point since the start of the walk, for values within +-2.
 */
#ifndef CONTROL_MEMORY_ANGLE_GRID_H
#define CONTROL_MEMORY_ANGLE_GRID_H

#include "control/numeric/angle.h"
#include "control/numeric/diag.h"

typedef struct {
    num_t   *cell;       /**< `cells` values, owned by the caller. */
    uint16_t cells;      /**< Cells per turn, [4, 4096]... */
    float    cells_real; /**< ...and the same for quotients. */
} ctl_grid_t;

/** The points between two samples, in the order in which they were passed. */
typedef struct {
    uint16_t index; /**< Next point. */
    uint16_t left;  /**< Points still to visit. */
    uint16_t cells;
    bool     up;    /**< Direction of the motion. */
    num_t    value; /**< Value at the next point. */
    num_t    slope; /**< Change of the value from point to point. */
} ctl_grid_walk_t;

enum { CTL_GRID_MEMORY = 1, CTL_GRID_CELLS };

/** Take over @p memory of @p cells values, all set to zero. On error @p self stays as it was. */
ctl_diag_t ctl_grid_init(ctl_grid_t *self, num_t *memory, uint16_t cells);
void       ctl_grid_clear(ctl_grid_t *self);

/** Prepare the walk from angle @p from (already visited) to angle @p to (included), values @p v_from to @p v_to. */
ctl_grid_walk_t ctl_grid_walk(const ctl_grid_t *self, angle_t from, num_t v_from, angle_t to, num_t v_to);
/** Next point of the walk; false at its end. */
bool ctl_grid_walk_next(ctl_grid_walk_t *walk, uint16_t *index, num_t *value);

/** A place on the grid: the point below it, and the part of a cell above that point in 2^-32. */
typedef struct {
    uint32_t inside;
    uint16_t below;
} ctl_grid_spot_t;

static inline ctl_grid_spot_t ctl_grid_spot(const ctl_grid_t *self, angle_t angle)
{
    const uint64_t        position = (uint64_t)angle * self->cells;
    const ctl_grid_spot_t spot = {(uint32_t)position, (uint16_t)(position >> 32)};
    return spot;
}

/** The point after point @p i. */
static inline uint16_t ctl_grid_next(const ctl_grid_t *self, uint16_t i)
{
    return (uint16_t)(((i + 1U) < self->cells) ? (i + 1U) : 0U);
}

/** @p part 2^-32 cells over an angle of @p way > 0, where the part is not more than the way: within [0, 1]. */
static inline num_t ctl_grid_share(const ctl_grid_t *self, uint32_t part, uint32_t way)
{
#ifdef EVENSPIN_FIXED
    return (num_t)(((uint64_t)part << 24) / ((uint64_t)way * self->cells));
#else
    return (num_t)part / ((num_t)way * self->cells_real);
#endif
}

/** Value at a place, straight line between the two neighbours. */
static inline num_t ctl_grid_read_spot(const ctl_grid_t *self, ctl_grid_spot_t spot)
{
    const num_t below = self->cell[spot.below];
    return num_mac(below, num_sub(self->cell[ctl_grid_next(self, spot.below)], below), angle_to_turns(spot.inside));
}

/** Value at @p angle, straight line between the two neighbours. */
static inline num_t ctl_grid_read_linear(const ctl_grid_t *self, angle_t angle)
{
    return ctl_grid_read_spot(self, ctl_grid_spot(self, angle));
}
/** Value at @p angle, cubic through the two neighbours on either side (Lagrange). */
num_t ctl_grid_read_cubic(const ctl_grid_t *self, angle_t angle);

#endif
