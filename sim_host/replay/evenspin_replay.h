/**
 * @file  sim_host/replay/evenspin_replay.h
 * @brief The C interface that Python loads to replay a recording. One library per numeric: evenspin_replay_float and _fixed.
 *
 * Plain prototypes and typedefs only, as evenspin_capi.h. Every function is total.
 */
#ifndef EVENSPIN_REPLAY_H
#define EVENSPIN_REPLAY_H

#include <stdbool.h>
#include <stdint.h>

int         er_abi_version(void);
int         er_trace_version(void);
const char *er_firmware_id(void);
uint32_t    er_schema_hash(void);

typedef enum { ER_SAME, ER_SIGNALS, ER_DUTY, ER_SENT, ER_ORDER, ER_BROKEN } er_kind_t;

typedef struct {
    er_kind_t   kind;
    int64_t     period;             /* counted from 0 */
    int         index;              /* ER_DUTY: phase 0 to 2 */
    const char *recorded_event;     /* ER_ORDER: what the firmware did then; "" nothing more. ER_SENT: the function */
    const char *replayed_event;     /* and what it does now */
    double      recorded, replayed; /* ER_DUTY */
} er_difference_t;

typedef struct er_replay er_replay_t;

er_replay_t *er_new(void); /* NULL: no memory */
void         er_free(er_replay_t *replay);
int          er_signal_count(void);
const char  *er_signal_name(int index);
/* The next part of the trace, whole periods; the octets have to stay until it is run through. */
bool er_feed(er_replay_t *replay, const uint8_t *const *octets, const int64_t *counts);
/* Up to so many periods, a row of all signals for each into `out`, which may be NULL. Returns the periods that were run: fewer at the
 * end of what was fed, at a difference, and behind a period in which the drive trips. */
int64_t er_run(er_replay_t *replay, int64_t periods, double *out);
int64_t er_periods(const er_replay_t *replay);                     /* run so far */
int64_t er_position(const er_replay_t *replay, int stream);        /* octets taken of what was fed */
bool    er_at_end(const er_replay_t *replay);                      /* of what was fed */
bool    er_ended(const er_replay_t *replay);                       /* it cannot go on: a difference */
bool    er_first(const er_replay_t *replay, er_difference_t *out); /* false: no difference so far */
bool    er_last(const er_replay_t *replay, er_difference_t *out);  /* where the order of calls no longer fits; false: it does */
/* Signals of the first stored row behind the first difference, and their period; -1 without. */
int64_t er_row(const er_replay_t *replay, double *recorded, double *replayed);

#endif
