/* A changed parameter set on its way to the interrupts.
 *
 * Main loop    makes it into the set that is not in force, and judges it. What has another kind or size, memories to clear and
 *              filters to start, takes as long as it takes: the bridge is off, and the interrupts keep away from those blocks
 *              (drive_withdraw). What a running block needs besides numbers is prepared where the block does not look.
 * Interrupt    switches to that set between two samples: take_over.c. */
#include "firmware/app/internal.h"
#include "firmware/app/memory_check.h"

static drive_set_t *in_force(drive_t *d) { return (d->setup == &d->set[0].setup) ? &d->set[0] : &d->set[1]; }
static drive_set_t *idle_set(drive_t *d) { return (d->setup == &d->set[0].setup) ? &d->set[1] : &d->set[0]; }

const drive_params_t *drive_newest_params(const drive_t *d) { return &drive_newest(d)->params; }

/* A new base would rescale every state: only drive_init does that. All bases are 1 in the float build. */
static uint16_t changed_base(const drive_scale_t *wanted, const drive_scale_t *used)
{
    if (wanted->current_a != used->current_a) {
        return PARAM_over_current_a;
    }
    if (wanted->voltage_v != used->voltage_v) {
        return PARAM_over_voltage_v;
    }
    if (wanted->speed_rad_s != used->speed_rad_s) {
        return PARAM_over_speed_rad_s;
    }
    return (wanted->error_unit != used->error_unit) ? (uint16_t)PARAM_speed_error_gain : (uint16_t)PARAM_COUNT;
}

/* ---- main loop -------------------------------------------------------------------------------------------------------- */

static uint16_t held_param(const drive_t *d, const drive_params_t *params)
{
    uint16_t k = 0U;
    while ((k < (uint16_t)PARAM_COUNT) && !(drive_needs_rest(d, k) && (params_get(params, k) != params_get(d->params, k)))) {
        k++;
    }
    return k;
}

bool drive_needs_rest(const drive_t *d, uint16_t param) { return drive_is_armed(d) && params_only_at_rest(param); }

uint16_t drive_shape_changes(const drive_setup_t *before, const drive_setup_t *s)
{
    uint16_t what = 0U;
    if (drive_repetitive_differs(&before->speed, &s->speed)) {
        what |= DRIVE_SHAPE_REPETITIVE;
    }
    if (drive_meter_differs(&before->observer, &s->observer)) {
        what |= DRIVE_SHAPE_METER;
    }
    if (drive_observer_differs(&before->observer, &s->observer)) {
        what |= DRIVE_SHAPE_OBSERVER;
    }
    if (drive_position_differs(before, s)) {
        what |= DRIVE_SHAPE_POSITION;
    }
    return what;
}

/* The flags that lead the interrupts to these blocks, each one word. The bridge is off: what runs only in RUN is not asked for
 * until the main loop, which is here, arms it again. */
void drive_withdraw(drive_t *d, uint16_t what)
{
    drive_setup_t *const s = &in_force(d)->setup;
    if ((what & DRIVE_SHAPE_REPETITIVE) != 0U) {
        s->speed.rc_used = false;
    }
    if ((what & DRIVE_SHAPE_METER) != 0U) {
        s->observer.meter_used = false;
    }
    if ((what & DRIVE_SHAPE_OBSERVER) != 0U) {
        s->observer.used = false;
    }
    drive_keep_set(d, in_force(d));
    hal_order(); /* before what follows is written */
}

static void rebuild(drive_t *d, const drive_setup_t *s, uint16_t what)
{
    if ((what & DRIVE_SHAPE_REPETITIVE) != 0U) {
        drive_build_repetitive(&d->speed, &s->speed, d->rc_memory);
    }
    if ((what & DRIVE_SHAPE_METER) != 0U) {
        drive_build_meter(&d->observer, &s->observer);
    }
    if ((what & DRIVE_SHAPE_OBSERVER) != 0U) {
        drive_build_observer(&d->observer, &s->observer, d->observer_memory);
    }
    if ((what & DRIVE_SHAPE_POSITION) != 0U) {
        drive_build_position_memory(&d->position, s, d->observer_memory, (uint16_t)DRIVE_OBSERVER_CAPACITY);
    }
}

/* What the blocks that run on need besides numbers. */
static void prepare(drive_t *d, const drive_setup_t *s, uint16_t shapes)
{
    if (s->speed.rc_used && ((shapes & DRIVE_SHAPE_REPETITIVE) == 0U)) {
        ctl_rc_prepare(&d->speed.rc, &s->speed.rc);
    }
    if (s->observer.meter_used) {
        ctl_meter_prepare(&d->observer.meter, &s->observer.meter);
    }
    if (s->observer.used) {
        ctl_observer_prepare(&d->observer.observer, &s->observer.observer);
    }
}

bool drive_tune(drive_t *d, const drive_params_t *params, uint16_t *culprit)
{
    *culprit = PARAM_COUNT;
    if (d->next_ready != 0U) {
        return false;
    }
    drive_set_t *const   next = idle_set(d);
    drive_setup_t *const s = &next->setup;
    *culprit = drive_make_setup(params, s);
    if (*culprit == (uint16_t)PARAM_COUNT) {
        *culprit = held_param(d, params);
    }
    if (*culprit == (uint16_t)PARAM_COUNT) {
        *culprit = changed_base(&s->scale, &d->scale);
    }
    const drive_mode_t mode = drive_active_command(d)->mode;
    if ((*culprit == (uint16_t)PARAM_COUNT) && ((s->speed.rc_used && (mode == DRIVE_MODE_POSITION)) ||
                                                ((s->speed.rc_used || s->observer.used) && (mode == DRIVE_MODE_TORQUE)))) {
        *culprit = PARAM_method; /* as drive_command refuses it the other way round */
    }
    if (*culprit != (uint16_t)PARAM_COUNT) {
        return false;
    }
    const uint16_t shapes = drive_shape_changes(d->setup, s);
    if (shapes != 0U) {
        if (drive_is_armed(d)) { /* every parameter that leads here is AT_REST: this is for the one that forgets it */
            *culprit = PARAM_method;
            return false;
        }
        drive_withdraw(d, shapes);
        rebuild(d, s, shapes);
    }
    prepare(d, s, shapes);
    if (drive_correction_differs(&d->setup->sensors, &s->sensors)) { /* at rest: the bridge is off */
        drive_build_correction(&d->sensors, &s->sensors, &s->scale);
    }
    s->tracking.moves = s->tracking.encoder_reversed != d->setup->tracking.encoder_reversed;
    if (ctl_fourier_differs(&d->setup->tracking.error, &s->tracking.error)) { /* at rest */
        s->tracking.moves = true;
        d->zero.found = false; /* it was found with another angle */
    }
    if (!d->zero.found) {
        d->zero.e = s->tracking.encoder_offset; /* another one only at rest */
    }
    next->params = *params;
    drive_keep_set(d, next);
    d->next = next;
    hal_order();
    d->next_ready = 1U;
    drive_command_again(d); /* its currents under the new limits */
    return true;
}
