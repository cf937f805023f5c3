/**
 * @file  control/observer/angle_memory.h
 * @brief Learns a waveform over the angle: each grid point moves towards what was seen there.
 *
 *     m_i <- q m_i + g (v_i - m_i)     for a grid point i that the motion passes                         (1)
 *
 *   CTL_WRITE_ONE   as printed: of the points passed since the last sample only the newest, v_i on the straight line
 *                   between the two samples beside it
 *   CTL_WRITE_ALL   every point passed, each v_i on that straight line
 *   CTL_WRITE_HAT   v_i is the average of all samples within one cell on either side, weighted with their nearness;
 *                   where hardly one came near (weight below 1/4), the straight line counts as one. Written when the
 *                   motion leaves the two cells beside the point
 *
 * Source   Tang et al. 2020 (IEEE TIE 67), sections IV-B to IV-D. (1) has its pole at q - g: bounded for 0 < g < 1 + q.
 * Total    both directions, reversal and standstill; a non-finite value and a step of a quarter turn or more are not
 *          learned and are counted, the memory stays as it was. Contents stay within +-limit.
 * Cost     independent of the number of cells at normal speed: a write is 1 division and 2 products per point passed
 *          (hat: 1 division more per point); a read 2 products (linear) or 10 (cubic).
 */
#ifndef CONTROL_OBSERVER_ANGLE_MEMORY_H
#define CONTROL_OBSERVER_ANGLE_MEMORY_H

#include "control/memory/angle_grid.h"

typedef enum { CTL_WRITE_ONE = 0, CTL_WRITE_ALL, CTL_WRITE_HAT } ctl_write_t;
typedef enum { CTL_READ_LINEAR = 0, CTL_READ_CUBIC } ctl_read_t;

typedef struct {
    num_t       gain;       /**< g, (0, 1]. */
    num_t       forgetting; /**< q, [0, 1]; 1 forgets nothing. */
    ctl_write_t write;
    ctl_read_t  read;
    num_t       limit; /**< Largest |m_i|, > 0. */
} ctl_angle_memory_params_t;

/** Samples near one grid point: CTL_WRITE_HAT. */
typedef struct {
    num_t sum, weight;
    bool  passed; /**< Not only approached. */
} ctl_hat_t;

typedef struct {
    ctl_grid_t          grid;
    angle_t             at;           /**< Angle of the last sample. */
    ctl_grid_position_t position;     /**< Position of the last sample on the grid. */
    num_t               value;        /**< Value of the last sample. */
    bool                primed;       /**< A last sample exists. */
    ctl_hat_t           below, above; /**< Hat sums of the two grid points around the last sample. */
    uint32_t            written;      /**< Points written; wraps. */
    num_t               innovation;   /**< v_i - m_i of the point written last. */
    num_t    change; /**< Mean size of the innovation, by ctl_angle_memory_update_quality; falls as learning goes on. */
    uint32_t rejected;
} ctl_angle_memory_state_t;

typedef struct {
    ctl_angle_memory_params_t params;
    ctl_angle_memory_state_t  state;
} ctl_angle_memory_t;

enum { CTL_AM_GAIN = 1, CTL_AM_FORGETTING, CTL_AM_WRITE, CTL_AM_READ, CTL_AM_LIMIT, CTL_AM_CELLS };

/** Validate, take over @p memory, all zero. On error @p self stays as it was. */
ctl_diag_t ctl_angle_memory_init(ctl_angle_memory_t *self, const ctl_angle_memory_params_t *params, num_t *memory,
                                 uint16_t cells);
/** What ctl_angle_memory_init would say of them; @p params is not NULL. Needs no object. */
ctl_diag_t ctl_angle_memory_check(const ctl_angle_memory_params_t *params);
/** Forget everything. Costs O(cells): not for an interrupt. */
void ctl_angle_memory_clear(ctl_angle_memory_t *self);
/** Forget the last sample but not the contents: after a pause, or while learning pauses. */
void ctl_angle_memory_pause(ctl_angle_memory_t *self);
/** One sample: value @p v seen at @p angle, learned with gain @p gain (the parameter, or another one for a fast start). */
void ctl_angle_memory_write(ctl_angle_memory_t *self, angle_t angle, num_t v, num_t gain);
/** Update the mean size of the innovation, a low-pass over 100 calls. For the main loop: no interrupt needs it. */
void ctl_angle_memory_update_quality(ctl_angle_memory_t *self);
/** Learn value @p v at grid point @p i: equation (1) of this header. */
static inline void ctl_angle_memory_learn(ctl_angle_memory_t *self, uint16_t i, num_t v, num_t gain)
{
    const ctl_angle_memory_params_t *const p = &self->params;
    ctl_angle_memory_state_t *const        s = &self->state;
    const num_t                            m = s->grid.cell[i];
    const num_t                            innovation = num_sub(v, m);

    s->grid.cell[i] = num_clamp(num_mac(num_mul(p->forgetting, m), gain, innovation), num_neg(p->limit), p->limit);
    s->innovation = innovation;
    s->written++;
}

/** The first grid point at or above a position. */
static inline uint16_t ctl_grid_ceiling(const ctl_grid_t *grid, ctl_grid_position_t position)
{
    return (position.inside != 0U) ? ctl_grid_next(grid, position.below) : position.below;
}

/** Only the last point of the walk, without walking: upwards the one below, downwards the one above the new position. Not
 *  while @p learn is false. */
static inline void ctl_angle_memory_write_one(ctl_angle_memory_t *self, angle_t angle, ctl_grid_position_t now, num_t v,
                                              num_t gain, bool learn)
{
    ctl_angle_memory_state_t *const s = &self->state;
    const ctl_grid_t *const         grid = &s->grid;
    const angle_t                   turn = angle - s->at;
    uint16_t                        point = now.below;
    uint32_t                        beyond = now.inside; /* travel since the point, 2^-32 cells */
    uint16_t                        last = s->position.below;
    if (turn >= (2U * ANGLE_QUARTER)) {
        point = ctl_grid_ceiling(grid, now);
        beyond = 0U - now.inside;
        last = ctl_grid_ceiling(grid, s->position);
    }
    if (learn & (point != last)) {
        ctl_angle_memory_learn(self, point,
                               num_sub(v, num_mul(num_sub(v, s->value), ctl_grid_share(grid, beyond, angle_size(turn)))), gain);
    }
}

/** CTL_WRITE_ALL and CTL_WRITE_HAT: what ctl_angle_memory_write_unchecked does not do itself. */
void ctl_angle_memory_write_general(ctl_angle_memory_t *self, angle_t angle, ctl_grid_position_t now, num_t v, num_t gain);

/** CTL_WRITE_ONE, not for a first sample; without @p learn it only follows the motion. */
static inline void ctl_angle_memory_write_next(ctl_angle_memory_t *self, angle_t angle, num_t v, num_t gain, bool learn)
{
    ctl_angle_memory_state_t *const s = &self->state;
    const ctl_grid_position_t       now = ctl_grid_position(&s->grid, angle);
    ctl_angle_memory_write_one(self, angle, now, v, gain, learn);
    s->at = angle;
    s->position = now;
    s->value = v;
}

/** ctl_angle_memory_write of checked inputs: @p v is finite, @p gain within [0, 1], the step below a quarter turn. */
static inline void ctl_angle_memory_write_unchecked(ctl_angle_memory_t *self, angle_t angle, num_t v, num_t gain)
{
    ctl_angle_memory_state_t *const s = &self->state;
    const ctl_grid_position_t       now = ctl_grid_position(&s->grid, angle);
    if (self->params.write != CTL_WRITE_ONE) {
        ctl_angle_memory_write_general(self, angle, now, v, gain);
    } else if (s->primed) {
        ctl_angle_memory_write_one(self, angle, now, v, gain, true);
    } else {
        s->primed = true;
    }
    s->at = angle;
    s->position = now;
    s->value = v;
}
/** Learn nothing from this sample; with CTL_WRITE_ONE the next sample may be learned: it lies on a line with this one. */
void ctl_angle_memory_skip(ctl_angle_memory_t *self, angle_t angle, num_t v);

/** What was learned for @p angle. */
static inline num_t ctl_angle_memory_read(const ctl_angle_memory_t *self, angle_t angle)
{
    return (self->params.read == CTL_READ_CUBIC) ? ctl_grid_read_cubic(&self->state.grid, angle)
                                                 : ctl_grid_read_linear(&self->state.grid, angle);
}

#endif
