/**
 * @file  sim_host/trace/trace.h
 * @brief Everything that the firmware takes in, in the order in which it asks for it: written while it runs, read to replay it.
 *
 * The cut is the HAL contract. A trace holds who called the firmware (interrupts, main loop, commands without a link), each call of
 * a HAL function with what it gave, and what the firmware did: its duties, a hash of what it sent and stored, and at the end of each
 * PWM period a hash of all signals. Every @ref trace_t::row_every periods the signals themselves follow.
 *
 * Octets lie in several streams, so that what is alike lies together and packs well: order of events; words of 32 bits in four
 * streams by octet, as the change since the last word of the same channel; octets of link and storage. docs/replay.md has the file.
 */
#ifndef SIM_HOST_TRACE_TRACE_H
#define SIM_HOST_TRACE_TRACE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "hal/hal_encoder.h"
#include "hal/hal_inverter.h"
#include "hal/hal_limits.h"
#include "hal/hal_reset.h"
#include "hal/hal_sample.h"

#define TRACE_VERSION 4

typedef enum {
#define MARK(name, doc) TRACE_##name,
#define ENTRY(name, doc) TRACE_##name,
#define ASKED(name, doc) TRACE_##name,
#include "sim_host/trace/events.def"
#undef MARK
#undef ENTRY
#undef ASKED
    TRACE_EVENTS
} trace_event_t;

/** Streams. */
enum { TRACE_ORDER = 0, TRACE_WORD_TOP, TRACE_WORD_HIGH, TRACE_WORD_LOW, TRACE_WORD_BOTTOM, TRACE_OCTETS, TRACE_STREAMS };

/** Channels of words: each is coded as its change since its last word. */
enum {
    TRACE_CH_CLOCK = 0,
    TRACE_CH_SEQ,
    TRACE_CH_ANGLE,
    TRACE_CH_CURRENT, /* three */
    TRACE_CH_VDC = TRACE_CH_CURRENT + 3,
    TRACE_CH_EDGE,
    TRACE_CH_EDGE_CYC,
    TRACE_CH_INDEX,
    TRACE_CH_DUTY, /* three */
    TRACE_CH_HASH = TRACE_CH_DUTY + 3,
    TRACE_CH_COUNT,
    TRACE_CH_VALUE,
    TRACE_CH_ROW, /* one for each signal */
    TRACE_CHANNELS = TRACE_CH_ROW + 128
};

typedef struct {
    uint8_t *octet;
    size_t   count, room;
} trace_stream_t;

/** Being written. */
typedef struct {
    trace_stream_t stream[TRACE_STREAMS];
    uint32_t       last[TRACE_CHANNELS];
    uint32_t       row_every, period;
    uint16_t       depth;  /**< Calls of the firmware that have not come back. */
    bool           failed; /**< Out of memory: what is written is not whole. */
} trace_t;

/** Being read. */
typedef struct {
    const uint8_t *octet[TRACE_STREAMS];
    size_t         count[TRACE_STREAMS], at[TRACE_STREAMS];
    uint32_t       last[TRACE_CHANNELS];
    bool           short_of; /**< Something was wanted beyond the end. */
} trace_reader_t;

/** Name and meaning of an event. */
const char *trace_event_name(trace_event_t event);
const char *trace_event_doc(trace_event_t event);
bool        trace_is_entry(trace_event_t event);

/** Hash of words, one by one; begin with TRACE_HASH. A difference in one word never gets lost in those that follow it unless they
 *  differ as well. */
#define TRACE_HASH 2166136261UL
static inline uint32_t trace_hash(uint32_t hash, uint32_t word)
{
    const uint32_t mixed = (hash ^ word) * 16777619UL;
    return mixed ^ (mixed >> 15U);
}
uint32_t trace_hash_words(const uint16_t *words, uint16_t count);
/** The bits of a number; every NaN has the same ones, whatever machine made it. */
uint32_t trace_bits(float value);
float    trace_number(uint32_t bits);

/* ---- writing; all of them do nothing when @p t is NULL ------------------------------------------------------------- */

void trace_open(trace_t *t, uint32_t row_every);
void trace_free(trace_t *t);
/** From the begin again, with the memory that it has. */
void trace_restart(trace_t *t);
/** The streams empty again, after somebody has taken them. Only between two periods. */
void trace_taken(trace_t *t);

void trace_put(trace_t *t, int stream, uint8_t octet);
/** A word as difference (counters, angles) or as changed bits (numbers). */
void trace_put_count(trace_t *t, int channel, uint32_t word);
void trace_put_number(trace_t *t, int channel, float value);
void trace_put_words(trace_t *t, const uint16_t *words, uint16_t count);

/** Somebody calls the firmware, and the call comes back. */
void trace_enter(trace_t *t, trace_event_t entry);
void trace_leave(trace_t *t);
/** The end of a period; @p row: all signals. */
void trace_period(trace_t *t, const float *row, uint16_t signals);

/** What the functions of the HAL contract gave. */
void trace_asked(trace_t *t, trace_event_t function);
void trace_status(trace_t *t, trace_event_t function, uint16_t status);
void trace_count(trace_t *t, trace_event_t function, uint32_t value);
void trace_clock(trace_t *t, uint32_t cyc);
void trace_sample(trace_t *t, hal_status_t status, const hal_sample_t *s);
void trace_edge(trace_t *t, hal_status_t status, const hal_encoder_edge_t *e);
void trace_duty(trace_t *t, hal_status_t status, const hal_duty_t *duty);
void trace_limits(trace_t *t, const hal_limits_t *limits);
void trace_temperature(trace_t *t, hal_status_t status, float celsius);
void trace_brake(trace_t *t, float duty);
void trace_link_read(trace_t *t, const uint16_t *octets, uint16_t count);
void trace_link_write(trace_t *t, const uint16_t *octets, uint16_t offered, uint16_t taken);
void trace_storage_read(trace_t *t, hal_status_t status, const uint16_t *words, uint16_t count);
void trace_storage_write(trace_t *t, hal_status_t status, const uint16_t *words, uint16_t count);

/* ---- reading: in the same order ------------------------------------------------------------------------------------- */

/** On @p streams; the memory of the channels goes on where the streams before ended. */
void          trace_feed(trace_reader_t *r, const uint8_t *const octets[TRACE_STREAMS], const size_t counts[TRACE_STREAMS]);
bool          trace_at_end(const trace_reader_t *r);
trace_event_t trace_next(const trace_reader_t *r); /* without taking it; TRACE_EVENTS: none, or none that is known */
uint8_t       trace_get(trace_reader_t *r, int stream);
uint32_t      trace_get_count(trace_reader_t *r, int channel);
float         trace_get_number(trace_reader_t *r, int channel);
void          trace_get_words(trace_reader_t *r, uint16_t *words, uint16_t count);

#endif
