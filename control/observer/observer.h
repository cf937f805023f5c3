/**
 * @file  control/observer/observer.h
 * @brief Disturbance observers on the measured torque T_d: DOB (one state), RO (time domain), ARO (angle domain).
 *
 *     DOB   T[k] = T[k-1] + g (T_d - T[k-1])                                                             (1)
 *     RO    X[t] = q X[t-N] + g (T_d[t] - X[t-N]),  output X at t = k + ahead, from one period before    (2)
 *     ARO   the same over the angle: T_d belongs to theta[k - age]; output at theta[k] + w ahead         (3)
 *
 * t = k - age is the true time of the measurement (ctl_meter_age_half); ahead = actuation of the torque reference, so
 * that the compensation meets the disturbance when it acts. The output is an estimate of T_d: subtract it.
 *
 * What goes beyond the printed algorithm, each off by default: hat-weighted averages and cubic read-out
 * (angle_memory.h), a fast start (first `fast_samples` with `fast_gain`), removal of the one-turn mean, and rest: learning stops for
 * `rest_turns` when T_d is off its one-turn mean by more than `rest_torque` (a load step), and for `rest_samples` when the
 * speed changes faster than `rest_step`, and while the encoder's rounding would be learned (`sync_band`).
 *
 * Rounding of the encoder. With c counts per sample the rounding error is a sawtooth of c cycles per sample, which
 * sampling folds to |c - nearest whole number| cycles per sample. Where that is slow enough to pass the filters and is
 * a whole order of the turn (to 1/16), every turn sees the same error and it appears as torque: with 2^17 counts and
 * 10 kHz at 2000 r/min, order 28. At such target speeds (ctl_observer_target) ARO learns all but this order, which stays as it
 * was (kept_order.h; an order beyond half of the points as that for which they take it). Until that is known, and where the points
 * cannot tell it from the mean, the memory is used but not written.
 *
 * Where the speed may drift instead (ctl_observer_let_drift), by at most `drift_most`, all orders are learned. It is off its target by
 * what brings the order of the sawtooth to 0.38 off the nearest whole one, so that it moves on from turn to turn and averages out, with
 * its harmonics; and to 25 waves a turn or more, if that is within `drift_most`: a slower sawtooth moves the shaft, whose motion
 * then decides where the next edge falls, and what the two make of each other is learned (1950 r/min, 4.9 waves: 60 % less
 * ripple instead of 83 %).
 * The order is known to counts times the relative error of the angle per sample: 2^32 / samples per turn is a whole
 * number there (0.03 orders at 500 r/min).
 *
 * Source   Tang et al. 2020, equations 4, 7, 11, 16 and section IV. Stable for 0 < g < 2 (L_N a23 = g).
 * Total    non-finite torque or speed is not learned and is counted; a step of a quarter turn or more is counted, and
 *          learning waits until all ages lie after it; output within +-limit.
 * Cost     independent of N: an angle memory write and read, 5 products. an ARO without options does nothing else in a
 *          sample once it runs (ctl_observer_step_fast); what monitors the speed and the one-turn mean runs only
 *          when an option asks for it; the quality figure and the target speed are the main loop's.
 */
#ifndef CONTROL_OBSERVER_OBSERVER_H
#define CONTROL_OBSERVER_OBSERVER_H

#include "control/memory/ring.h"
#include "control/memory/kept_order.h"
#include "control/observer/angle_memory.h"

#define CTL_ARO_AGE_MAX 31U
#define CTL_OBSERVER_WAIT (CTL_ARO_AGE_MAX + 1U)
/** Where the speed may drift, the one-turn mean is that of so many turns: what the rounding of the encoder adds to one of them goes on from turn to turn, and as steps
 *  of the mean it would come back in the speed, and from there in the rounding (1900 r/min: 76 % less ripple instead of 83 %). */
#define CTL_OBSERVER_MEAN_TURNS 16U

typedef enum { CTL_OBSERVER_DOB = 0, CTL_OBSERVER_RO, CTL_OBSERVER_ARO } ctl_observer_kind_t;

typedef struct {
    ctl_observer_kind_t       kind;
    ctl_angle_memory_params_t memory;     /**< gain, forgetting and limit hold for every kind. */
    uint16_t                  age_half;   /**< Age of T_d, half samples, [0, 2 CTL_ARO_AGE_MAX]. */
    num_t                     ahead;      /**< Samples until the output acts, [0, 12]. */
    num_t                     rad_per_64; /**< Angle in rad that one unit of speed makes in 64 samples, > 0. */
    num_t                     fast_gain;  /**< Gain of the first `fast_samples`, (0, 1]. */
    uint32_t                  fast_samples;
    bool                      remove_mean;
    bool                      feeds;       /**< Something may be fed forward against the disturbance: disturbance.h. */
    num_t                     rest_torque; /**< 0: never. */
    num_t                     rest_turns;  /**< [0, 100]. */
    num_t                     rest_step;   /**< Change of speed per sample, low-passed, that stops learning; 0: never. */
    uint32_t                  rest_samples;
    uint32_t                  encoder_counts; /**< Per turn; 0: no rounding. */
    num_t    sync_band;  /**< Fold frequency over sampling rate below which rounding counts, [0, 0.5]; 0: never. */
    uint16_t drift_most; /**< Largest drift, counts per turn / 256; below 0.38 counts it is of no use. */
} ctl_observer_params_t;

typedef struct {
    ctl_angle_memory_t memory;                     /**< ARO */
    ctl_ring_t         time;                       /**< RO: X, newest first. */
    num_t              estimate;                   /**< DOB */
    angle_t            theta;                      /**< Last angle. */
    angle_t            past[CTL_ARO_AGE_MAX + 1U]; /**< Newest angles, ring; for an odd age_half those half a sample before. */
    uint16_t           head;
    uint16_t           wait;        /**< Samples until all ages lie after the start, or after a jump. */
    uint32_t           samples;     /**< Since the start, stops beyond fast_samples. */
    bool               ready;       /**< For ctl_observer_step_fast; the memory has a last sample then. */
    num_t              seen;        /**< Mean size of T_d, for the quality figure: ctl_observer_update_quality. */
    num_t              speed_known; /**< Last speed that was finite: ctl_observer_step. */
    num_t              turn_sum;    /**< Integral of T_d over the angle since the turn began. */
    num_t              turn_travel; /**< Travel since the turn began, turns. */
    num_t              mean;        /**< Of the last full turns, up to CTL_OBSERVER_MEAN_TURNS. */
    bool               mean_known;
    uint16_t           mean_turns;   /**< How many; 0: the next turn replaces the mean. */
    num_t              rest_travel;  /**< Turns for which learning still pauses. */
    uint32_t           rest_left;    /**< Samples for which learning still pauses. */
    num_t              speed_slow;   /**< Speed, low-passed over some 100 samples. */
    num_t              step_slow;    /**< Change of the speed per sample, low-passed over some 100 samples. */
    uint16_t           turn_samples; /**< Samples per turn at the target speed, nearest; 65535 when it stands or creeps. */
    uint16_t           rounding; /**< Order that the encoder's rounding has at the target speed, and 1; 0: none that counts. */
    ctl_kept_order_t   kept;     /**< ARO: that order as the memory sees it, which is not learned. */
    uint16_t           kept_rounding; /**< `rounding` for which `kept` is known, else 0. */
    bool               synchronous;   /**< Learning pauses because of the encoder's rounding. */
    bool               drifts;        /**< The speed may drift: ctl_observer_let_drift. */
    bool               drifting;      /**< At the target speed that keeps the rounding off what is learned. */
    num_t              drift;         /**< What the speed is off its target then, speed unit. */
    bool               held;          /**< By command: ctl_observer_hold. */
    uint32_t           rejected;
} ctl_observer_state_t;

/** What follows from the parameters. */
typedef struct {
    num_t    ahead_per_speed; /**< Angle in rad until the output acts, per unit of speed. */
    uint32_t half;            /**< All ones when half a sample of age_half is left, else 0. */
    uint16_t age;             /**< Whole samples of age_half. */
    bool     plain;           /**< ARO, one point a sample, lines, no option: ctl_observer_step_fast. */
    bool     watches;         /**< An option asks for the speed or the one-turn mean. */
} ctl_observer_derived_t;

typedef struct {
    ctl_observer_params_t  params;
    ctl_observer_derived_t derived;
    ctl_observer_derived_t prepared; /**< By ctl_observer_prepare. */
    ctl_observer_state_t   state;
} ctl_observer_t;

enum {
    CTL_OBSERVER_KIND = 1,
    CTL_OBSERVER_GAIN,
    CTL_OBSERVER_FORGETTING,
    CTL_OBSERVER_LIMIT,
    CTL_OBSERVER_AGE,
    CTL_OBSERVER_AHEAD,
    CTL_OBSERVER_RAD,
    CTL_OBSERVER_FAST_GAIN,
    CTL_OBSERVER_REST,
    CTL_OBSERVER_SYNC,
    CTL_OBSERVER_MEMORY
};

/**
 * Validate, take over the memory, forget everything. On error @p self stays as it was.
 * @param capacity ARO: cells per turn; RO: longest period in samples plus 32; DOB: not used.
 */
ctl_diag_t ctl_observer_init(ctl_observer_t *self, const ctl_observer_params_t *params, num_t *memory, uint16_t capacity);
/** What ctl_observer_init would say of them with a memory that is large enough; @p p is not NULL. Needs no object. */
ctl_diag_t ctl_observer_check(const ctl_observer_params_t *p);
/**
 * Other parameters, that ctl_observer_init would accept, of the same kind; the state goes on. In two parts: prepare writes what
 * ctl_observer_step does not read; take_prepared takes it over, with the same parameters, while no step runs.
 */
void               ctl_observer_prepare(ctl_observer_t *self, const ctl_observer_params_t *params);
static inline void ctl_observer_take_prepared(ctl_observer_t *self, const ctl_observer_params_t *params)
{
    ctl_observer_state_t *const s = &self->state;
    self->params = *params;
    self->derived = self->prepared;
    s->memory.params = params->memory;
    s->ready = false;
    if (!self->derived.watches) { /* unused state is reset, so that it starts clean when an option needs it */
        s->mean_known = false;
        s->mean_turns = 0U;
        s->rest_travel = (num_t)0;
        s->rest_left = 0U;
    }
}
/** ctl_observer_prepare and ctl_observer_take_prepared in one call. */
void ctl_observer_tune(ctl_observer_t *self, const ctl_observer_params_t *params);
/** Start again; what was learned stays when @p keep. Forgetting costs O(capacity): not for an interrupt. */
void ctl_observer_reset(ctl_observer_t *self, bool keep);
/** Stop or allow learning; the output goes on. */
static inline void ctl_observer_hold(ctl_observer_t *self, bool hold) { self->state.held = hold; }
/**
 * Set the target speed, speed unit: gives RO its period, and decides whether the encoder's
 * rounding would be learned, and how far the speed drifts. Cost: three 64-bit products, three 32-bit and two 64-bit divisions; for the
 * main loop.
 */
void ctl_observer_target(ctl_observer_t *self, num_t speed);
/**
 * The speed is what ctl_observer_drift says off its target: nothing has to be kept there. From the next ctl_observer_target on. For the
 * main loop.
 */
static inline void ctl_observer_let_drift(ctl_observer_t *self, bool drifts) { self->state.drifts = drifts; }
/** To be added to the target speed; 0 where that would be of no use, where it may not, and where it would have to be more than it may. */
static inline num_t ctl_observer_drift(const ctl_observer_t *self) { return self->state.drifting ? self->state.drift : (num_t)0; }
/** ARO: hold the order of the rounding as it was, a few cells a call. For the main loop; acts at the next ctl_observer_target. */
void ctl_observer_keep_rounding(ctl_observer_t *self);
/** Update the quality figure, once a sample or less often, while learning is allowed. For the main loop. */
void ctl_observer_update_quality(ctl_observer_t *self);
/** Mean size of the innovation over mean size of the observed torque: 1 nothing learned, near 0 everything. */
num_t ctl_observer_innovation_ratio(const ctl_observer_t *self);

/**
 * One sample.
 * @param theta  mechanical angle now.
 * @param speed  mechanical speed, speed unit.
 * @param torque T_d from ctl_meter_step.
 * @return estimate of the disturbance torque when an output of now acts.
 */
num_t ctl_observer_step(ctl_observer_t *self, angle_t theta, num_t speed, num_t torque);
/** ctl_observer_step without checks, for finite numbers. */
num_t ctl_observer_step_unchecked(ctl_observer_t *self, angle_t theta, num_t speed, num_t torque);
/** The angle goes into the ring. @return the one to which T_d belongs: that of a sample, or between two. */
static inline angle_t ctl_observer_note_angle(ctl_observer_t *self, angle_t theta)
{
    ctl_observer_state_t *const s = &self->state;
    const uint32_t back = (uint32_t)((int32_t)(s->theta - theta) >> 1); /* arithmetic on every compiler that builds this */
    s->theta = theta;
    s->head = (uint16_t)((s->head + 1U) & CTL_ARO_AGE_MAX);
    s->past[s->head] = theta + (back & self->derived.half);
    const uint16_t then = (uint16_t)((s->head - self->derived.age) & CTL_ARO_AGE_MAX);
    return s->past[then];
}

/** May this sample be learned, for all that is asked of every observer? Counts down. */
static inline bool ctl_observer_may_learn(ctl_observer_t *self)
{
    ctl_observer_state_t *const s = &self->state;
    const bool                  waits = s->wait > 0U;
    s->wait = (uint16_t)(s->wait - (waits ? 1U : 0U));
    return (!waits) & (!s->held) & (!s->synchronous);
}

/** Where the motor will stand when an output of now acts. */
static inline angle_t ctl_observer_ahead(const ctl_observer_t *self, angle_t theta, num_t speed)
{
    return theta + angle_step_from_rad_unchecked(num_mul(speed, self->derived.ahead_per_speed));
}

/** ctl_observer_step_unchecked while `ready` (a plain ARO after its fast start), for a step below a quarter turn: 110 cycles less.
 *  disturbance.h decides when. */
static inline num_t ctl_observer_step_fast(ctl_observer_t *self, angle_t theta, num_t speed, num_t torque)
{
    const ctl_angle_memory_params_t *const p = &self->params.memory;
    ctl_observer_state_t *const            s = &self->state;
    ctl_angle_memory_write_next(&s->memory, ctl_observer_note_angle(self, theta), torque, p->gain, ctl_observer_may_learn(self));
    return num_clamp(ctl_grid_read_linear(&s->memory.state.grid, ctl_observer_ahead(self, theta, speed)), num_neg(p->limit),
                     p->limit);
}

#endif
