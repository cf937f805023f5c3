/**
 * @file  control/motor/mt_speed.h
 * @brief Speed from encoder edges and their times (M/T method): counts between the last edges of two samples over
 *        the time between these edges.
 *
 *     w = (2 pi / counts) (c1 - c0) / (t1 - t0),   c: position of an edge in counts, t: its time             (1)
 *
 * No quantisation error, whatever the speed; the value is the mean over the last T_s, so its age is about T_s / 2.
 * Without a new edge the speed is at most one count over the time since the last one, and 0 after `stop_samples`; the
 * first edge after such a standstill gives no speed yet, because the clock may have wrapped in between.
 *
 * Source   Ohmae et al. 1982, microprocessor-controlled high-accuracy wide-range speed regulator.
 * Total    equal times, jumps of time or count and the wrap of the clock give a value within +-speed_max.
 * Cost     1 division (fixed: 2).
 */
#ifndef CONTROL_MOTOR_MT_SPEED_H
#define CONTROL_MOTOR_MT_SPEED_H

#include "control/numeric/diag.h"

typedef struct {
    uint32_t sample_cyc;    /**< Nominal time between samples, clock cycles, > 0. */
    num_t    speed_1_count; /**< Speed of one count per nominal sample time, speed unit, > 0. */
    num_t    speed_max;     /**< Limit of the result, speed unit, > 0. */
    uint16_t stop_samples;  /**< Samples without an edge after which the motor counts as standing, > 0. */
} ctl_mt_params_t;

typedef struct {
    int32_t  edge_count;   /**< Position of the last edge. */
    uint32_t edge_cyc;     /**< Time of the last edge. */
    uint16_t idle_samples; /**< Samples since the last edge. */
    bool     primed;       /**< A first edge has been seen. */
    num_t    speed;        /**< Speed unit. */
} ctl_mt_state_t;

typedef struct {
    ctl_mt_params_t params;
    ctl_mt_state_t  state;
} ctl_mt_t;

enum { CTL_MT_SAMPLE = 1, CTL_MT_SPEED_1_COUNT, CTL_MT_SPEED_MAX, CTL_MT_STOP };

/** Validate, start at standstill. On error @p self stays as it was. */
ctl_diag_t ctl_mt_init(ctl_mt_t *self, const ctl_mt_params_t *params);
void       ctl_mt_reset(ctl_mt_t *self);
/**
 * One sample.
 * @param edge_count  position of the newest edge, counts, wraps at 2^32.
 * @param edge_cyc    time of that edge, cycles, wraps at 2^32.
 * @param now_cyc     time of this sample, cycles.
 * @return speed, speed unit.
 */
num_t ctl_mt_step(ctl_mt_t *self, int32_t edge_count, uint32_t edge_cyc, uint32_t now_cyc);

#endif
