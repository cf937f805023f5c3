/* init -> offset calibration -> align -> ready -> run, and fault from anywhere. One pass of the main loop each. */
#include <string.h>

#include "firmware/app/internal.h"
#include "hal/hal_inverter.h"

/* The current interrupt may have tripped since the state was looked at, even between arming and here. It writes `fault`
 * first and `state` after it, this the other way round: whoever comes last leaves FAULT. */
static void enter(drive_t *d, drive_state_t state)
{
    d->periods_in_state = 0U;
    d->state = state;
    if (d->fault != FAULT_none) {
        drive_trip(d, d->fault);
    }
}

static void enter_armed(drive_t *d, drive_state_t state)
{
    drive_rest(d);
    if (hal_inverter_arm() == HAL_OK) {
        enter(d, state);
    } else {
        drive_trip(d, FAULT_gate_driver);
    }
}

static void after_calibration(drive_t *d)
{
    if (d->params.align_periods > 0U) {
        if (d->held) {
            enter(d, DRIVE_INIT);
        } else {
            enter_armed(d, DRIVE_ALIGN);
        }
    } else {
        d->tracking.zero_e = d->setup.encoder_offset;
        d->tracking.zero_found = false;
        d->started_up = true;
        enter(d, DRIVE_READY);
    }
}

static bool too_large(float x, float limit)
{
    return !((x <= limit) && (x >= -limit));
}

static void finish_calibration(drive_t *d)
{
    if (d->sum_count == 0U) { /* tuned to no calibration in the meantime */
        after_calibration(d);
        return;
    }
    const float n = (float)d->sum_count;
    const float a = d->sum_a_a / n;
    const float b = d->sum_b_a / n;
    const float c = d->sum_c_a / n;
    const float limit = d->params.offset_limit_a;
    if (too_large(a, limit) || too_large(b, limit) || too_large(c, 2.0f * limit)) { /* ic may be the negative sum of two */
        drive_trip(d, FAULT_offset_calibration);
        return;
    }
    d->offset_a_a = a;
    d->offset_b_a = b;
    d->offset_c_a = c;
    after_calibration(d);
}

static void finish_alignment(drive_t *d)
{
    hal_inverter_disarm();
    /* the d axis lies on phase a now: what the encoder shows is electrical zero */
    d->tracking.zero_e = 0U - (d->tracking.theta_m * d->setup.pole_pairs);
    d->tracking.zero_found = true;
    d->tracking.zero_pole_pairs = d->setup.pole_pairs;
    d->tracking.zero_reversed = d->setup.encoder_reversed;
    d->started_up = d->fault == FAULT_none;
    enter(d, DRIVE_READY);
}

static void leave_fault(drive_t *d)
{
    hal_inverter_clear_fault();
    if (d->fault == FAULT_configuration) {
        return; /* only new parameters help: drive_init */
    }
    const bool encoder = drive_zero_in_doubt(d->fault);
    d->fault = FAULT_none;
    d->lost_samples = 0U;
    d->bad_samples = 0U;
    d->tracking.jump_periods = 0U;
    enter(d, (d->started_up && !encoder) ? DRIVE_READY : DRIVE_INIT);
}

/* The electrical zero that an alignment has found belongs to the pole pairs and the direction that it was found with. */
static bool zero_is_stale(const drive_t *d)
{
    const drive_tracking_t *const t = &d->tracking;
    return t->zero_found && ((t->zero_pole_pairs != d->setup.pole_pairs) || (t->zero_reversed != d->setup.encoder_reversed));
}

static void wait_for_start(drive_t *d)
{
    if (d->next_ready != 0U) {
        return; /* what is being changed may be what a start stands on: first the current interrupt takes it over */
    }
    if (zero_is_stale(d)) {
        enter(d, DRIVE_INIT);
        return;
    }
    if (d->start_wanted || ((d->params.auto_run != 0U) && !d->held)) {
        enter_armed(d, DRIVE_RUN);
        drive_restart_timing(d); /* the figures of a run are not those of the start-up before it */
    }
    d->start_wanted = false;
}

/* What the observer is told and asked at leisure. */
static void attend_observer(drive_t *d)
{
    if (d->setup.observer_used) {
        ctl_observer_target(&d->observer.observer, drive_per_base(drive_active_command(d)->speed_ref_rad_s, d->scale.inv_speed));
        ctl_observer_look(&d->observer.observer);
    }
}

void drive_background(drive_t *d)
{
    if (d->stop_wanted) {
        d->start_wanted = false;
        d->held = true;
    } else if (d->start_wanted) {
        d->held = false;
    }
    switch (d->state) {
    case DRIVE_INIT:
        d->started_up = false;
        if (d->held) {
            break;
        }
        if (d->params.offset_calibration_periods > 0U) {
            d->sum_a_a = 0.0f;
            d->sum_b_a = 0.0f;
            d->sum_c_a = 0.0f;
            d->sum_count = 0U;
            enter(d, DRIVE_OFFSET_CALIBRATION);
        } else {
            after_calibration(d);
        }
        break;
    case DRIVE_OFFSET_CALIBRATION:
        if (d->sum_count >= d->params.offset_calibration_periods) {
            finish_calibration(d);
        }
        break;
    case DRIVE_ALIGN:
        if (d->stop_wanted) {
            hal_inverter_disarm();
            enter(d, DRIVE_INIT);
        } else if (d->periods_in_state >= d->params.align_periods) {
            finish_alignment(d);
        }
        break;
    case DRIVE_READY:
        wait_for_start(d);
        break;
    case DRIVE_RUN:
        d->start_wanted = false;
        if (d->stop_wanted) {
            hal_inverter_disarm();
            enter(d, DRIVE_READY);
        }
        break;
    case DRIVE_FAULT:
    default:
        hal_inverter_disarm();
        d->start_wanted = false;
        if (d->clear_wanted) {
            leave_fault(d);
        }
        break;
    }
    d->stop_wanted = false;
    d->clear_wanted = false;
    if (!drive_is_armed(d)) {
        drive_command_nothing(d); /* what was commanded last does not act any more */
    }
    attend_observer(d);
}

void drive_init(drive_t *d, const drive_params_t *params)
{
    hal_inverter_disarm();
    (void)memset(d, 0, sizeof *d); /* zero bits are 0, 0.0f and false on every machine that runs this */
    d->params = *params;
    timing_restart(&d->timing);
    const uint16_t bad = drive_build(d);
    if (bad != (uint16_t)PARAM_COUNT) {
        d->fault_detail = bad;
        drive_trip(d, FAULT_configuration);
    }
}

void drive_start(drive_t *d) { d->start_wanted = true; }
void drive_stop(drive_t *d) { d->stop_wanted = true; }
void drive_clear_fault(drive_t *d) { d->clear_wanted = true; }
void drive_home(drive_t *d) { d->home_wanted = true; }
void drive_restart_timing(drive_t *d) { timing_restart(&d->timing); }
