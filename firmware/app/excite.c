/* The excitation of a frequency response: judged, bounded, made part of the order. The sine is made where it acts, current_isr.c and
 * speed_isr.c. Main loop. */
#include "firmware/app/internal.h"

#define STEPS_PER_TURN 4294967296.0f
#define HZ_LEAST 0.01f
#define HZ_SHARE 0.45f /* of the sample rate: beyond it nothing tells a sine from its image */

static float size(float x) { return (x < 0.0f) ? -x : x; }

/* Something keeps what it sees over the angle, and would play the sine back. */
static bool learns(const drive_t *d, drive_mode_t mode)
{
    const drive_params_t *const p = &drive_newest(d)->params;
    const drive_setup_t *const  s = &drive_newest(d)->setup;
    if (p->observer_hold != 0U) {
        return false;
    }
    const drive_position_method_t how = s->position.method;
    const bool                    in_position = (how == DRIVE_POSITION_SILC) || (how == DRIVE_POSITION_SRC) || s->position.learns;
    const drive_observer_word_t   observer = drive_observer_asked(p);
    return s->speed.rc_used || (observer == DRIVE_OBSERVER_RO) || (observer == DRIVE_OBSERVER_ARO) ||
           ((mode == DRIVE_MODE_POSITION) && in_position);
}

/* Samples per second of where it acts. */
static float rate_hz(const drive_t *d, drive_excite_t where)
{
    const float between = (where == DRIVE_EXCITE_CURRENT) ? 0.0f : (float)drive_newest(d)->setup.speed.between;
    return (float)DRIVE_PWM_HZ / (between + 1.0f);
}

uint16_t drive_excite_refuses(const drive_t *d, const drive_excitation_t *e, float *low, float *high)
{
    const drive_params_t *const  p = &drive_newest(d)->params;
    const drive_command_t *const c = drive_active_command(d);
    *low = 0.0f;
    *high = 0.0f;
    if (e->where == DRIVE_EXCITE_NONE) {
        return DRIVE_EXCITE_FINE;
    }
    if ((d->state != DRIVE_RUN) || (d->stopping.how != DRIVE_STOP_COAST) || d->stop_wanted) {
        return DRIVE_EXCITE_STATE;
    }
    const bool here = !learns(d, c->mode);
    *high = here ? (float)((c->mode == DRIVE_MODE_SPEED) ? DRIVE_EXCITE_SPEED : DRIVE_EXCITE_CURRENT) : 0.0f;
    if ((float)e->where > *high) {
        return DRIVE_EXCITE_WHERE;
    }
    *high = (e->where == DRIVE_EXCITE_SPEED) ? (p->over_speed_rad_s - size(c->speed_ref_rad_s)) : p->iq_limit_a;
    if (!((e->amplitude > 0.0f) && (e->amplitude <= *high))) {
        return DRIVE_EXCITE_AMPLITUDE;
    }
    *low = HZ_LEAST;
    *high = HZ_SHARE * rate_hz(d, e->where);
    return ((e->hz >= *low) && (e->hz <= *high)) ? DRIVE_EXCITE_FINE : DRIVE_EXCITE_HZ;
}

static angle_t step_of(const drive_t *d, const drive_excitation_t *e)
{
    return (angle_t)(e->hz / rate_hz(d, e->where) * STEPS_PER_TURN); /* less than half of 2^32: drive_excite_refuses */
}

void drive_order_excitation(drive_t *d, drive_order_t *order)
{
    float                     limit[2];
    drive_excitation_t *const e = &d->excitation;
    if (drive_excite_refuses(d, e, &limit[0], &limit[1]) != DRIVE_EXCITE_FINE) {
        e->where = DRIVE_EXCITE_NONE;
    }
    const bool torque = e->where == DRIVE_EXCITE_TORQUE;
    const bool current = e->where == DRIVE_EXCITE_CURRENT;
    const bool speed = e->where == DRIVE_EXCITE_SPEED;
    order->excite_step = (e->where != DRIVE_EXCITE_NONE) ? step_of(d, e) : 0U;
    order->excite_held = torque ? drive_per_base(e->amplitude, d->scale.inv_current) : (num_t)0;
    order->excite_iq = current ? drive_per_base(e->amplitude, d->scale.inv_current) : (num_t)0;
    order->excite_rad_s = speed ? e->amplitude : 0.0f;
    order->ramp |= speed ? DRIVE_SPEED_EXCITED : 0U;
    order->plain = !(order->torque || torque || current);
}

uint16_t drive_excite(drive_t *d, const drive_excitation_t *e, float *low, float *high, float *hz)
{
    const uint16_t bad = drive_excite_refuses(d, e, low, high);
    *hz = 0.0f;
    if (bad == DRIVE_EXCITE_FINE) {
        d->excitation = *e;
        drive_command_again(d);
        if (e->where != DRIVE_EXCITE_NONE) {
            *hz = (float)step_of(d, e) / STEPS_PER_TURN * rate_hz(d, e->where);
        }
    }
    return bad;
}

float drive_excitation_a(const drive_t *d)
{
    const drive_order_t *const order = drive_active_order(d);
    const bool acts = (d->state == DRIVE_RUN) && ((order->excite_held != (num_t)0) || (order->excite_iq != (num_t)0));
    return acts ? (num_to_float(d->current.excitation) * d->scale.current_a) : 0.0f;
}
