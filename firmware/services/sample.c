/* The interrupt's part. */
#include "firmware/services/services.h"
#include "hal/hal_clock.h"

static inline void note_fault(services_t *s)
{
    const drive_t *const d = s->setup.drive;
    const drive_fault_t  now = drive_fault(d);
    if ((now != FAULT_none) && (now != s->last_fault)) {
        s->found.fault = now;
        s->found.detail = drive_fault_detail(d);
        s->found.since = s->counter;
    }
    s->last_fault = now;
}

void services_sample(services_t *s)
{
    const uint32_t       started = hal_clock_cyc();
    const drive_t *const d = s->setup.drive;
    const uint32_t       counter = s->counter;

    stream_sample(&s->stream, d, counter);
    for (uint16_t i = 0U; i < SERVICES_RECORDERS; i++) {
        recorder_sample(&s->recorder[i], d, counter);
    }
    note_fault(s);
    s->counter = counter + 1U;

    s->sample_last_cyc = hal_clock_cyc() - started;
    if (s->sample_last_cyc > s->sample_max_cyc) {
        s->sample_max_cyc = s->sample_last_cyc;
    }
}
