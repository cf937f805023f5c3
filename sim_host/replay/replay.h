/**
 * @file  sim_host/replay/replay.h
 * @brief The HAL contract from a trace: the same firmware runs again, bit for bit, without a machine.
 *
 * A third implementation of the contract beside the port of a chip and the virtual board. Whoever called the firmware calls it again
 * in the same order, and each function of the contract gives what it gave then. What the firmware does is held against the trace:
 * which function it calls, the duties, what it sends and stores, and all signals at the end of each PWM period. The first difference
 * is kept; the run goes on to the next stored signals, which name it, and ends there, or where the order of calls no longer fits.
 *
 * Needs no operating system and no heap: it runs on a Cortex-M4F as well. One replay per thread at a time.
 */
#ifndef SIM_HOST_REPLAY_REPLAY_H
#define SIM_HOST_REPLAY_REPLAY_H

#include "firmware/app/telemetry.h"
#include "firmware/services/services.h"
#include "sim_host/trace/trace.h"

#define REPLAY_CAPTURE_VALUES 6140U
#define REPLAY_BLACK_BOX_VALUES 2048U
#define REPLAY_NAME 32
#define REPLAY_PREEMPTED 8U /* calls of the firmware inside one another, at most */

typedef enum {
    REPLAY_SAME = 0, /**< No difference so far. */
    REPLAY_SIGNALS,  /**< Signals at the end of a period; which ones is known from the next stored row on. */
    REPLAY_DUTY,     /**< `index`: phase 0 to 2. */
    REPLAY_SENT,     /**< Octets for the link, words for the storage, or the brake resistor. */
    REPLAY_ORDER,    /**< The firmware asks for something else than it did then. */
    REPLAY_BROKEN    /**< The trace itself makes no sense here. */
} replay_kind_t;

typedef struct {
    replay_kind_t kind;
    uint32_t      period;
    uint16_t      index;
    trace_event_t recorded_event,
        replayed_event;       /**< REPLAY_ORDER; TRACE_EVENTS: it was at its end. REPLAY_SENT: the function. */
    float recorded, replayed; /**< REPLAY_DUTY */
} replay_difference_t;

typedef struct {
    trace_reader_t      in;
    drive_t             drive;
    services_t          services;
    drive_params_t      params;
    char                board[REPLAY_NAME];
    float               capture[REPLAY_CAPTURE_VALUES], black_box[REPLAY_BLACK_BOX_VALUES];
    uint32_t            periods; /**< Ended so far. */
    uint16_t            depth;
    bool                started, ended; /**< `ended`: it cannot go on. */
    replay_difference_t first;          /**< First difference of what the firmware does, */
    replay_difference_t last;           /**< and where the order of calls no longer fits; kind 0: it does. */
    bool                row_known;      /**< There was a stored row that differs behind the first difference: */
    uint32_t            row_period;     /**< in this period, */
    float               recorded[SIGNAL_COUNT], replayed[SIGNAL_COUNT];
    float               row[SIGNAL_COUNT]; /**< All signals at the end of the last period. */
    float               amps[DRIVE_OBSERVER_CAPACITY];
} replay_t;

void replay_start(replay_t *r);
/** The next part of the trace; false: there is no more to be done, it has ended. */
void replay_feed(replay_t *r, const uint8_t *const octets[TRACE_STREAMS], const size_t counts[TRACE_STREAMS]);
/** Up to the end of the next period. @return whether there was one; false at the end of what was fed, and when it has ended. */
bool replay_period(replay_t *r);

/** replay_hal.c: the replay that the HAL functions of this thread mean. */
void replay_select(replay_t *r);
/** The event that a call of the HAL takes: false, and noted, when another one is next. */
bool replay_take(replay_t *r, trace_event_t event);
/** Calls of the firmware that interrupt the one that runs, where they did then. */
void replay_preempt(replay_t *r);
void replay_note(replay_t *r, const replay_difference_t *found);

#endif
