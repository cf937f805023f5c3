/* The events by name, and what writing and reading share. */
#include <string.h>

#include "sim_host/trace/trace.h"

typedef struct {
    const char *name, *doc;
    bool        entry;
} event_t;

static const event_t EVENTS[TRACE_EVENTS] = {
#define MARK(name, doc) {#name, doc, false},
#define ENTRY(name, doc) {#name, doc, true},
#define ASKED(name, doc) {#name, doc, false},
#include "sim_host/trace/events.def"
#undef MARK
#undef ENTRY
#undef ASKED
};

static bool is_event(trace_event_t event) { return (unsigned)event < (unsigned)TRACE_EVENTS; }

const char *trace_event_name(trace_event_t event) { return is_event(event) ? EVENTS[event].name : ""; }
const char *trace_event_doc(trace_event_t event) { return is_event(event) ? EVENTS[event].doc : ""; }
bool        trace_is_entry(trace_event_t event) { return is_event(event) && EVENTS[event].entry; }

uint32_t trace_hash_words(const uint16_t *words, uint16_t count)
{
    uint32_t hash = (uint32_t)TRACE_HASH;
    for (uint16_t i = 0; i < count; i++) {
        hash = trace_hash(hash, words[i]);
    }
    return hash;
}

uint32_t trace_bits(float value)
{
    uint32_t bits = 0x7FC00000U; /* NaN */
    if (value == value) {
        memcpy(&bits, &value, sizeof bits);
    }
    return bits;
}

float trace_number(uint32_t bits)
{
    float value = 0.0f;
    memcpy(&value, &bits, sizeof value);
    return value;
}
