/* A recording of the simulated drive, replayed on this machine: the same bits, or where they part. */
#include <stdio.h>

#include "sim_host/replay/replay.h"

extern const uint8_t *const trace_streams[];
extern const size_t         trace_counts[];
extern const uint32_t       trace_periods, trace_fault_period;
extern const int            trace_fault;

static replay_t replay;

static void say_what_differs(void)
{
    const replay_difference_t *const d = &replay.first;
    printf("first difference: kind %d, period %lu, index %u, recorded %.9g, replayed %.9g, %s / %s\n", (int)d->kind,
           (unsigned long)d->period, (unsigned)d->index, (double)d->recorded, (double)d->replayed,
           trace_event_name(d->recorded_event), trace_event_name(d->replayed_event));
    for (uint16_t i = 0; replay.row_known && (i < (uint16_t)SIGNAL_COUNT); i++) {
        if (trace_bits(replay.recorded[i]) != trace_bits(replay.replayed[i])) {
            printf("period %lu: %s was %.9g, is %.9g\n", (unsigned long)replay.row_period, telemetry_info(i)->name,
                   (double)replay.recorded[i], (double)replay.replayed[i]);
        }
    }
}

int main(void)
{
    uint32_t tripped = UINT32_MAX;
    replay_start(&replay);
    replay_feed(&replay, trace_streams, trace_counts);
    while (replay_period(&replay)) {
        if ((replay.row[SIGNAL_fault] > 0.0f) && (tripped == UINT32_MAX)) {
            tripped = replay.periods - 1U;
        }
    }
    printf("%lu of %lu periods, fault %d in period %lu\n", (unsigned long)replay.periods, (unsigned long)trace_periods,
           (int)replay.row[SIGNAL_fault], (unsigned long)tripped);
    if (replay.first.kind != REPLAY_SAME) {
        say_what_differs();
        return 1;
    }
    return ((replay.periods == trace_periods) && (tripped == trace_fault_period) &&
            ((int)replay.row[SIGNAL_fault] == trace_fault))
               ? 0
               : 1;
}
