/* A trace in memory, read from its begin. Whatever stands in it, nothing beyond its end is read: there every octet is 0. */
#include <string.h>

#include "sim_host/trace/trace.h"

void trace_feed(trace_reader_t *r, const uint8_t *const octets[TRACE_STREAMS], const size_t counts[TRACE_STREAMS])
{
    for (int i = 0; i < (int)TRACE_STREAMS; i++) {
        r->octet[i] = octets[i];
        r->count[i] = counts[i];
        r->at[i] = 0;
    }
    r->short_of = false;
}

bool trace_at_end(const trace_reader_t *r) { return r->at[TRACE_ORDER] >= r->count[TRACE_ORDER]; }

trace_event_t trace_next(const trace_reader_t *r)
{
    const uint8_t event = trace_at_end(r) ? (uint8_t)TRACE_EVENTS : r->octet[TRACE_ORDER][r->at[TRACE_ORDER]];
    return (event < (uint8_t)TRACE_EVENTS) ? (trace_event_t)event : TRACE_EVENTS;
}

uint8_t trace_get(trace_reader_t *r, int stream)
{
    if (r->at[stream] >= r->count[stream]) {
        r->short_of = true;
        return 0U;
    }
    return r->octet[stream][r->at[stream]++];
}

static uint32_t get_word(trace_reader_t *r)
{
    const uint32_t top = trace_get(r, TRACE_WORD_TOP);
    const uint32_t high = trace_get(r, TRACE_WORD_HIGH);
    const uint32_t low = trace_get(r, TRACE_WORD_LOW);
    return (top << 24U) | (high << 16U) | (low << 8U) | trace_get(r, TRACE_WORD_BOTTOM);
}

uint32_t trace_get_count(trace_reader_t *r, int channel)
{
    r->last[channel] += get_word(r);
    return r->last[channel];
}

float trace_get_number(trace_reader_t *r, int channel)
{
    r->last[channel] ^= get_word(r);
    return trace_number(r->last[channel]);
}

void trace_get_words(trace_reader_t *r, uint16_t *words, uint16_t count)
{
    for (uint16_t i = 0; i < count; i++) {
        const uint16_t high = trace_get(r, TRACE_OCTETS);
        words[i] = (uint16_t)((high << 8U) | trace_get(r, TRACE_OCTETS));
    }
}
