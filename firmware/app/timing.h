/**
 * @file  firmware/app/timing.h
 * @brief How long an interrupt takes: last, shortest, longest, and how often how long.
 *
 * Histogram: TIMING_BINS - 1 bins of TIMING_BIN_CYC cycles, the last one for everything longer. Both interrupts together
 * have 5000 cycles (25 % of a PWM period at 200 MHz): the middle of the histogram. The number of bins is prime, so that
 * a log that shows one bin a row shows all of them whatever its rate.
 *
 * What is measured lies between the first and the last line of the interrupt of the drive: entry, exit and the begin and
 * end of the port come on top. The speed interrupt's time is its own: the current interrupts that preempt it are taken
 * out, but for their entry and exit.
 *
 * Context  each interrupt notes its own; the main loop only reads, and asks for a restart (timing_restart).
 * Cost     about 30 cycles in the current interrupt and 130, two readings of the clock, in the speed interrupt (estimates).
 */
#ifndef FIRMWARE_APP_TIMING_H
#define FIRMWARE_APP_TIMING_H

#include <stdbool.h>
#include <stdint.h>

#define TIMING_BINS 17U
#define TIMING_BIN_SHIFT 9U
#define TIMING_BIN_CYC (UINT32_C(1) << TIMING_BIN_SHIFT)

/** One interrupt's figures; all zero before the first run. */
typedef struct {
    uint32_t last_cyc, min_cyc, max_cyc;
    uint32_t bin[TIMING_BINS]; /**< Runs; each wraps after 119 h at 10 kHz. */
    uint16_t epoch;            /**< Of the measurement that these figures belong to. */
} timing_one_t;

typedef struct {
    timing_one_t current, speed;
    uint32_t     least_cyc; /**< From here on, */
    volatile uint32_t
        span_cyc; /**< so many lengths of a current interrupt are nominal: between its extremes and within its period. 0 once
                                      a restart is wanted. Written by the current interrupt; 0 by the main loop, too. */
    volatile uint32_t used_cyc; /**< By all current interrupts so far; wraps. Written by the current interrupt. */
    volatile uint16_t epoch;    /**< Of the measurement that is wanted. Written by the main loop. */
} timing_t;

/** Forget all figures of both interrupts; each does so at its next end. Once at the start, then from the main loop. */
void timing_restart(timing_t *timing);

/** Close a window of nominal runs that reaches beyond @p period_cyc: only a damaged word makes one, and behind it nobody would see that an
 *  interrupt takes too long. The next current interrupt opens it again. Main loop, in every pass. */
void timing_check(timing_t *timing, uint32_t period_cyc);

/** Runs in a bin since the restart; 0 beyond the last bin. */
uint32_t timing_bin(const timing_one_t *one, uint16_t bin);

/**
 * A clock that stands still during current interrupts, for the interrupt that they preempt; differences only. One
 * current interrupt in between makes the first reading useless; the next one is a PWM period away.
 */
uint32_t timing_own_clock(const timing_t *timing);

/** Forget, and begin with a first run. */
void timing_begin(timing_one_t *one, uint16_t epoch);

/** Forget, if these figures do not belong to @p epoch. */
static inline void timing_follow(timing_one_t *one, uint16_t epoch)
{
    if (one->epoch != epoch) {
        timing_begin(one, epoch);
    }
}

/** Whether a current interrupt of @p cyc cycles is neither longer nor shorter than those before, nor than its period, in their epoch. */
static inline bool timing_is_nominal(const timing_t *timing, uint32_t cyc)
{
    return (cyc - timing->least_cyc) < timing->span_cyc;
}

/** Note that a run of the same epoch took @p cyc cycles, between its extremes. */
static inline void timing_note_nominal(timing_one_t *one, uint32_t cyc)
{
    const uint32_t bin = cyc >> TIMING_BIN_SHIFT;
    one->last_cyc = cyc;
    one->bin[(bin < (TIMING_BINS - 1U)) ? bin : (TIMING_BINS - 1U)]++;
}

/** Note that a run took @p cyc cycles. */
static inline void timing_note(timing_one_t *one, uint16_t epoch, uint32_t cyc)
{
    timing_follow(one, epoch);
    one->max_cyc = (cyc > one->max_cyc) ? cyc : one->max_cyc;
    one->min_cyc = (cyc < one->min_cyc) ? cyc : one->min_cyc;
    timing_note_nominal(one, cyc);
}

/** Note a current interrupt that is not nominal. @return whether it took more than @p period_cyc. */
bool timing_note_abnormal(timing_t *timing, uint32_t cyc, uint32_t period_cyc);

#endif
