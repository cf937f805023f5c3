/* The 1 kHz loop: in its own interrupt, or inside the current interrupt (parameter speed_inline). */
#include <stddef.h>

#include "firmware/app/internal.h"

/* What the angle error makes of the speed, in the middle of the sample, which is what counts over time are the mean of. */
static num_t without_angle_error(const drive_t *d, num_t speed)
{
    const angle_t before = (angle_t)(uint64_t)d->position.raw;
    num_t         slope;
    (void)ctl_fourier(&d->setup->tracking.error, before + (angle_t)((int32_t)(d->tracking.theta_m - before) / 2), &slope);
    return num_sub(speed, num_mul(speed, slope));
}

static num_t measure_speed(drive_t *d)
{
    drive_speed_t *const s = &d->speed;
    if (hal_encoder_edge(&s->edge) == HAL_SENSOR_FAULT) {
        drive_trip(d, FAULT_encoder_error);
    }
    const num_t mt = ctl_mt_step(&s->mt, s->edge.edge_count, s->edge.edge_cyc, s->now_cyc);
    if (d->setup->speed.source != DRIVE_SPEED_MT) {
        return (d->setup->speed.source == DRIVE_SPEED_FIR) ? d->observer.seen.speed : d->tracking.pll.state.w;
    }
    const num_t speed = d->setup->tracking.encoder_reversed ? num_neg(mt) : mt;
    return d->setup->tracking.corrects ? without_angle_error(d, speed) : speed;
}

/* The tracking filter, which the current interrupt judges in every sample, lags by acceleration times kp / ki: 290 rad/s at
 * 54000 rad/s^2, which a bare servo motor reaches when its electrical zero is wrong. So the mean speed since the last tick counts,
 * too, where both ways to it agree: M/T knows of lost samples, the tracked angle of an encoder that slips. */
static void check_over_speed(drive_t *d)
{
    const num_t speed = num_min(num_abs(d->speed.mt.state.speed), num_abs(d->position.speed));
    if (drive_si(speed, d->scale.speed_rad_s) > d->setup->limits.over_speed_rad_s) {
        drive_trip(d, FAULT_over_speed);
    }
}

static num_t ripple_correction(drive_t *d, const drive_speed_setup_t *setup, num_t error, num_t ref)
{
    if (!setup->rc_used) {
        return d->speed.drift;
    }
    uint16_t whole = 0U;
    num_t    fraction = (num_t)0;
    if (!ctl_rc_period_unchecked(&d->speed.rc, setup->rc_period_scale, num_abs(ref), &whole, &fraction)) {
        return (num_t)0; /* too slow for the memory, or no reference: the controller rests and keeps what it knows */
    }
    return num_add(ctl_rc_step_unchecked(&d->speed.rc, error, whole, fraction, d->speed.theta_e), d->speed.drift);
}

/* The reference that the loop follows: all of it, or part at once and the rest through the low-pass kp / ki, which cancels the zero
 * of the PI controller. As a filter in front, so that the integral part holds torque and nothing else. */
static inline num_t weighted(drive_speed_t *s, const drive_speed_setup_t *setup, num_t ref)
{
    if (!setup->weighted) {
        return ref;
    }
    const num_t missing = num_sub(ref, s->followed);
    const num_t used = num_mac(s->followed, setup->weight, missing);
    s->followed =
        num_mac(s->followed, setup->follow, missing); /* as the integral part: what is new acts from the next sample on */
    return used;
}

/* Torque that friction and the lines over the angle ask for, where the shaft will be when it acts. */
static inline num_t model_torque(drive_t *d, num_t ref)
{
    const ctl_rdc_params_t *const p = &d->setup->position.rdc;
    const int32_t                 ahead = (int32_t)angle_step_from_rad_unchecked(num_mul(ref, d->setup->speed.lead_rad));
    const num_t known = num_add(ctl_friction_unchecked(&p->friction, ref), ctl_harmonics(&p->harmonics, d->position.now + ahead));
    d->speed.fed = num_sub(known, num_mul(p->friction.viscous, ref));
    return known;
}

/* The reference on its way to the speed asked for: from the speed there is when speed mode or the ramp begins. */
static float ramped(drive_t *d, const ctl_ramp_params_t *ramp, const drive_command_t *cmd)
{
    drive_speed_t *const s = &d->speed;
    const int64_t        target = drive_active_order(d)->speed;
    if (!s->ramping) {
        ctl_ramp_reset(&s->ramp, drive_ramp_steps(drive_si(s->meas, d->scale.speed_rad_s)));
        s->ramping = true;
    }
    const int64_t at = ctl_ramp_step_unchecked(ramp, &s->ramp, target);
    return (at == target) ? cmd->speed_ref_rad_s : (ctl_float_of_long(at) * (1.0f / DRIVE_RAMP_STEPS));
}

/* Any other reference than the one commanded: along a ramp, with an excitation on top, or both. */
static float on_its_way(drive_t *d, uint16_t how, const drive_command_t *cmd)
{
    drive_speed_t *const s = &d->speed;
    float                ref = cmd->speed_ref_rad_s;
    if ((how & (uint16_t)~DRIVE_SPEED_EXCITED) != 0U) {
        ref = ramped(d, ((how & DRIVE_RAMP_STOP) != 0U) ? &d->setup->speed.stop_ramp : &d->setup->speed.ramp, cmd);
    } else {
        s->ramping = false;
    }
    if ((how & DRIVE_SPEED_EXCITED) != 0U) {
        const drive_order_t *const order = drive_active_order(d);
        num_t                      sine;
        num_t                      cosine;
        s->excite_phase += order->excite_step;
        angle_sincos(s->excite_phase, &sine, &cosine);
        ref += order->excite_rad_s * num_to_float(sine);
    }
    return ref;
}

/* Torque as it is asked for between two limits of the speed. */
static void follow_torque(drive_t *d, const drive_command_t *cmd)
{
    drive_speed_t *const             s = &d->speed;
    const drive_speed_setup_t *const setup = &d->setup->speed;
    const drive_order_t *const       order = drive_active_order(d);
    const ctl_speed_bound_params_t   p = {setup->pi.kp, setup->pi.ki_ts, setup->follow};
    const num_t                      high = num_mul(num_sub(order->speed_limit, s->meas), setup->error_scale);
    const num_t                      low = num_mul(num_sub(num_neg(order->speed_limit), s->meas), setup->error_scale);
    if (!s->bounded) {
        s->bound.x = s->pi.state.x; /* the torque of speed or position mode */
        s->bounded = true;
    }
    s->ref_rad_s = cmd->speed_ref_rad_s;
    s->error = (order->iq < (num_t)0) ? low : high;
    s->iq_ref = drive_within_room(d, ctl_speed_bound_step(&p, &s->bound, order->iq, low, high, drive_torque_room(d)));
    ctl_pi_reset(&s->pi, s->iq_ref); /* speed mode goes on with this torque */
}

/* Speed mode begins with the speed and the torque there are. */
static inline void rest_speed_mode(drive_speed_t *s)
{
    s->correction = (num_t)0;
    s->ramping = false;
    s->followed = s->meas;
    ctl_notch_reset(&s->notch, s->pi.state.x);
}

static inline void step(drive_t *d)
{
    const drive_command_t *const cmd = drive_active_command(d);
    drive_speed_t *const         s = &d->speed;

    s->meas = measure_speed(d);
    drive_check_motion(d);
    drive_position_measure(d);
    check_over_speed(d);
    if ((d->state == DRIVE_RUN) && (cmd->mode == DRIVE_MODE_POSITION)) {
        drive_position_step(d, cmd);
        s->bounded = false;
        rest_speed_mode(s);
        return;
    }
    d->position.active = false;
    s->fed = (num_t)0;
    if ((d->state != DRIVE_RUN) || (cmd->mode != DRIVE_MODE_SPEED)) {
        if ((d->state == DRIVE_RUN) && (cmd->mode == DRIVE_MODE_TORQUE)) {
            follow_torque(d, cmd);
        } else {
            s->bounded = false;
            ctl_pi_reset(&s->pi, (num_t)0); /* entering current mode clears the controller */
            s->iq_ref = (num_t)0;
        }
        rest_speed_mode(s);
        return;
    }
    const uint16_t how = drive_active_order(d)->ramp;
    s->bounded = false;
    if (how != DRIVE_RAMP_NONE) {
        s->ref_rad_s = on_its_way(d, how, cmd);
    } else {
        s->ref_rad_s = cmd->speed_ref_rad_s;
        s->ramping = false;
    }
    const drive_speed_setup_t *const setup = &d->setup->speed; /* one load: stores in between might change the pointer */
    const num_t                      ref = drive_per_base(s->ref_rad_s, d->scale.inv_speed);
    d->motion.asked = ref;

    s->error = num_mul(num_sub(weighted(s, setup, ref), s->meas), setup->error_scale);
    s->correction = ripple_correction(d, setup, s->error, ref);
    const num_t feedback = ctl_pi_output(&s->pi, num_add(s->error, s->correction));
    num_t       torque = setup->notched ? ctl_notch_step_unchecked(&setup->notch, &s->notch, feedback) : feedback;
    if (setup->feeds) {
        torque = num_add(torque, model_torque(d, ref));
    }
    s->iq_ref = drive_within_room(d, torque); /* what the d axis leaves */
    ctl_pi_commit(&s->pi, num_add(feedback, num_sub(s->iq_ref, torque)));
}

void drive_speed_step(drive_t *d)
{
    step(d);
    if (!d->setup->more) { /* one branch for all of it */
        return;
    }
    if (d->setup->reference.used) {
        drive_refer_currents(d);
    }
    if (d->setup->thermal.used) {
        drive_heat(d);
    }
    if (d->setup->braking.chops) {
        drive_chop(d);
    }
}

void drive_speed_isr(drive_t *d)
{
    const uint32_t started = timing_own_clock(&d->timing);
    d->speed_busy = 1U;
    if (!d->setup->speed.inlined) {
        drive_speed_step(d);
    }
    timing_note(&d->timing.speed, d->timing.epoch, timing_own_clock(&d->timing) - started);
    d->speed_busy = 0U;
}

float drive_speed_rad_s(const drive_t *d)
{
    const drive_speed_source_t source = d->setup->speed.source;
    const num_t                speed = (source == DRIVE_SPEED_MT)
                                           ? d->speed.meas
                                           : ((source == DRIVE_SPEED_FIR) ? d->observer.seen.speed : d->tracking.pll.state.w);
    return num_to_float(speed) * d->scale.speed_rad_s;
}

uint32_t drive_rejected(const drive_t *d)
{
    return d->rejected + d->current.d.state.rejected + d->current.q.state.rejected + d->speed.pi.state.rejected +
           (d->setup->speed.rc_used ? d->speed.rc.state.rejected : 0U);
}
