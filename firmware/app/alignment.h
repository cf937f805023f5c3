/**
 * @file  firmware/app/alignment.h
 * @brief Where the d axis is, for an encoder that does not know: found with current, and checked before it is believed.
 *
 *     wait   bridge off, until the shaft rests
 *     pull   current rises on a vector a quarter turn off, then the vector goes to its begin
 *     sweep  the vector turns slowly, forward and back, with the whole current and with half of it; encoder less vector is averaged
 *     hold   the vector stands, the shaft must rest
 *
 * Dry friction holds the rotor behind the vector by the same angle in both directions: it leaves the mean. Cogging has whole periods in an
 * electrical turn. What is left falls with the current as a load's angle does, hence half the current: the mean of the whole
 * current is corrected by the difference of the two. A vector moved against the rotor's swing damps it; that acts on what the
 * encoder has done within a time that is cut to the swing.
 */
#ifndef FIRMWARE_APP_ALIGNMENT_H
#define FIRMWARE_APP_ALIGNMENT_H

#include <stdbool.h>
#include <stdint.h>

#include "control/numeric/angle.h"
#include "firmware/app/faults.h"

#define DRIVE_ALIGN_PASSES 4U

typedef enum {
    DRIVE_ALIGN_WAIT = 0, /**< Bridge off. */
    DRIVE_ALIGN_RESTS,    /**< Bridge off: the main loop may arm it. */
    DRIVE_ALIGN_PULL,
    DRIVE_ALIGN_SWEEP,
    DRIVE_ALIGN_HOLD,
    DRIVE_ALIGN_DONE /**< Judged by the main loop. */
} drive_align_phase_t;

/** One pass of the vector. */
typedef struct {
    int32_t moved; /**< Of the shaft over the measured turns, turns in 2^-26. */
    int32_t sum;   /**< Encoder less vector, electrical, from `from` on: turns in 2^-16, summed over the periods. */
} drive_align_pass_t;

/** Written by the main loop before the alignment begins and after it has ended, by the current interrupt in between. */
typedef struct {
    volatile uint16_t phase; /**< drive_align_phase_t. */
    /* what is asked for */
    num_t    current, current_step; /**< In full; rise in a period. */
    int32_t  vector_step;           /**< Step of the vector in a period, at full speed. */
    int32_t  pace_step;             /**< Change of that step in a period, while the vector speeds up. */
    uint16_t quarter_periods;       /**< Periods of a quarter turn of the vector. */
    uint16_t quarters;              /**< Of a pass: two to reach a steady motion, then those that count. */
    uint32_t wait_periods;
    uint32_t rest; /**< Motion that is none, mechanical turns in 2^-32. */
    /* how far it is */
    uint16_t           pass, quarter, period;
    uint32_t           waited; /**< Periods. */
    num_t              current_now;
    angle_t            vector;    /**< Angle of the vector, without damping. */
    int32_t            pace;      /**< Step of `vector` in this period. */
    angle_t            at;        /**< Angle of the current command: `vector` with damping. */
    angle_t            corner;    /**< Encoder at the beginning of the quarter, or of the window of the wait. */
    angle_t            low, high; /**< Extremes of the encoder since then, less `corner`. */
    bool               opposed;   /**< The damping acts with the opposite sign: with this one it did not damp. */
    angle_t            from;      /**< Encoder less vector when the first pass began to count. */
    drive_align_pass_t seen[DRIVE_ALIGN_PASSES];
    /* damping */
    angle_t  slow; /**< Encoder less vector, electrical, behind a low-pass of 2^shift periods. */
    uint16_t shift;
    bool     rising;           /**< The swing now goes forward, */
    angle_t  extreme;          /**< has come so far, */
    uint16_t age, extreme_age; /**< and began so many periods ago, the second of them when it came there. */
} drive_align_t;

/** What the motion says. */
typedef struct {
    drive_fault_t fault;
    uint16_t      detail;
    angle_t       zero_e; /**< If there is no fault. */
} drive_align_result_t;

#endif
