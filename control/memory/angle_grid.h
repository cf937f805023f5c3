/**
 * @file  control/memory/angle_grid.h
 * @brief A waveform over one turn of an angle, in the caller's memory: every grid point that a motion passes is
 *        visited, with the value interpolated between the two samples; read-out at any angle.
 *
 * Cell i stands for the angle i / cells of a turn. The turn may be mechanical or electrical: the caller's choice.
 *
 * Total    every angle is valid. A step of half a turn or more cannot be distinguished from one in the opposite direction; the shorter
 *          is taken. Reversal and standstill need no care: a point is visited when it is reached or passed.
 * Cost     read-out: linear 2 products, cubic 7 (fixed: 15). A walk: 1 division (fixed: 2), then 1 sum per point passed, at most
 *          cells / 2 points; never more than cells * (speed * T_s) / turn + 1.
 * Error    a visited value is off by less than 3e-7 per point since the start of the walk, for values within +-2.
 */
#ifndef CONTROL_MEMORY_ANGLE_GRID_H
#define CONTROL_MEMORY_ANGLE_GRID_H

#include "control/numeric/angle.h"
#include "control/numeric/diag.h"

typedef struct {
    num_t   *cell;       /**< `cells` values, owned by the caller. */
    uint16_t cells;      /**< Cells per turn, [4, 4096]. */
    float    cells_real; /**< Cells per turn as a number, for quotients. */
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
void       ctl_grid_clear(const ctl_grid_t *self);

/** Prepare the walk from angle @p from (already visited) to angle @p to (included), values @p v_from to @p v_to. */
ctl_grid_walk_t ctl_grid_walk(const ctl_grid_t *self, angle_t from, num_t v_from, angle_t to, num_t v_to);
/** The whole walk at once: every point that it passes takes the value of the line there. */
void ctl_grid_write(const ctl_grid_t *self, angle_t from, num_t v_from, angle_t to, num_t v_to);
/** Next point of the walk; false at its end. */
bool ctl_grid_walk_next(ctl_grid_walk_t *walk, uint16_t *index, num_t *value);

/** A position on the grid: the point below it, and the fraction of a cell above that point in units of 2^-32. */
typedef struct {
    uint32_t inside;
    uint16_t below;
} ctl_grid_position_t;

static inline ctl_grid_position_t ctl_grid_position(const ctl_grid_t *self, angle_t angle)
{
    const uint64_t            cells = (uint64_t)angle * self->cells; /* 32 bits of fraction */
    const ctl_grid_position_t position = {(uint32_t)cells, (uint16_t)(cells >> 32)};
    return position;
}

/** The point after point @p i. */
static inline uint16_t ctl_grid_next(const ctl_grid_t *self, uint16_t i)
{
    return (uint16_t)(((i + 1U) < self->cells) ? (i + 1U) : 0U);
}

/** Fraction of an angle @p travel > 0 that @p part, in units of 2^-32 cells and not above it, makes up: within [0, 1]. */
static inline num_t ctl_grid_share(const ctl_grid_t *self, uint32_t part, uint32_t travel)
{
#ifdef EVENSPIN_FIXED
    return (num_t)(((uint64_t)part << 24) / ((uint64_t)travel * self->cells));
#else
    return (num_t)part / ((num_t)travel * self->cells_real);
#endif
}

/** Value at a position, straight line between the two neighbours. */
static inline num_t ctl_grid_read_at(const ctl_grid_t *self, ctl_grid_position_t position)
{
    const num_t below = self->cell[position.below];
    return num_mac(below, num_sub(self->cell[ctl_grid_next(self, position.below)], below), angle_to_turns(position.inside));
}

/** Value at @p angle, straight line between the two neighbours. */
static inline num_t ctl_grid_read_linear(const ctl_grid_t *self, angle_t angle)
{
    return ctl_grid_read_at(self, ctl_grid_position(self, angle));
}
/** Value at @p angle, cubic through the two neighbours on either side (Lagrange). */
num_t ctl_grid_read_cubic(const ctl_grid_t *self, angle_t angle);

/** ctl_grid_read_cubic as inline code, for the speed interrupt, which reads three times a sample. Everett's form of the polynomial,
 *  y0 + t (y1 - y0) - t (1 - t) / 6 ((2 - t) D2 y0 + (1 + t) D2 y1), D2 the second differences. */
static inline num_t ctl_grid_read_cubic_raw(const ctl_grid_t *self, angle_t angle)
{
#ifdef EVENSPIN_FIXED
    return ctl_grid_read_cubic(self, angle);
#else
    const ctl_grid_position_t position = ctl_grid_position(self, angle);
    const num_t               t = angle_to_turns(position.inside);
    num_t                     y[4]; /* at the points -1, 0, 1, 2 from the one below */
    if ((uint16_t)(position.below - 1U) < (uint16_t)(self->cells - 3U)) {
        const num_t *const at = &self->cell[position.below - 1U];
        y[0] = at[0];
        y[1] = at[1];
        y[2] = at[2];
        y[3] = at[3];
    } else { /* across the end of the turn */
        const uint16_t after = ctl_grid_next(self, position.below);
        y[0] = self->cell[(position.below > 0U) ? (position.below - 1U) : (self->cells - 1U)];
        y[1] = self->cell[position.below];
        y[2] = self->cell[after];
        y[3] = self->cell[ctl_grid_next(self, after)];
    }
    const num_t rise = y[2] - y[1];
    const num_t bend0 = rise - (y[1] - y[0]);
    const num_t bend1 = (y[3] - y[2]) - rise;
    const num_t bent = ((2.0f - t) * bend0) + ((1.0f + t) * bend1);
    return y[1] + (t * (rise - (((1.0f - t) * bent) * 0.16666667f)));
#endif
}

#endif
