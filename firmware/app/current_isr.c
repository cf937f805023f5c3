/* The 10 kHz interrupt. Order: measure, track, (speed loop), control, set duties. */
#include "control/motor/svm.h"
#include "firmware/app/internal.h"
#include "hal/hal_clock.h"
#include "hal/hal_inverter.h"

#define INV_SQRT3 NUM_C(0.57735026919f)
#define ALIGN_LEAD_MAX NUM_C(1.0471976f) /* 60 degrees */

static void set_zero_voltage(void)
{
    const hal_duty_t half = {0.5f, 0.5f, 0.5f};
    (void)hal_inverter_set_duty(&half);
}

void drive_rest(drive_t *d)
{
    ctl_pi_reset(&d->current.d, (num_t)0);
    ctl_pi_reset(&d->current.q, (num_t)0);
    ctl_pi_reset(&d->speed.pi, (num_t)0);
    ctl_mt_reset(&d->speed.mt);
    ctl_deadbeat_reset(&d->current.deadbeat);
    ctl_meter_reset(&d->observer.meter);
    d->observer.estimate = (num_t)0;
    if (d->setup.observer_used) {
        ctl_observer_reset(&d->observer.observer, true); /* what was learned survives a stop */
    }
    if (d->setup.rc_used) {
        ctl_rc_reset(&d->speed.rc);
    }
    drive_rest_position(d);
    const ctl_dq_t zero = {(num_t)0, (num_t)0};
    d->current.ref = zero;
    d->current.volt = zero;
    d->speed.iq_ref = (num_t)0;
    d->speed.correction = (num_t)0;
    d->speed.error = (num_t)0;
}

static void track(drive_t *d)
{
    drive_tracking_t *const t = &d->tracking;
    const angle_t           raw = angle_from_rad(num_from_float(d->sample.theta_m_rad));

    t->theta_m = d->setup.encoder_reversed ? (0U - raw) : raw;
    t->theta_e = (t->theta_m * d->setup.pole_pairs) + t->zero_e;
    if (!t->locked) {
        ctl_pll_reset(&t->pll, t->theta_m);
        t->locked = true;
    }
    (void)ctl_pll_step(&t->pll, t->theta_m);
}

/* Disturbance torque, measured, and expected for the moment when a reference of now will act. */
static void observe(drive_t *d)
{
    drive_observer_t *const o = &d->observer;
    if (!d->setup.meter_used) {
        return;
    }
    o->seen = ctl_meter_step(&o->meter, d->tracking.theta_m, d->current.ref.q);
    if (d->setup.observer_used && (d->state == DRIVE_RUN)) {
        o->estimate = ctl_observer_step(&o->observer, d->tracking.theta_m, o->seen.speed, o->seen.torque);
    }
}

static void speed_tick(drive_t *d)
{
    if (d->speed_count > 0U) {
        d->speed_count--;
        return;
    }
    d->speed_count = (uint16_t)(d->setup.speed_divider - 1U);

    drive_speed_t *const s = &d->speed;
    if (hal_encoder_edge(&s->edge) == HAL_SENSOR_FAULT) {
        drive_trip(d, FAULT_encoder_error);
    }
    s->now_cyc = hal_clock_cyc();
    s->theta_e = d->tracking.theta_e;
    if (d->setup.observer_used) {
        ctl_observer_target(&d->observer.observer, num_from_float(drive_active_command(d)->speed_ref_rad_s * d->scale.inv_speed));
    }
    s->tracked = (d->setup.speed_source == DRIVE_SPEED_FIR) ? d->observer.seen.speed : d->tracking.pll.state.w;
    if (d->setup.speed_inline) {
        drive_speed_step(d);
    } else {
        if (d->speed_busy != 0U) { /* the last one has not ended */
            drive_trip(d, FAULT_speed_overrun);
        }
        d->speed_busy = 1U;
        hal_clock_request_speed_isr();
    }
}

static void measure_currents(drive_t *d, ctl_rotor_t *rotor, angle_t theta_e)
{
    const float     inv = d->scale.inv_current;
    const ctl_abc_t i = {num_from_float(d->ia_a * inv), num_from_float(d->ib_a * inv), num_from_float(d->ic_a * inv)};
    ctl_ab_t        ab;

    angle_sincos(theta_e, &rotor->sine, &rotor->cosine);
    (void)ctl_clarke(&i, &ab);
    (void)ctl_park(&ab, rotor, &d->current.meas);
}

/* ahead: electrical angle at which the voltage will act */
static void control_currents(drive_t *d, angle_t ahead)
{
    drive_current_t *const c = &d->current;
    const num_t            v_dc = num_from_float(d->sample.vdc_v * d->scale.inv_voltage);
    const num_t            reach = num_mul(v_dc, INV_SQRT3);
    const num_t            limit = (d->setup.voltage_limit > (num_t)0) ? num_min(d->setup.voltage_limit, reach) : reach;

    if (d->setup.deadbeat_used) {
        const ctl_dq_t wanted = ctl_deadbeat_step(&c->deadbeat, &c->meas, &c->ref, d->tracking.pll.state.w, &c->volt);
        (void)ctl_vector_limit(&wanted, limit, &c->volt);
    } else {
        const ctl_dq_t wanted = {ctl_pi_output(&c->d, num_sub(c->ref.d, c->meas.d)), ctl_pi_output(&c->q, num_sub(c->ref.q, c->meas.q))};
        if (ctl_vector_limit(&wanted, limit, &c->volt)) {
            ctl_pi_commit(&c->d, c->d.state.wanted);
            ctl_pi_commit(&c->q, c->q.state.wanted);
        } else {
            ctl_pi_hold(&c->d); /* the vector was limited: both axes hold */
            ctl_pi_hold(&c->q);
        }
    }

    ctl_rotor_t rotor;
    ctl_ab_t    v;
    ctl_abc_t   duty;
    angle_sincos(ahead, &rotor.sine, &rotor.cosine);
    (void)ctl_inverse_park(&c->volt, &rotor, &v);
    (void)ctl_svm(&v, v_dc, &duty);
    const hal_duty_t out = {num_to_float(duty.a), num_to_float(duty.b), num_to_float(duty.c)};
    (void)hal_inverter_set_duty(&out);
}

static void take_references(drive_t *d)
{
    const drive_command_t *const cmd = drive_active_command(d);
    const num_t                  id = num_from_float(cmd->id_ref_a * d->scale.inv_current);

    d->current.ref.d = num_clamp(id, num_neg(d->setup.id_limit), d->setup.id_limit);
    if (cmd->mode != DRIVE_MODE_CURRENT) {
        d->current.ref.q = num_clamp(num_sub(d->speed.iq_ref, d->observer.estimate), d->setup.speed_pi.out_min, d->setup.speed_pi.out_max);
    } else {
        const num_t iq = num_from_float(cmd->iq_ref_a * d->scale.inv_current);
        d->current.ref.q = num_clamp(iq, d->setup.speed_pi.out_min, d->setup.speed_pi.out_max);
    }
}

/* A vector pulls the magnets onto it: for half of the time a quarter turn away, so that no rotor can stand opposite to
 * both, then on phase a. By itself the rotor would swing there for seconds; the vector moves against its motion. */
static angle_t alignment_angle(const drive_t *d)
{
    const angle_t target = (d->periods_in_state < (d->params.align_periods / 2U)) ? ANGLE_QUARTER : 0U;
    const num_t   lead = num_mul(d->setup.align_damping, d->tracking.pll.state.w);
    return target - angle_from_rad_short(num_clamp(lead, num_neg(ALIGN_LEAD_MAX), ALIGN_LEAD_MAX));
}

static void act(drive_t *d)
{
    ctl_rotor_t rotor;
    switch (d->state) {
    case DRIVE_RUN:
        take_references(d);
        measure_currents(d, &rotor, d->tracking.theta_e);
        /* the voltage acts one period later and for one period: rotate it to the middle of that */
        control_currents(d, d->tracking.theta_e + angle_from_rad_short(num_mul(d->setup.advance, d->tracking.pll.state.w)));
        break;
    case DRIVE_ALIGN: {
        const ctl_dq_t ref = {d->setup.align_current, (num_t)0};
        const angle_t  at = alignment_angle(d);
        d->current.ref = ref;
        measure_currents(d, &rotor, at);
        control_currents(d, at);
        break;
    }
    case DRIVE_OFFSET_CALIBRATION:
        if (d->sum_count < d->params.offset_calibration_periods) {
            d->sum_count++;
            d->sum_a_a += d->sample.ia_a;
            d->sum_b_a += d->sample.ib_a;
            d->sum_c_a += d->sample.ic_a;
        }
        set_zero_voltage();
        break;
    case DRIVE_INIT:
    case DRIVE_READY:
    case DRIVE_FAULT:
    default:
        measure_currents(d, &rotor, d->tracking.theta_e);
        set_zero_voltage();
        break;
    }
}

void drive_current_isr(drive_t *d)
{
    const uint32_t started = hal_clock_cyc();
    const uint32_t previous_seq = d->sample.seq;

    if ((d->next_ready != 0U) && (d->speed_busy == 0U)) {
        drive_take_over(d);
    }
    const hal_status_t status = hal_sample_read(&d->sample);
    if (drive_check_sample(d, status, previous_seq)) {
        track(d);
        drive_check_motion(d);
        observe(d);
        speed_tick(d);
        act(d);
    } else {
        set_zero_voltage(); /* nothing to control with */
    }
    if (d->periods_in_state < UINT16_MAX) {
        d->periods_in_state++;
    }

    const uint32_t took_cyc = hal_clock_cyc() - started;
    d->timing.used_cyc += took_cyc;
    timing_note(&d->timing.current, d->timing.epoch, took_cyc);
    if (took_cyc > d->setup.period_cyc) {
        drive_trip(d, FAULT_isr_overrun);
    }
}
