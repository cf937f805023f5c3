/* The interface for Python. */
#include <stdlib.h>

#include "firmware/services/schema.h"
#include "sim_host/replay/evenspin_replay.h"
#include "sim_host/replay/replay.h"

extern const char sim_firmware_id[]; /* made by the build */

struct er_replay {
    replay_t replay;
};

int         er_abi_version(void) { return 1; }
int         er_trace_version(void) { return TRACE_VERSION; }
const char *er_firmware_id(void) { return sim_firmware_id; }
uint32_t    er_schema_hash(void) { return schema_hash(); }
int         er_signal_count(void) { return (int)SIGNAL_COUNT; }

const char *er_signal_name(int index)
{
    const signal_info_t *const s = (index >= 0) ? telemetry_info((uint16_t)index) : NULL;
    return (s != NULL) ? s->name : "";
}

er_replay_t *er_new(void)
{
    er_replay_t *const r = malloc(sizeof *r);
    if (r != NULL) {
        replay_start(&r->replay);
    }
    return r;
}

void er_free(er_replay_t *replay) { free(replay); }

bool er_feed(er_replay_t *replay, const uint8_t *const *octets, const int64_t *counts)
{
    size_t sizes[TRACE_STREAMS];
    if ((replay == NULL) || (octets == NULL) || (counts == NULL)) {
        return false;
    }
    for (int i = 0; i < (int)TRACE_STREAMS; i++) {
        if ((counts[i] < 0) || (octets[i] == NULL)) {
            return false;
        }
        sizes[i] = (size_t)counts[i];
    }
    replay_feed(&replay->replay, octets, sizes);
    return true;
}

int64_t er_run(er_replay_t *replay, int64_t periods, double *out)
{
    int64_t done = 0;
    bool    tripped = false;
    while ((replay != NULL) && (done < periods) && !tripped) {
        replay_t *const r = &replay->replay;
        const bool      was_in_fault = r->row[SIGNAL_fault] > 0.0f;
        if (!replay_period(r)) {
            break;
        }
        for (int i = 0; (out != NULL) && (i < (int)SIGNAL_COUNT); i++) {
            out[(done * (int)SIGNAL_COUNT) + i] = (double)r->row[i];
        }
        tripped = !was_in_fault && (r->row[SIGNAL_fault] > 0.0f);
        done++;
    }
    return done;
}

int64_t er_periods(const er_replay_t *replay) { return (replay != NULL) ? (int64_t)replay->replay.periods : 0; }
int64_t er_position(const er_replay_t *replay, int stream)
{
    return ((replay != NULL) && (stream >= 0) && (stream < (int)TRACE_STREAMS)) ? (int64_t)replay->replay.in.at[stream] : 0;
}
bool er_at_end(const er_replay_t *replay) { return (replay == NULL) || trace_at_end(&replay->replay.in); }
bool er_ended(const er_replay_t *replay) { return (replay == NULL) || replay->replay.ended; }

static bool give(const replay_difference_t *d, er_difference_t *out)
{
    if ((d->kind == REPLAY_SAME) || (out == NULL)) {
        return false;
    }
    out->kind = (er_kind_t)d->kind;
    out->period = (int64_t)d->period;
    out->index = d->index;
    out->recorded_event = trace_event_name(d->recorded_event);
    out->replayed_event = trace_event_name(d->replayed_event);
    out->recorded = (double)d->recorded;
    out->replayed = (double)d->replayed;
    return true;
}

bool er_first(const er_replay_t *replay, er_difference_t *out) { return (replay != NULL) && give(&replay->replay.first, out); }
bool er_last(const er_replay_t *replay, er_difference_t *out) { return (replay != NULL) && give(&replay->replay.last, out); }

int64_t er_row(const er_replay_t *replay, double *recorded, double *replayed)
{
    if ((replay == NULL) || !replay->replay.row_known || (recorded == NULL) || (replayed == NULL)) {
        return -1;
    }
    for (int i = 0; i < (int)SIGNAL_COUNT; i++) {
        recorded[i] = (double)replay->replay.recorded[i];
        replayed[i] = (double)replay->replay.replayed[i];
    }
    return (int64_t)replay->replay.row_period;
}
