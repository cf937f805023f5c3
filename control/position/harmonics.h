/**
 * @file  control/position/harmonics.h
 * @brief A torque tied to the angle as a sum of sines: T = sum_i L_i sin(w_i theta + phi_i).
 *
 * w_i in cycles per turn, whole or not; over many turns the phase is exact to 2^-20 cycle per turn.
 * Source   Yeh and Liu 2024, equation 7. Cost: a sine and two products per line.
 */
#ifndef CONTROL_POSITION_HARMONICS_H
#define CONTROL_POSITION_HARMONICS_H

#include "control/position/motion.h"

#define CTL_HARMONICS_MAX 6U

typedef struct {
    uint32_t cycles_q20; /**< w_i, cycles per turn times 2^20: ctl_cycles_q20. */
    num_t    amplitude;  /**< L_i, torque unit. */
    angle_t  phase;      /**< phi_i. */
} ctl_line_t;

typedef struct {
    uint16_t   lines; /**< [0, CTL_HARMONICS_MAX]. */
    ctl_line_t line[CTL_HARMONICS_MAX];
} ctl_harmonics_t;

enum { CTL_HARMONICS_LINES = 1, CTL_HARMONICS_AMPLITUDE };

/** Cycles per turn within [0, 4095] (cut; NaN gives 0) as a whole number of 2^-20. Main loop. */
uint32_t   ctl_cycles_q20(float cycles_per_turn);
ctl_diag_t ctl_harmonics_check(const ctl_harmonics_t *p);
/** T, of lines that ctl_harmonics_check accepted; every position is a valid one, so that there is nothing to check. */
static inline num_t ctl_harmonics(const ctl_harmonics_t *p, ctl_position_t position)
{
    const uint32_t part = (uint32_t)(uint64_t)position;
    const uint32_t turn = (uint32_t)((uint64_t)position >> 32);
    num_t          sum = (num_t)0;
    for (const ctl_line_t *l = p->line, *const end = &p->line[p->lines]; l < end; l++) {
        /* cycles modulo 1 in 2^-32: of the part of a turn, and of the whole turns (only their fraction matters) */
        const angle_t at = (angle_t)(((uint64_t)part * l->cycles_q20) >> 20) + ((angle_t)(turn * l->cycles_q20) << 12);
        num_t         sine, cosine;
        angle_sincos(at + l->phase, &sine, &cosine);
        sum = num_mac(sum, l->amplitude, sine);
    }
    return sum;
}

#endif
