/* The index pulse against the count: it comes at the same angle in every turn, unless counts were lost or added, whatever their number
 * from one sample to the next. What is lost adds up, since the first pulse stays the one to compare with: until the electrical zero is
 * found again. Not seen: what is lost before the first pulse, or by a shaft that turns by less than a turn. Main loop. */
#include "firmware/app/internal.h"

#define PULSE_COUNTS 4.0f /* one line: as wide as a pulse is, whose edges are met from either side */

void drive_make_index(const drive_params_t *p, drive_setup_t *s)
{
    const float more = p->encoder_index_rad + (PULSE_COUNTS * DRIVE_TWO_PI / p->encoder_counts);
    s->index.tolerance_rad = (p->encoder_index_rad > 0.0f) ? more : 0.0f;
    s->index.counts_per_rad = p->encoder_counts * (1.0f / DRIVE_TWO_PI);
}

void drive_forget_index(drive_t *d)
{
    d->index.passes = d->speed.edge.index_passes;
    d->index.known = false;
    d->index.error_rad = 0.0f;
}

void drive_attend_index(drive_t *d)
{
    drive_index_t *const             i = &d->index;
    const drive_index_setup_t *const s = &d->setup->index;
    const uint16_t                   passes = d->speed.edge.index_passes;
    if (passes == i->passes) {
        return;
    }
    i->passes = passes;
    const float at_rad = d->speed.edge.index_rad;
    if (!i->known) {
        i->first_rad = at_rad;
        i->known = true;
        return;
    }
    const float away = at_rad - i->first_rad;
    const float half = 0.5f * DRIVE_TWO_PI;
    i->error_rad = (away > half) ? (away - DRIVE_TWO_PI) : ((away < -half) ? (away + DRIVE_TWO_PI) : away);
    const float size = (i->error_rad < 0.0f) ? -i->error_rad : i->error_rad;
    if ((s->tolerance_rad > 0.0f) && !(size <= s->tolerance_rad) && (d->fault == FAULT_none)) {
        const float counts = (size * s->counts_per_rad) + 0.5f;
        d->fault_detail = (counts < 65535.0f) ? (uint16_t)counts : UINT16_MAX;
        drive_trip(d, FAULT_encoder_index);
    }
}
