/* How a run ends: bridge off at once, down a ramp under control, or with the phases shorted until the shaft rests. Main loop. */
#include "firmware/app/internal.h"

#define RESTS_PERIODS 200U /* 20 ms without motion: at rest */

static void begin_ramp(drive_t *d)
{
    const drive_command_t rest = {.mode = DRIVE_MODE_SPEED};
    d->stopping.resume = *drive_active_command(d);
    d->stopping.how = DRIVE_STOP_RAMP;
    drive_hand_over(d, &rest);
}

void drive_stop_by(drive_t *d, drive_stop_word_t how)
{
    if ((how == DRIVE_STOP_COAST) || (d->state != DRIVE_RUN) || (d->stopping.how != DRIVE_STOP_COAST)) {
        d->stop_wanted = true; /* the second stop, too: at once */
        return;
    }
    d->start_wanted = false;
    d->permitted = false;
    d->stopping.since = d->sample.seq;
    d->stopping.moved = d->sample.seq;
    if (how == DRIVE_STOP_RAMP) {
        begin_ramp(d);
    } else {
        d->stopping.how = DRIVE_STOP_SHORT;
        drive_enter(d, DRIVE_SHORT);
    }
}

void drive_stop(drive_t *d) { drive_stop_by(d, (drive_stop_word_t)drive_newest_params(d)->stop_action); }

bool drive_stop_goes_on(drive_t *d)
{
    drive_stop_t *const s = &d->stopping;
    const uint32_t      now = d->sample.seq;
    if (s->how == DRIVE_STOP_COAST) {
        d->start_wanted = false; /* it runs already */
        return true;
    }
    if (d->start_wanted) { /* the stop is withdrawn; out of a short by way of a new start */
        d->start_wanted = s->how == DRIVE_STOP_SHORT;
        drive_stop_forget(d);
        return d->state == DRIVE_RUN;
    }
    if ((num_abs(d->speed.meas) > d->setup->motion.margin) || ((s->how == DRIVE_STOP_RAMP) && (d->speed.ramp.at != 0))) {
        s->moved = now;
    }
    const uint32_t longest = (uint32_t)(d->params->stop_s * (float)DRIVE_PWM_HZ);
    return ((now - s->moved) < RESTS_PERIODS) && ((now - s->since) < longest);
}

void drive_stop_forget(drive_t *d)
{
    const drive_stop_word_t how = d->stopping.how;
    d->stopping.how = DRIVE_STOP_COAST;
    if (how == DRIVE_STOP_RAMP) {
        (void)drive_command(d, &d->stopping.resume);
    }
}
