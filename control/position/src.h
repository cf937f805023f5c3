/**
 * @file  control/position/src.h
 * @brief Spatial repetitive control: the period is an angle, not a time.
 *
 *     y = Q(s) e^(-lambda p) (y + e)                                                                     (1)
 *     Q(s) = W^2 / (s^2 + sqrt(2) W s + W^2),   W = Omega |speed|                                        (2)
 *
 * p is the Laplace operator over the angle: the delay is kept in an angle grid. Q is scheduled with the speed, so its
 * corner is fixed over the angle. Its states are y and u = dy / d(Omega angle), so it goes on where it was after a stop:
 *
 *     dy = u d(Omega angle)      du = (x - y - sqrt(2) u) d(Omega angle)                                  (3)
 *
 * by the trapezoidal rule, d(Omega angle) = W T_s: at constant speed the bilinear transform of (2) without prewarping.
 * Its delay is sqrt(2) / Omega rad; the lambda to set is the period of the disturbance less that.
 *
 * Source   Yeh and Liu 2024, equation 5 and figure 3.
 * Total    a non-finite error counts as 0 and is counted; |y| <= limit. At standstill Q stands still.
 * Cost     a grid walk, a linear read, 1 division and 9 products.
 */
#ifndef CONTROL_POSITION_SRC_H
#define CONTROL_POSITION_SRC_H

#include "control/memory/angle_grid.h"

typedef struct {
    num_t   omega_half_ts; /**< Omega T_s / 2 times the base speed: W T_s / 2 per speed unit, > 0. */
    angle_t lambda;        /**< Angle of the delay, (0, 1) turn. */
    num_t   limit;         /**< Largest |y|, > 0. */
    bool    hold;          /**< Nothing is written, what was learned goes on acting. */
} ctl_src_params_t;

/** Q at a constant speed, as a filter: y = b0 (x + 2 x1 + x2) - a1 y1 - a2 y2. */
typedef struct {
    num_t b0, a1, a2;
} ctl_src_filter_t;

typedef struct {
    ctl_grid_t grid;
    angle_t    at;
    num_t      written;
    bool       primed;
    num_t      x, y, u; /**< Of the last sample, (3). */
    uint32_t   rejected;
} ctl_src_state_t;

typedef struct {
    ctl_src_params_t params;
    ctl_src_state_t  state;
} ctl_src_t;

enum { CTL_SRC_OMEGA = 1, CTL_SRC_LAMBDA, CTL_SRC_LIMIT, CTL_SRC_CELLS };

/** Validate, take over @p memory, all zero. On error @p self stays as it was. */
ctl_diag_t ctl_src_init(ctl_src_t *self, const ctl_src_params_t *params, num_t *memory, uint16_t cells);
/** Forget everything. Costs O(cells). */
void ctl_src_reset(ctl_src_t *self);
/** (2) for W T_s / 2 = @p k (cut to [0, 1]). */
ctl_src_filter_t ctl_src_filter(num_t k);
/** One sample. @return y, error unit. */
num_t ctl_src_step(ctl_src_t *self, angle_t theta, num_t speed, num_t err);

#endif
