/* The trace of a simulated drive: everything that its firmware takes in. */
#include <string.h>

#include "sim_host/capi/sim.h"

extern const char sim_firmware_id[]; /* made by the build */

const char *es_firmware_id(void) { return sim_firmware_id; }
int         es_trace_version(void) { return TRACE_VERSION; }
int         es_trace_streams(void) { return (int)TRACE_STREAMS; }

bool es_sim_trace_open(es_sim_t *sim, int rows_every)
{
    if (sim == NULL) {
        return false;
    }
    if (sim->started) {
        return capi_refuse(&sim->error, ES_STARTED, "param", "trace", 1.0);
    }
    if (rows_every < 1) {
        return capi_refuse_range(&sim->error, ES_NOT_WHOLE, "param", "rows_every", (double)rows_every, 1.0, 1e9, "period");
    }
    trace_free(&sim->trace);
    trace_open(&sim->trace, (uint32_t)rows_every);
    sim->board.trace = &sim->trace;
    return true;
}

int64_t es_sim_trace_size(const es_sim_t *sim, int stream)
{
    const bool there = (sim != NULL) && (sim->board.trace != NULL) && (stream >= 0) && (stream < (int)TRACE_STREAMS);
    return there ? (int64_t)sim->trace.stream[stream].count : 0;
}

int64_t es_sim_trace_read(const es_sim_t *sim, int stream, uint8_t *octets, int64_t room)
{
    const int64_t count = es_sim_trace_size(sim, stream);
    if ((octets == NULL) || (count < 1) || (count > room)) {
        return 0;
    }
    memcpy(octets, sim->trace.stream[stream].octet, (size_t)count);
    return count;
}

bool es_sim_trace_taken(es_sim_t *sim)
{
    if ((sim == NULL) || (sim->board.trace == NULL)) {
        return false;
    }
    trace_taken(&sim->trace);
    return sim->trace.failed ? capi_refuse(&sim->error, ES_NO_MEMORY, "param", "trace", 0.0) : true;
}

void capi_trace_period(es_sim_t *s)
{
    if (s->board.trace == NULL) {
        return;
    }
    uint16_t every[SIGNAL_COUNT];
    float    row[SIGNAL_COUNT];
    for (uint16_t i = 0; i < (uint16_t)SIGNAL_COUNT; i++) {
        every[i] = i;
    }
    telemetry_read_row(&s->drive, every, (uint16_t)SIGNAL_COUNT, row);
    trace_period(s->board.trace, row, (uint16_t)SIGNAL_COUNT);
}
