/* The 10 kHz interrupt. Order: measure, track, (speed loop), control, set duties. */
#include "control/motor/svm.h"
#include "firmware/app/internal.h"
#include "hal/hal_clock.h"
#include "hal/hal_inverter.h"

#define INV_SQRT3 NUM_C(0.57735026919f)
#define V_DC_MIN NUM_C(1.0e-3f) /* below it the voltage limit leaves nothing to modulate, but its inverse is wanted */

static void set_zero_voltage(void)
{
    const hal_duty_t half = {0.5f, 0.5f, 0.5f};
    (void)hal_inverter_set_duty(&half);
}

void drive_command_nothing(drive_t *d)
{
    const ctl_dq_t zero = {(num_t)0, (num_t)0};
    d->current.ref = zero;
    d->current.volt = zero;
    d->speed.ref_rad_s = 0.0f;
    d->speed.iq_ref = (num_t)0;
    d->speed.correction = (num_t)0;
    d->speed.error = (num_t)0;
    d->observer.estimate = (num_t)0;
    d->position.setpoint.speed = (num_t)0;
    d->position.rdc.state.robust = (num_t)0;
}

static angle_t encoder_angle(const drive_t *d)
{
    return d->setup->tracking.encoder_reversed ? (0U - d->sample.theta_m) : d->sample.theta_m;
}

/* One branch for an angle that cannot be (motion_check.h) and for the speed before it. The angle is known: take_sample. */
static void track(drive_t *d)
{
    drive_tracking_t *const t = &d->tracking;
    const float             limit = d->params->over_speed_rad_s;
    const float             speed = drive_si(num_abs(t->pll.state.w), d->scale.speed_rad_s);
    const angle_t           jump = d->setup->motion.jump;
    const angle_t           before = t->theta_m;
    angle_t                 theta = encoder_angle(d);

    if ((((theta - t->expected) + jump) <= (2U * jump)) & (speed <= limit)) {
        t->jump_periods = 0U;
    } else {
        theta = drive_judge_motion(d, speed, theta);
    }
    t->theta_m = theta;
    t->expected = (2U * theta) - before;
    t->theta_e = (theta * d->setup->tracking.pole_pairs) + d->zero.e;
    (void)ctl_pll_step(&t->pll, theta);
}

/* Samples that are not usual, and observers with options. */
static void observe_otherwise(drive_t *d)
{
    drive_observer_t *const o = &d->observer;
    o->seen.torque = ctl_meter_torque_raw(&o->meter, d->tracking.theta_m, d->current.ref.q);
    if (d->setup->observer.used && (d->state == DRIVE_RUN)) {
        o->estimate = ctl_observer_step_raw(&o->observer, d->tracking.theta_m, d->tracking.pll.state.w, o->seen.torque);
    }
}

/* Disturbance torque, measured, and expected for the moment when a reference of now will act. One branch for all that is
 * not usual. */
static void observe(drive_t *d)
{
    drive_observer_t *const o = &d->observer;
    if (!d->setup->observer.meter_used) {
        return;
    }
    const angle_t theta = d->tracking.theta_m;
    const num_t   way = ctl_meter_way(&o->meter, theta);
    if (d->setup->observer.direct & (d->state == DRIVE_RUN) & ctl_meter_is_usual(&o->meter, way) &
        ctl_observer_is_usual(&o->observer)) {
        o->seen.torque = ctl_meter_torque_usual(&o->meter, theta, way, d->current.ref.q);
        o->estimate = ctl_observer_step_usual(&o->observer, theta, d->tracking.pll.state.w, o->seen.torque);
    } else {
        observe_otherwise(d);
    }
    if (d->setup->speed.source == DRIVE_SPEED_FIR) {
        o->seen.speed = ctl_meter_speed_raw(&o->meter);
    }
}

static void speed_tick(drive_t *d, uint32_t now_cyc)
{
    if (d->speed_count > 0U) {
        d->speed_count--;
        return;
    }
    d->speed_count = (uint16_t)(d->setup->speed.divider - 1U);

    drive_speed_t *const s = &d->speed;
    s->now_cyc = now_cyc;
    s->theta_e = d->tracking.theta_e;
    if (d->setup->speed.inlined | (d->speed_busy != 0U)) { /* one branch for all that is unusual */
        if (d->setup->speed.inlined) {
            drive_speed_step(d);
            return;
        }
        drive_trip(d, FAULT_speed_overrun); /* the last one has not ended */
    }
    d->speed_busy = 1U;
    hal_clock_request_speed_isr();
}

static void measure_currents(drive_t *d, angle_t theta_e)
{
    const float     inv = d->scale.inv_current;
    const ctl_abc_t i = {drive_per_base(d->ia_a, inv), drive_per_base(d->ib_a, inv), drive_per_base(d->ic_a, inv)};
    ctl_rotor_t     rotor;
    angle_sincos(theta_e, &rotor.sine, &rotor.cosine);
    d->current.meas = ctl_park_raw(ctl_clarke_raw(i), rotor);
}

static void control_by_pi(drive_current_t *c, num_t limit)
{
    const ctl_dq_t err = {num_sub(c->ref.d, c->meas.d), num_sub(c->ref.q, c->meas.q)};
    const ctl_dq_t wanted = {ctl_pi_propose_raw(&c->d, err.d), ctl_pi_propose_raw(&c->q, err.q)};
    if (ctl_vector_limit_raw(wanted, limit, &c->volt)) { /* else both axes hold */
        ctl_pi_learn_from_raw(&c->d, err.d);
        ctl_pi_learn_from_raw(&c->q, err.q);
    }
}

/* The voltage will act at `lead` turns beyond the electrical angle `at`. */
static void control_currents(drive_t *d, angle_t at, num_t lead)
{
    drive_current_t *const c = &d->current;
    const num_t            v_dc = num_max(drive_per_base(d->sample.vdc_v, d->scale.inv_voltage), V_DC_MIN);
    const num_t            limit = num_min(d->setup->current.voltage_limit, num_mul(v_dc, INV_SQRT3));

    if (d->setup->current.deadbeat_used) {
        const ctl_dq_t wanted = ctl_deadbeat_step_raw(&c->deadbeat, c->meas, c->ref, d->tracking.pll.state.w, c->volt);
        (void)ctl_vector_limit_raw(wanted, limit, &c->volt);
    } else {
        control_by_pi(c, limit);
    }

    ctl_rotor_t rotor;
    angle_sincos_lead(at, lead, &rotor.sine, &rotor.cosine);
    const ctl_abc_t  duty = ctl_svm_open_raw(ctl_inverse_park_raw(c->volt, rotor), v_dc);
    const hal_duty_t out = {num_to_float(duty.a), num_to_float(duty.b), num_to_float(duty.c)};
    (void)hal_inverter_set_duty(&out);
}

static void take_references(drive_t *d)
{
    const drive_order_t *const order = drive_active_order(d);
    const num_t                needed = num_sub(d->speed.iq_ref, d->observer.estimate);
    const num_t                iq = order->torque ? order->iq : needed;

    d->current.ref.d = order->id;
    d->current.ref.q = num_clamp(iq, num_neg(order->iq_max), order->iq_max);
}

static void add_to_calibration(drive_t *d)
{
    if (d->sum_count < d->params->offset_calibration_periods) {
        d->sum_count++;
        d->sum_a_a += d->sample.ia_a;
        d->sum_b_a += d->sample.ib_a;
        d->sum_c_a += d->sample.ic_a;
    }
}

static void act(drive_t *d)
{
    angle_t at = d->tracking.theta_e;
    num_t   lead = (num_t)0;
    if (d->state == DRIVE_RUN) {
        take_references(d);
        /* the voltage acts one period later and for one period: rotate it to the middle of that */
        lead = num_mul(d->setup->current.advance, d->tracking.pll.state.w);
    } else if ((d->state == DRIVE_ALIGN) && drive_align_step(d)) {
        at = d->align.at;
        const ctl_dq_t ref = {d->align.current_now, (num_t)0};
        d->current.ref = ref;
    } else {
        if (d->state == DRIVE_OFFSET_CALIBRATION) {
            add_to_calibration(d);
        } else {
            measure_currents(d, at);
        }
        set_zero_voltage();
        return;
    }
    measure_currents(d, at);
    control_currents(d, at, lead);
}

/* The gate: a sample that passes needs no further judgement and may be calculated with. NaN compares false. & instead of
 * &&: one branch for all of it. */
static bool is_usual(drive_t *d, hal_status_t status, uint32_t previous_seq)
{
    const drive_params_t *const p = d->params;
    const hal_sample_t *const   s = &d->sample;
    const float                 a = s->ia_a - d->offset_a_a;
    const float                 b = s->ib_a - d->offset_b_a;
    const float                 c = s->ic_a - d->offset_c_a;
    d->ia_a = a;
    d->ib_a = b;
    d->ic_a = c;
    return (bool)((status == HAL_OK) & (s->seq == (previous_seq + 1U)) & (a <= p->over_current_a) & (a >= -p->over_current_a) &
                  (b <= p->over_current_a) & (b >= -p->over_current_a) & (c <= p->over_current_a) & (c >= -p->over_current_a) &
                  (s->vdc_v <= p->over_voltage_v) & (s->vdc_v >= p->under_voltage_v) &
                  (d->tracking.known == DRIVE_ANGLE_KNOWN)); /* hence not the first one */
}

static bool take_sample(drive_t *d)
{
    const uint32_t     previous_seq = d->sample.seq;
    const hal_status_t status = hal_sample_read(&d->sample);
    if (is_usual(d, status, previous_seq)) {
        d->lost_samples = 0U;
        d->bad_samples = 0U;
        return true;
    }
    const bool usable = drive_check_sample(d, status, previous_seq);
    if ((!usable || (d->sample.seq != (previous_seq + 1U))) && (d->tracking.known != DRIVE_ANGLE_UNKNOWN)) {
        d->tracking.known = DRIVE_ANGLE_AGAIN; /* who knows how many periods went by */
    }
    if (usable) {
        drive_find_angle(d, encoder_angle(d));
    }
    return usable;
}

void drive_current_isr(drive_t *d)
{
    if ((d->next_ready != 0U) && (d->speed_busy == 0U)) {
        drive_take_over(d);
    }
    const bool     usable = take_sample(d);
    const uint32_t started = d->sample.at_cyc;
    if (usable) {
        track(d);
        observe(d);
        speed_tick(d, started);
        act(d);
    } else {
        set_zero_voltage(); /* nothing to control with */
    }
    const uint32_t took_cyc = hal_clock_cyc() - started;
    d->timing.used_cyc += took_cyc;
    if ((d->timing.current.epoch != d->timing.epoch) | (took_cyc > d->setup->period_cyc)) { /* one branch for both */
        timing_follow(&d->timing.current, d->timing.epoch);
        if (took_cyc > d->setup->period_cyc) {
            drive_trip(d, FAULT_isr_overrun);
        }
    }
    timing_note_raw(&d->timing.current, took_cyc);
}
