#include "firmware/app/timing.h"

#include <string.h>

#include "hal/hal_clock.h"

/* 0 is the epoch of figures that nobody has begun yet. */
void timing_restart(timing_t *timing)
{
    const uint16_t next = (uint16_t)(timing->epoch + 1U);
    timing->epoch = (next != 0U) ? next : 1U;
    timing->span_cyc = 0U; /* second: a current interrupt in between has seen the new epoch, or sees it now */
}

void timing_check(timing_t *timing, uint32_t period_cyc)
{
    const uint32_t span = timing->span_cyc;
    if ((timing->least_cyc > period_cyc) || (span > ((period_cyc - timing->least_cyc) + 1U))) {
        timing->span_cyc = 0U; /* also when an interrupt came between the two reads: then it is opened again for nothing */
    }
}

uint32_t timing_bin(const timing_one_t *one, uint16_t bin) { return (bin < TIMING_BINS) ? one->bin[bin] : 0U; }

uint32_t timing_own_clock(const timing_t *timing)
{
    uint32_t used = timing->used_cyc;
    uint32_t now = hal_clock_cyc();
    if (timing->used_cyc != used) {
        used = timing->used_cyc;
        now = hal_clock_cyc();
    }
    return now - used;
}

void timing_begin(timing_one_t *one, uint16_t epoch)
{
    (void)memset(one, 0, sizeof *one);
    one->min_cyc = UINT32_MAX;
    one->epoch = epoch;
}

bool timing_note_abnormal(timing_t *timing, uint32_t cyc, uint32_t period_cyc)
{
    timing_note(&timing->current, timing->epoch, cyc);
    const uint32_t least = timing->current.min_cyc;
    const uint32_t most = (timing->current.max_cyc < period_cyc) ? timing->current.max_cyc : period_cyc;
    timing->least_cyc = least;
    timing->span_cyc = (least <= most) ? ((most - least) + 1U) : 0U;
    return cyc > period_cyc;
}
