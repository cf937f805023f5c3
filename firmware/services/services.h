/**
 * @file  firmware/services/services.h
 * @brief What the drive offers on the bench link (docs/protocol.md): session, parameters, commands, stream, recorders.
 *
 *     services_sample   end of the current interrupt: rows of the stream and of the recorders
 *     services_pass     one pass of the main loop: at most a few octets in, one request answered, one frame begun
 *
 * Cost in the interrupt, estimated as docs/cycles.md does: 800 cycles with the black box alone, 1600 in a period with a row of
 * eight streamed signals, 3000 at most, with stream of twelve, capture and black box of the dearest signals; a period has
 * 20000. The longest pass, a set of 40 parameters, is 97000 cycles, 0.5 ms; one that gives a method or a memory another kind or size,
 * with the bridge off, takes 300000, 1.5 ms.
 *
 * Neither waits. The interrupt writes the rows, `counter` and `found`; everything else belongs to the main loop.
 */
#ifndef FIRMWARE_SERVICES_SERVICES_H
#define FIRMWARE_SERVICES_SERVICES_H

#include "firmware/app/status.h"
#include "firmware/link/frame.h"
#include "firmware/services/param_store.h"
#include "firmware/services/recorder.h"
#include "firmware/services/stream.h"
#include "hal/hal_reset.h"

#define SERVICES_RECORDERS 2U
enum { SERVICES_CAPTURE = 0, SERVICES_BLACK_BOX };
#define SERVICES_OCTETS_PER_PASS 32U
#define SERVICES_TIMEOUT_MS 500U

/** What a board gives. */
typedef struct {
    drive_t              *drive;
    const drive_params_t *defaults;                         /**< Of this board; must stay. */
    const char           *board;                            /**< Its name. */
    float                *capture, *black_box;              /**< Memory of the recorders. */
    uint16_t              capture_values, black_box_values; /**< Values that each memory holds. */
    hal_reset_t           reset;                            /**< Why the board has started. */
} services_setup_t;

/** The first fault, kept until the next one. */
typedef struct {
    drive_fault_t fault;
    uint16_t      detail;
    uint32_t      since;
} services_fault_t;

/** What the run before a reset ended with, kept in memory that a board's C start-up does not clear (kept.c). */
typedef struct {
    bool          rows;   /**< The black box still holds its last rows. */
    uint16_t      resets; /**< Since then, at most 255; 0: nothing is known of an earlier run. */
    drive_fault_t fault;  /**< The last that it found. */
    uint16_t      detail;
    drive_state_t state;   /**< As the last pass of its main loop saw it. */
    uint32_t      counter; /**< Its periods. */
} services_past_t;

/** Makes what is kept believable. */
typedef struct {
    uint32_t magic, sum;
    uint16_t number; /**< Of the black box's configuration. */
} services_mark_t;

/** Who talks, and what that permits. */
typedef struct {
    bool         greeted, may_write, armed;
    bool         started;     /**< The timeout is running. */
    bool         by_itself;   /**< It was started by auto_run: the timeout cannot be switched off. */
    bool         timed_out;   /**< The last stop was by the timeout. */
    uint16_t     timeout_ms;  /**< 0: none. */
    uint32_t     alive_at;    /**< Counter at the last good frame. */
    bool         staging;     /**< A set of parameters is open in `staged`. */
    uint16_t     storing_seq; /**< Number of the request to save, which is answered when it is done. */
    uint16_t     storing;     /**< Its command. */
    bool         stored;      /**< The save is over, its answer waits. */
    hal_status_t stored_status;
    bool         event_wanted;
    uint16_t     event_seq, stream_seq;
} session_t;

/** Why a request was refused, besides the code. */
typedef struct {
    uint16_t field;
    float    low, high;
} refusal_t;

typedef struct services {
    services_setup_t setup;
    uint32_t         schema;
    bool             stored_taken; /**< The storage held parameters at power-up. */

    volatile uint32_t counter; /**< Periods since the start. */
    services_fault_t  found;
    services_past_t   past;
    services_mark_t   mark;
    drive_fault_t     last_fault; /**< Of the interrupt. */
    uint32_t          sample_last_cyc, sample_max_cyc;
    stream_t          stream;
    recorder_t        recorder[SERVICES_RECORDERS];

    session_t       session;
    drive_params_t  staged; /**< The set under construction, or the one being saved. */
    refusal_t       refusal;
    drive_state_t   seen_state;
    drive_fault_t   seen_fault;
    uint32_t        pass_cyc, pass_max_cyc;
    bool            passed;
    uint32_t        frames_bad;
    frame_decoder_t decoder;
    frame_t         frame;
    uint16_t        wire[FRAME_WIRE_MAX];
    uint16_t        wire_count, wire_at; /**< Octets waiting to be sent. */
} services_t;

/** Before the interrupts run. @p s: what the last run left, or anything. What it kept is taken where that can be believed; services at rest, the stored parameters or else the defaults taken, drive_init. With auto_run in the
 *  stored set the drive is then started, and the timeout counts from here on; not after a reset by the watchdog. */
void services_start(services_t *s, const services_setup_t *setup);
/** Current interrupt, after drive_current_isr. */
void services_sample(services_t *s);
/** Main loop, after drive_background. */
void services_pass(services_t *s);

#endif
