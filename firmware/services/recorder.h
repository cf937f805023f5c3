/**
 * @file  firmware/services/recorder.h
 * @brief Rows of chosen signals in RAM at the full rate, around a trigger: what came before it and what came after.
 *
 * A ring of pre + post rows. While it runs only the current interrupt writes it; the main loop configures and reads it when
 * it is idle. Cost in the interrupt: one telemetry_read per signal at a row, one for the trigger in every period.
 */
#ifndef FIRMWARE_SERVICES_RECORDER_H
#define FIRMWARE_SERVICES_RECORDER_H

#include "firmware/app/status.h"

#define RECORDER_SIGNALS 8U

typedef enum {
    RECORDER_NEVER = 0, /**< Never configured. */
    RECORDER_FILLING,   /**< Fewer than `pre` rows are there. */
    RECORDER_WAITING,   /**< For the trigger. */
    RECORDER_AFTER,     /**< It came: `post` rows. */
    RECORDER_COMPLETE,
    RECORDER_STOPPED
} recorder_status_t;

typedef enum {
    RECORDER_AT_ONCE = 0,
    RECORDER_RISING,
    RECORDER_FALLING,
    RECORDER_EITHER,
    RECORDER_AT_FAULT, /**< Also before `pre` rows are there: a fault does not wait. */
    RECORDER_MANUAL,   /**< recorder_trigger only; as early. */
    RECORDER_TRIGGERS
} recorder_trigger_t;

typedef struct {
    uint16_t           signal[RECORDER_SIGNALS];
    uint16_t           count, decimation, pre, post;
    recorder_trigger_t trigger;
    uint16_t           trigger_signal;
    float              level;
} recorder_config_t;

typedef struct {
    float            *value;
    uint16_t          values; /**< Room, at most 32767. */
    recorder_config_t config;
    uint16_t          number; /**< Of this configuration, 8 bits. */

    volatile uint16_t status;
    volatile uint16_t manual; /**< The main loop wants the trigger now. */
    uint16_t          end;    /**< Ring: rows times signals. */
    uint16_t          at;     /**< Next value to write. */
    volatile uint16_t held;   /**< Rows in the ring. */
    uint16_t          wait;   /**< Periods until the next row. */
    uint16_t          left;   /**< Rows to come after the trigger. */
    uint16_t          before; /**< Rows from before the trigger; fewer than pre when it came early. */
    uint16_t          after;  /**< Rows from the trigger on: post, or fewer when a reset ended the record. */
    float             last;   /**< Trigger signal of the period before. */
    bool              primed; /**< `last` is valid. */
    bool              faulty; /**< Fault in the period before. */
    uint32_t          first, trigger_counter;
} recorder_t;

void recorder_init(recorder_t *r, float *memory, uint16_t values);
/** Main loop. Starts at once. @p config: everything in range, (pre + post) * count within the room, post > 0. */
void recorder_start(recorder_t *r, const recorder_config_t *config);
void recorder_stop(recorder_t *r);
void recorder_trigger(recorder_t *r);
/** Start again with the last configuration; does nothing when there is none. */
void recorder_restart(recorder_t *r);
/** Current interrupt, every period. */
void recorder_sample(recorder_t *r, const drive_t *d, uint32_t counter);
/** Before anything else of a recorder that a reset has interrupted: its rows become a complete record that ends there. Main loop.
 *  @param counter  Of the period in which it ended. @return false: it has no rows, or is not one of this memory; nothing can be read. */
bool recorder_revive(recorder_t *r, float *memory, uint16_t values, uint32_t counter);
/** Rows of the complete record; 0 before. */
uint16_t recorder_rows(const recorder_t *r);
/** Value @p offset of the complete record, row by row. @p offset below rows times signals. */
float recorder_value(const recorder_t *r, uint16_t offset);

#endif
