/* The current interrupt's share of a changed parameter set: handover.c has the main loop's. It switches to the other set and hands
 * the blocks their numbers; no memory is cleared, no filter designed, and what integrates or has learned goes on. */
#include "firmware/app/internal.h"

static void retune_current(drive_current_t *c, const drive_current_setup_t *s, bool deadbeat_before)
{
    ctl_pi_tune_gains(&c->d, &s->pi); /* the limits of an axis are constants: DRIVE_AXIS_BOUND */
    ctl_pi_tune_gains(&c->q, &s->pi);
    if (s->deadbeat_used && !deadbeat_before) {
        ctl_deadbeat_reset(&c->deadbeat);
    }
}

static void retune_tracking(drive_tracking_t *t, const drive_tracking_setup_t *s)
{
    t->pll.params = s->pll;
    if (s->moves) {
        t->known = DRIVE_ANGLE_UNKNOWN;
    }
}

static void retune_speed(drive_speed_t *v, const drive_speed_setup_t *s, bool notched_before)
{
    ctl_pi_tune(&v->pi, &s->pi);
    if (!notched_before) {
        ctl_notch_reset(&v->notch, v->pi.state.x);
    }
    v->mt.params = s->mt;
    if (s->rc_used) {
        ctl_rc_take_prepared(&v->rc, &s->rc);
    } else {
        v->correction = (num_t)0;
    }
}

static void retune_observer(drive_observer_t *o, const drive_observer_setup_t *s)
{
    if (s->meter_used) {
        ctl_meter_take_prepared(&o->meter, &s->meter);
    }
    if (s->used) {
        ctl_observer_take_prepared(&o->observer, &s->observer);
        ctl_observer_hold(&o->observer, s->hold);
    } else {
        o->estimate = (num_t)0;
    }
}

static void retune_position(drive_position_t *o, const drive_position_setup_t *q)
{
    ctl_pi_tune(&o->pi, &q->velocity_pi);
    if (q->method == DRIVE_POSITION_RDC) {
        o->learn.params = q->learn;
    } else if (q->method == DRIVE_POSITION_SILC) {
        o->ilc.params = q->ilc;
    } else if (q->method == DRIVE_POSITION_SRC) {
        o->src.params = q->src;
    } else {
        /* ppi learns nothing */
    }
}

/* The flux of the last sample was that of another motor. */
static inline void retune_plausibility(ctl_plausibility_state_t *state, const ctl_plausibility_params_t *now,
                                       const ctl_plausibility_params_t *before)
{
    if ((now->psi != before->psi) | (now->ld != before->ld) | (now->lq != before->lq) | (now->r_half != before->r_half)) {
        ctl_plausibility_restart(state);
    }
}

void drive_take_over(drive_t *d)
{
    const drive_set_t *const   next = d->next;
    const drive_setup_t *const s = &next->setup;
    retune_current(&d->current, &s->current, d->setup->current.deadbeat_used);
    retune_tracking(&d->tracking, &s->tracking);
    retune_speed(&d->speed, &s->speed, d->setup->speed.notched);
    retune_observer(&d->observer, &s->observer);
    retune_position(&d->position, &s->position);
    retune_plausibility(&d->plausibility, &s->plausibility.run, &d->setup->plausibility.run);
    d->params = &next->params;
    d->setup = s;
    d->next_ready = 0U;
}
