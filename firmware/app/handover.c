/* A changed parameter set on its way to the interrupts.
 *
 * Main loop    judges it, and sets up what has another kind or size: memories to clear, filters to start. That takes as long as
 *              it takes, so the bridge is off, and the interrupts keep away from those blocks (drive_withdraw).
 * Interrupt    takes the rest over between two samples: gains, limits, flags. No loop over a memory, no filter design. */
#include "firmware/app/internal.h"

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
    while ((k < (uint16_t)PARAM_COUNT) && !(drive_needs_rest(d, k) && (params_get(params, k) != params_get(&d->params, k)))) {
        k++;
    }
    return k;
}

bool drive_needs_rest(const drive_t *d, uint16_t param) { return drive_is_armed(d) && params_only_at_rest(param); }

uint16_t drive_shape_changes(const drive_setup_t *before, const drive_setup_t *s)
{
    uint16_t what = 0U;
    if (drive_repetitive_differs(before, s)) {
        what |= DRIVE_SHAPE_REPETITIVE;
    }
    if (drive_meter_differs(before, s)) {
        what |= DRIVE_SHAPE_METER;
    }
    if (drive_observer_differs(before, s)) {
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
    if ((what & DRIVE_SHAPE_REPETITIVE) != 0U) {
        d->setup.rc_used = false;
    }
    if ((what & DRIVE_SHAPE_METER) != 0U) {
        d->setup.meter_used = false;
    }
    if ((what & DRIVE_SHAPE_OBSERVER) != 0U) {
        d->setup.observer_used = false;
    }
}

static void rebuild(drive_t *d, uint16_t what)
{
    const drive_setup_t *const s = &d->next;
    if ((what & DRIVE_SHAPE_REPETITIVE) != 0U) {
        drive_build_repetitive(d, s);
    }
    if ((what & DRIVE_SHAPE_METER) != 0U) {
        drive_build_meter(d, s);
    }
    if ((what & DRIVE_SHAPE_OBSERVER) != 0U) {
        drive_build_observer(d, s);
    }
    if ((what & DRIVE_SHAPE_POSITION) != 0U) {
        drive_build_position_memory(d, s);
    }
}

bool drive_tune(drive_t *d, const drive_params_t *params, uint16_t *culprit)
{
    *culprit = PARAM_COUNT;
    if (d->next_ready != 0U) {
        return false;
    }
    *culprit = drive_make_setup(params, &d->next);
    if (*culprit == (uint16_t)PARAM_COUNT) {
        *culprit = held_param(d, params);
    }
    if (*culprit == (uint16_t)PARAM_COUNT) {
        *culprit = changed_base(&d->next.scale, &d->scale);
    }
    if (*culprit != (uint16_t)PARAM_COUNT) {
        return false;
    }
    const uint16_t shapes = drive_shape_changes(&d->setup, &d->next);
    if (shapes != 0U) {
        if (drive_is_armed(d)) { /* every parameter that leads here is AT_REST: this is for the one that forgets it */
            *culprit = PARAM_method;
            return false;
        }
        drive_withdraw(d, shapes);
        rebuild(d, shapes);
    }
    d->next_params = *params;
    d->next_ready = 1U;
    drive_command_again(d); /* its currents under the new limits */
    return true;
}

/* ---- current interrupt -------------------------------------------------------------------------------------------------- */

void drive_take_over(drive_t *d)
{
    const drive_setup_t *const s = &d->next;
    drive_take_over_repetitive(d, s);
    drive_take_over_observer(d, &d->setup, s);
    drive_take_over_position(d, s);
    if (s->deadbeat_used && !d->setup.deadbeat_used) {
        ctl_deadbeat_reset(&d->current.deadbeat);
    }
    if (s->encoder_reversed != d->setup.encoder_reversed) {
        d->tracking.known = DRIVE_ANGLE_UNKNOWN; /* the angle jumps: that is no lost encoder */
    }
    d->setup = *s;
    d->params = d->next_params;
    if (!d->tracking.zero_found) {
        d->tracking.zero_e = s->encoder_offset;
    }
    ctl_pi_tune(&d->current.d, &s->current_pi);
    ctl_pi_tune(&d->current.q, &s->current_pi);
    d->current.deadbeat.params = s->deadbeat;
    ctl_pi_tune(&d->speed.pi, &s->speed_pi);
    d->tracking.pll.params = s->pll;
    d->speed.mt.params = s->mt;
    d->next_ready = 0U;
}
