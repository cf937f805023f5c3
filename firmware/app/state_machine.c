/* init -> offset calibration -> ready; with a start, and only then, [align -> ready ->] run; and fault from anywhere. One pass of
 * the main loop each. */
#include <string.h>

#include "firmware/app/internal.h"
#include "firmware/app/memory_check.h"
#include "hal/hal_inverter.h"

/* The current interrupt may have tripped since the state was read, even between arming and here. It writes `fault`
 * first and `state` after it, this in the opposite order: whoever comes last leaves FAULT. */
void drive_enter(drive_t *d, drive_state_t state)
{
    d->state = state;
    if (d->fault != FAULT_none) {
        drive_trip(d, d->fault);
    }
}

/* The only place that arms the bridge, and only by a start's permit. */
static bool arm(drive_t *d)
{
    if (!d->permitted) {
        return false;
    }
    if (!(drive_start_surge_a(d) <= drive_start_surge_max_a(d))) {
        drive_trip(d, FAULT_start_turning);
        return false;
    }
    drive_rest(d);
    drive_preset_voltage(d);
    drive_keep_zero(d);
    if (hal_inverter_arm() != HAL_OK) {
        drive_check_hardware(d);          /* its reason, */
        drive_trip(d, FAULT_gate_driver); /* if it has one */
        return false;
    }
    d->kept.bridge = true;
    return true;
}

static void disarm(drive_t *d)
{
    hal_inverter_disarm();
    d->kept.bridge = false;
}

static void finish_start_up(drive_t *d)
{
    d->started_up = true;
    drive_enter(d, DRIVE_READY);
}

static bool too_large(float x, float limit) { return !((x <= limit) && (x >= -limit)); }

static void finish_calibration(drive_t *d)
{
    if (d->sum_count == 0U) { /* tuned to no calibration in the meantime */
        finish_start_up(d);
        return;
    }
    const float n = (float)d->sum_count;
    const float a = d->sum_a_a / n;
    const float b = d->sum_b_a / n;
    const float c = d->sum_c_a / n;
    const float limit = d->params->offset_limit_a;
    if (too_large(a, limit) || too_large(b, limit) || too_large(c, 2.0f * limit)) { /* ic may be the negative sum of two */
        drive_trip(d, FAULT_offset_calibration);
        return;
    }
    d->offset_a_a = a;
    d->offset_b_a = b;
    d->offset_c_a = c;
    finish_start_up(d);
}

/* From here on the parameter counts, until an alignment. */
static void forget_zero(drive_t *d)
{
    drive_forget_index(d);
    d->zero.found = false;
    d->zero.e = drive_newest(d)->setup.tracking.encoder_offset;
}

static void finish_alignment(drive_t *d)
{
    disarm(d);
    if (d->fault != FAULT_none) {
        drive_enter(d, DRIVE_FAULT); /* one that came just now */
        return;
    }
    const drive_align_result_t found = drive_align_judge(d);
    if (found.fault != FAULT_none) {
        d->fault_detail = found.detail;
        drive_trip(d, found.fault);
        return;
    }
    d->zero.e = found.zero_e;
    d->zero.found = true;
    d->zero.pole_pairs = d->setup->tracking.pole_pairs;
    d->zero.reversed = d->setup->tracking.encoder_reversed;
    drive_enter(d, DRIVE_READY); /* where the start still waits */
}

static void align(drive_t *d)
{
    if (d->stop_wanted) {
        disarm(d);
        drive_enter(d, DRIVE_READY);
    } else if (d->align.phase == (uint16_t)DRIVE_ALIGN_DONE) {
        finish_alignment(d);
    } else if ((d->align.phase == (uint16_t)DRIVE_ALIGN_RESTS) && arm(d)) {
        drive_align_pull(d);
        drive_enter(d, DRIVE_ALIGN);
    } else {
        /* the current interrupt is at it */
    }
}

static void leave_fault(drive_t *d)
{
    hal_inverter_clear_fault();
    if ((d->fault == FAULT_configuration) || ((d->fault == FAULT_memory_changed) && !drive_recover_memory(d))) {
        return; /* only new parameters help: drive_init */
    }
    if (drive_fault_voids_zero(d->fault)) {
        forget_zero(d);
    }
    if (d->fault != FAULT_safe_torque_off) { /* who opens a guard has not overloaded anything */
        drive_note_clear(d);
    }
    d->fault = FAULT_none;
    d->fault_detail = 0U;
    d->lost_samples = 0U;
    d->bad_samples = 0U;
    d->tracking.jump_periods = 0U;
    drive_enter(d, d->started_up ? DRIVE_READY : DRIVE_INIT);
}

/* The electrical zero that an alignment has found belongs to the pole pairs and the direction that it was found with. */
static bool zero_is_stale(const drive_t *d)
{
    const drive_zero_t *const z = &d->zero;
    return z->found && ((z->pole_pairs != d->setup->tracking.pole_pairs) || (z->reversed != d->setup->tracking.encoder_reversed));
}

bool drive_zero_is_known(const drive_t *d) { return d->zero.found || (d->params->align_periods == 0U); }

static void wait_for_start(drive_t *d)
{
    if (d->next_ready != 0U) {
        return; /* what is being changed may be what a start stands on: first the current interrupt takes it over */
    }
    if (zero_is_stale(d)) {
        forget_zero(d);
    }
    if (!d->start_wanted || !drive_may_restart(d)) {
        return;
    }
    if (!drive_zero_is_known(d)) {
        drive_align_begin(d);
        drive_enter(d, DRIVE_ALIGN);
        return; /* the start waits */
    }
    d->start_wanted = false;
    if (arm(d)) {
        drive_enter(d, DRIVE_RUN);
        drive_restart_timing(d); /* the figures of a run are not those of the start-up before it */
    }
}

/* Background work of the observer: target speed, the order of the encoder's rounding or its drift, quality figure. */
static void attend_observer(drive_t *d)
{
    num_t drift = (num_t)0;
    if (d->setup->observer.used) {
        const drive_command_t *const c = drive_active_command(d);
        const num_t target = (c->mode == DRIVE_MODE_POSITION) ? d->position.setpoint.speed
                                                              : drive_per_base(c->speed_ref_rad_s, d->scale.inv_speed);
        ctl_observer_let_drift(&d->observer.observer,
                               (d->setup->observer.observer.drift_most > 0U) && (c->mode == DRIVE_MODE_SPEED));
        ctl_observer_target(&d->observer.observer, target);
        ctl_observer_keep_rounding(&d->observer.observer);
        ctl_observer_update_quality(&d->observer.observer);
        drift = num_mul(ctl_observer_drift(&d->observer.observer), d->setup->speed.error_scale);
    }
    d->speed.drift = drift;
}

void drive_background(drive_t *d)
{
    drive_check_memory(d);
    timing_check(&d->timing, d->setup->period_cyc);
    if (drive_is_armed(d) || (d->fault == FAULT_gate_driver)) {
        drive_check_hardware(d); /* here as well: the current interrupt may be what has stopped */
    }
    if (d->stop_wanted) {
        d->start_wanted = false;
        d->permitted = false;
    } else if (d->start_wanted) {
        d->permitted = true;
    } else {
        /* as it was */
    }
    switch (d->state) {
    case DRIVE_INIT:
        d->started_up = false;
        forget_zero(d);
        if (d->params->offset_calibration_periods > 0U) {
            d->sum_a_a = 0.0f;
            d->sum_b_a = 0.0f;
            d->sum_c_a = 0.0f;
            d->sum_count = 0U;
            drive_enter(d, DRIVE_OFFSET_CALIBRATION);
        } else {
            finish_start_up(d);
        }
        break;
    case DRIVE_OFFSET_CALIBRATION:
        if (d->sum_count >= d->params->offset_calibration_periods) {
            finish_calibration(d);
        }
        break;
    case DRIVE_ALIGN:
        align(d);
        break;
    case DRIVE_READY:
        wait_for_start(d);
        break;
    case DRIVE_RUN:
    case DRIVE_SHORT:
        if (d->stop_wanted || !drive_stop_goes_on(d)) {
            disarm(d);
            drive_enter(d, DRIVE_READY);
        }
        break;
    case DRIVE_FAULT:
    default:
        disarm(d);
        d->start_wanted = false;
        d->permitted = false;
        if (d->clear_wanted) {
            leave_fault(d);
        }
        break;
    }
    d->stop_wanted = false;
    d->clear_wanted = false;
    if (!drive_is_armed(d)) {
        drive_stop_forget(d);
        drive_command_nothing(d); /* what was commanded last does not act any more */
        if (d->excitation.where != DRIVE_EXCITE_NONE) {
            drive_command_again(d); /* without it */
        }
    }
    drive_attend_sto(d);
    attend_observer(d);
    drive_attend_correction(d);
    drive_attend_thermal(d);
    drive_attend_stall(d);
    drive_attend_restarts(d);
    drive_attend_index(d);
}

void drive_init(drive_t *d, const drive_params_t *params)
{
    hal_inverter_disarm();
    (void)memset(d, 0, sizeof *d); /* zero bits are 0, 0.0f and false on every machine that runs this */
    d->params = &d->set[0].params;
    d->setup = &d->set[0].setup;
    d->set[0].params = *params;
    timing_restart(&d->timing);
    const uint16_t bad = drive_build(d);
    if (bad != (uint16_t)PARAM_COUNT) {
        d->fault_detail = bad;
        drive_trip(d, FAULT_configuration);
    }
}

void drive_start(drive_t *d) { d->start_wanted = true; }
void drive_clear_fault(drive_t *d) { d->clear_wanted = true; }
void drive_home(drive_t *d) { d->home_wanted = true; }
void drive_restart_timing(drive_t *d) { timing_restart(&d->timing); }
