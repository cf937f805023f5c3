/* How often the drive is started again after a trip: each trip has heated something, or was a sign of what the next start will do.
 * Main loop; time is the number of samples, which goes on through faults. Forgotten at power-off, as the heat is. */
#include "firmware/app/internal.h"

static uint32_t window(const drive_t *d) { return (uint32_t)(d->params->restart_window_s * (float)DRIVE_PWM_HZ); }

/* Until fewer than restart_limit of those that count are left. */
static uint32_t periods_to_wait(const drive_t *d)
{
    const drive_restarts_t *const r = &d->restarts;
    const uint16_t                limit = d->params->restart_limit;
    if ((limit == 0U) || (r->count < limit)) {
        return 0U;
    }
    const uint32_t age = d->sample.seq - r->at[r->count - limit];
    return (age < window(d)) ? (window(d) - age) : 0U;
}

void drive_attend_restarts(drive_t *d)
{
    drive_restarts_t *const r = &d->restarts;
    while ((r->count > 0U) && ((d->sample.seq - r->at[0]) >= window(d))) {
        r->count--;
        for (uint16_t i = 0U; i < r->count; i++) {
            r->at[i] = r->at[i + 1U];
        }
    }
}

void drive_note_clear(drive_t *d) { d->restarts.tripped = true; }

bool drive_may_restart(drive_t *d)
{
    drive_restarts_t *const r = &d->restarts;
    if (!r->tripped) {
        return true;
    }
    drive_attend_restarts(d);
    const uint32_t wait = periods_to_wait(d);
    if (wait > 0U) {
        d->fault_detail = (uint16_t)((wait + DRIVE_PWM_HZ - 1U) / DRIVE_PWM_HZ);
        drive_trip(d, FAULT_restart_lockout);
        return false;
    }
    if (d->params->restart_limit > 0U) { /* and more than there are */
        r->at[r->count] = d->sample.seq;
        r->count++;
    }
    r->tripped = false;
    return true;
}

float drive_restart_wait_s(const drive_t *d)
{
    return d->restarts.tripped ? ((float)periods_to_wait(d) * (1.0f / (float)DRIVE_PWM_HZ)) : 0.0f;
}
