/* The 10 kHz interrupt. Order: measure, track, (speed loop), control, set duties. */
#include "control/motor/svm.h"
#include "control/observer/disturbance.h"
#include "firmware/app/internal.h"
#include "firmware/app/protection.h"
#include "hal/hal_clock.h"
#include "hal/hal_inverter.h"

#define INV_SQRT3 NUM_C(0.57735026919f)
#define V_DC_MIN NUM_C(0.0009765625f) /* below it the voltage limit leaves nothing to modulate, but its inverse is wanted */

static void set_zero_voltage(const drive_t *d)
{
    const float      share = (d->state == DRIVE_SHORT) ? 0.0f : 0.5f; /* a short: lower switches alone */
    const hal_duty_t equal = {share, share, share};
    (void)hal_inverter_set_duty(&equal);
}

void drive_command_nothing(drive_t *d)
{
    const ctl_dq_t zero = {(num_t)0, (num_t)0};
    d->current.ref = zero;
    d->current.volt = zero;
    d->current.torque = (num_t)0;
    d->speed.ref_rad_s = 0.0f;
    d->speed.iq_ref = (num_t)0;
    d->speed.fed = (num_t)0;
    d->speed.correction = (num_t)0;
    d->speed.error = (num_t)0;
    d->observer.estimate = (num_t)0;
    d->position.setpoint.speed = (num_t)0;
    d->position.rdc.robust = (num_t)0;
}

/* One branch for an angle that cannot be (motion_check.h), for the speed before it, and for an encoder whose error is taken off. The angle is known: take_sample. */
static inline void track(drive_t *d, const drive_setup_t *setup)
{
    drive_tracking_t *const t = &d->tracking;
    const float             limit = setup->motion.plain_rad_s;
    const float             speed = drive_si(num_abs(t->pll.state.w), d->scale.speed_rad_s);
    const angle_t           jump = setup->motion.jump;
    const angle_t           before = t->theta_m;
    angle_t                 theta = d->sample.theta_m * setup->tracking.direction;

    if ((((theta - t->expected) + jump) > (2U * jump)) | !(speed <= limit)) {
        theta = drive_judge_motion(d, speed);
    }
    t->theta_m = theta;
    t->expected = (2U * theta) - before;
    t->theta_e = (theta * setup->tracking.pole_pairs) + d->zero.e;
    (void)ctl_pll_step(&t->pll, theta);
}

/* Disturbance torque, measured, and expected for the moment when a reference of now will act. What the position loop feeds forward
 * against it is no torque that was asked for: the observer learns what that leaves. */
static inline void observe(drive_t *d, const drive_setup_t *setup)
{
    drive_observer_t *const o = &d->observer;
    if (!setup->observer.meter_used) {
        return;
    }
    o->seen.torque = ctl_disturbance_step_unchecked(&o->meter, &o->observer, setup->observer.used & (d->state == DRIVE_RUN),
                                                    d->tracking.theta_m, d->tracking.pll.state.w, d->current.torque, d->speed.fed,
                                                    &o->estimate);
    if (setup->observer.speed_asked) {
        o->seen.speed = ctl_meter_speed_unchecked(&o->meter);
    }
}

static inline void speed_tick(drive_t *d, const drive_setup_t *setup, uint32_t now_cyc)
{
    if (d->speed_count > 0U) {
        d->speed_count--;
        return;
    }
    d->speed_count = setup->speed.between;

    drive_speed_t *const s = &d->speed;
    s->now_cyc = now_cyc;
    s->theta_e = d->tracking.theta_e;
    if (((uint16_t)setup->speed.inlined | d->speed_busy) != 0U) { /* one branch for both */
        if (setup->speed.inlined) {
            drive_speed_step(d);
            return;
        }
        drive_trip(d, FAULT_speed_overrun); /* the last one has not ended */
    }
    d->speed_busy = 1U;
    hal_clock_request_speed_isr();
}

static inline void measure_currents(drive_t *d, angle_t theta_e)
{
    const float     inv = d->scale.inv_current;
    const ctl_abc_t i = {drive_per_base(d->ia_a, inv), drive_per_base(d->ib_a, inv), drive_per_base(d->ic_a, inv)};
    ctl_rotor_t     rotor;
    angle_sincos(theta_e, &rotor.sine, &rotor.cosine);
    d->current.meas = ctl_park_unchecked(ctl_clarke_unchecked(i), rotor);
}

static inline void control_by_pi(drive_current_t *c, num_t limit)
{
    const ctl_dq_t err = {num_sub(c->ref.d, c->meas.d), num_sub(c->ref.q, c->meas.q)};
    const ctl_dq_t wanted = {ctl_pi_propose_unchecked(&c->d, err.d), ctl_pi_propose_unchecked(&c->q, err.q)};
    if (ctl_vector_limit_unchecked(wanted, limit, &c->volt)) { /* else both axes hold */
        ctl_pi_learn_unchecked(&c->d, err.d);
        ctl_pi_learn_unchecked(&c->q, err.q);
    }
}

/* The voltage will act at `lead` turns beyond the electrical angle `at`. */
static inline void control_currents(drive_t *d, const drive_setup_t *setup, angle_t at, num_t lead)
{
    drive_current_t *const c = &d->current;
    const num_t            v_dc = num_max(drive_per_base(d->sample.vdc_v, d->scale.inv_voltage), V_DC_MIN);
    const num_t            limit = num_min(setup->current.voltage_limit, num_mul(v_dc, INV_SQRT3));

    if (setup->current.deadbeat_used) {
        const ctl_dq_t wanted = ctl_deadbeat_step_unchecked(&setup->current.deadbeat, &c->deadbeat, c->meas, c->ref,
                                                            d->tracking.pll.state.w, c->volt);
        (void)ctl_vector_limit_unchecked(wanted, limit, &c->volt);
    } else {
        control_by_pi(c, limit);
    }

    ctl_rotor_t rotor;
    angle_sincos_lead(at, lead, &rotor.sine, &rotor.cosine);
    const ctl_abc_t  duty = ctl_svm_unchecked(ctl_inverse_park_unchecked(c->volt, rotor), v_dc);
    const hal_duty_t out = {num_to_float(duty.a), num_to_float(duty.b), num_to_float(duty.c)};
    (void)hal_inverter_set_duty(&out);
}

static num_t next_sine(drive_current_t *c, num_t amplitude, angle_t step)
{
    num_t sine;
    num_t cosine;
    c->excite_phase += step;
    angle_sincos(c->excite_phase, &sine, &cosine);
    return num_mul(amplitude, sine);
}

/* Of the torque: it changes with what the speed loop asks for, which acts a period after its sample, or in it where it is inlined. */
static num_t held_sine(drive_t *d, const drive_order_t *order)
{
    drive_current_t *const           c = &d->current;
    const drive_speed_setup_t *const speed = &d->setup->speed;
    const num_t                      before = c->excite_held;
    if (d->speed_count != speed->between) {
        return before;
    }
    c->excite_held = next_sine(c, order->excite_held, order->excite_step);
    return speed->inlined ? c->excite_held : before;
}

/* Torque as it is commanded, or with an excitation on top; apart from take_references, which stays as short as it is without. */
static num_t unusual_torque(drive_t *d, const drive_order_t *order, num_t needed)
{
    drive_current_t *const c = &d->current;
    num_t                  excitation = (num_t)0;
    if (order->excite_held != (num_t)0) {
        excitation = held_sine(d, order);
    } else if (order->excite_iq != (num_t)0) {
        excitation = next_sine(c, order->excite_iq, order->excite_step);
    } else {
        c->excite_held = (num_t)0;
    }
    const num_t without = num_clamp(order->torque ? order->iq : needed, num_neg(order->iq_max), order->iq_max);
    const num_t with = num_clamp(num_add(without, excitation), num_neg(order->iq_max), order->iq_max);
    c->excitation = num_sub(with, without);
    return with;
}

static inline void take_references(drive_t *d)
{
    const drive_order_t *const order = drive_active_order(d);
    const num_t                needed = num_sub(d->speed.iq_ref, d->observer.estimate);
    const num_t                iq = order->plain ? needed : unusual_torque(d, order, needed);

    d->current.ref.d = order->id;
    d->current.ref.q = num_clamp(iq, num_neg(order->iq_max), order->iq_max);
    d->current.torque = d->current.ref.q;
}

/* The voltage that the speed induces in each axis, of the currents that are asked for, into the integral parts: beyond base speed one
 * axis disturbs the other by more than its controller's gain. */
static void decouple(drive_current_t *c, const ctl_deadbeat_params_t *m, num_t w)
{
    const ctl_dq_t now = {num_neg(num_mul(num_mul(w, m->w_lq), c->ref.q)), num_mul(w, num_mac(m->w_psi, m->w_ld, c->ref.d))};
    if (c->decoupled) { /* else the integral parts hold it already */
        c->d.state.x = num_add(c->d.state.x, num_sub(now.d, c->induced.d));
        c->q.state.x = num_add(c->q.state.x, num_sub(now.q, c->induced.q));
    }
    c->induced = now;
    c->decoupled = true;
}

/* The same torque with the currents that MTPA and field weakening have chosen. */
static void refer_currents(drive_t *d, const drive_setup_t *setup)
{
    drive_current_t *const             c = &d->current;
    const ctl_reference_state_t *const r = &d->reference;
    const drive_order_t *const         order = drive_active_order(d);
    if (order->torque) {
        c->decoupled = false;
        return;
    }
    const num_t needed = num_sub(d->speed.iq_ref, d->observer.estimate);
    c->ref.d = r->id;
    c->ref.q = num_clamp(num_mul(needed, r->q_share), num_neg(r->iq_max), r->iq_max);
    if (!order->plain) {
        const num_t without = c->ref.q;
        c->ref.q = num_clamp(num_mac(without, c->excitation, r->q_share), num_neg(r->iq_max), r->iq_max);
        c->excitation = num_sub(c->ref.q, without);
    }
    c->torque = num_mul(c->ref.q, r->gain);
    if (setup->current.decouples) {
        decouple(c, &setup->current.deadbeat, d->tracking.pll.state.w);
    }
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

/* The phase currents of the sample, the third as the sum of the others, without what the sensors add to them, and what that is learned from. What trips was judged before. */
static inline void correct_currents(drive_t *d)
{
    const drive_sensors_map_t *const m = &d->sensors.map[d->sensors.at];
    /* of the last sample: current and voltage are still where its control left them */
    if ((d->sample.seq & 1U) != 0U) {
        ctl_turn_note_current_unchecked(&d->sensors.log, d->current.meas);
    } else {
        ctl_turn_note_voltage_unchecked(&d->sensors.log, d->current.volt, d->tracking.theta_e, d->tracking.theta_m);
    }
    d->ia_a = (d->ia_a * m->scale[0]) - m->shift_a[0];
    d->ib_a = (d->ib_a * m->scale[1]) - m->shift_a[1];
    d->ic_a = -d->ia_a - d->ib_a;
}

/* The q current that makes the torque asked for, whatever the flux has here: over 1 + r, as 1 - r + r^2. And the voltage that it and the
 * back-EMF of these harmonics will need, where the rotor will be: no bandwidth of the current loop is asked for them. */
static inline num_t smooth_torque(drive_t *d, const drive_setup_t *setup, num_t lead)
{
    const ctl_fourier_t *const         flux = &setup->sensors.flux;
    const ctl_deadbeat_params_t *const m = &setup->current.deadbeat;
    const drive_order_t *const         order = drive_active_order(d);
    const num_t                        iq = d->current.ref.q;
    num_t                              slope;
    num_t                              r = ctl_fourier(flux, 6U * d->tracking.theta_e, &slope);
    d->current.ref.q = num_clamp(num_mac(iq, iq, num_sub(num_mul(r, r), r)), num_neg(order->iq_max), order->iq_max);

    r = ctl_fourier(flux, 6U * (d->tracking.theta_e + angle_step_from_turns(lead)), &slope);
    const num_t more = num_mul(iq, num_sub(num_mul(r, r), r));
    const num_t rate = num_mul(num_mul(NUM_C(6.0f), num_mul(iq, slope)), num_sub(num_mul(NUM_C(2.0f), r), NUM_C(1.0f)));
    const num_t by_speed = num_mac(num_mul(m->w_psi, r), m->w_lq, rate);
    return num_mac(num_mul(m->r, more), d->tracking.pll.state.w, by_speed);
}

/* What the dead time will take away in the period that the voltage acts in, from the currents that are asked for. */
static inline ctl_dq_t dead_time(const drive_t *d, const drive_setup_t *setup, num_t lead)
{
    const num_t volt = num_mul(setup->sensors.dead_share, drive_per_base(d->sample.vdc_v, d->scale.inv_voltage));
    ctl_rotor_t rotor;
    angle_sincos_lead(d->tracking.theta_e, lead, &rotor.sine, &rotor.cosine);
    return ctl_dead_time_unchecked(d->current.ref, rotor, volt, setup->sensors.per_soft);
}

/* Voltage that is known goes into the integral parts, which hold it without having to find it again six times a turn. */
static inline void hold(drive_t *d, ctl_dq_t now)
{
    drive_current_t *const c = &d->current;
    c->d.state.x = num_add(c->d.state.x, num_sub(now.d, d->sensors.held.d));
    c->q.state.x = num_add(c->q.state.x, num_sub(now.q, d->sensors.held.q));
    d->sensors.held = now;
}

/* The proportional gains for the inductance at the current that flows when the voltage acts, in the period after this one: part of the
 * way from the last sample to the reference. Of 0, 3/8 and 1/2, 3/8 keeps steps of any size nearest to those of a constant inductance. */
static inline void follow_saturation(drive_current_t *c, const drive_setup_t *setup)
{
    const ctl_saturation_params_t *const p = &setup->sensors.saturation;
    const num_t                          way = NUM_C(0.375f);
    const num_t                          d = num_mac(c->meas.d, way, num_sub(c->ref.d, c->meas.d));
    const num_t                          q = num_mac(c->meas.q, way, num_sub(c->ref.q, c->meas.q));
    c->d.params.kp = num_mul(setup->current.pi.kp, ctl_saturation_unchecked(p, d, q));
    c->q.params.kp = num_mul(setup->current.pi.kp, ctl_saturation_unchecked(p, q, d));
}

static inline void correct_more(drive_t *d, const drive_setup_t *setup, num_t lead)
{
    if (setup->sensors.three) {
        const drive_sensors_map_t *const m = &d->sensors.map[d->sensors.at];
        d->ic_a = ((d->sample.ic_a - d->offset_c_a) * m->scale[2]) - m->shift_a[2];
    }
    if (setup->reference.used) {
        refer_currents(d, setup);
    }
    ctl_dq_t    known = {(num_t)0, (num_t)0};
    const bool  smooths = setup->sensors.smooths && !drive_active_order(d)->torque; /* current mode makes the current asked for */
    const num_t flux = smooths ? smooth_torque(d, setup, lead) : (num_t)0;
    if (setup->sensors.compensates) {
        known = dead_time(d, setup, lead);
    }
    if (setup->sensors.compensates || setup->sensors.smooths) {
        known.q = num_add(known.q, flux);
        hold(d, known);
    }
    if (setup->sensors.saturates) {
        follow_saturation(&d->current, setup);
    }
}

static inline void act(drive_t *d, const drive_setup_t *setup)
{
    angle_t at = d->tracking.theta_e;
    num_t   lead = (num_t)0;
    if (d->state ==
        setup->sensors.plain_state) { /* one branch for RUN, sensors that need no correction, and no field weakening */
        take_references(d);
        /* the voltage acts one period later and for one period: rotate it to the middle of that */
        lead = num_mul(setup->current.advance, d->tracking.pll.state.w);
    } else if (d->state == DRIVE_RUN) {
        correct_currents(d);
        take_references(d);
        lead = num_mul(setup->current.advance, d->tracking.pll.state.w);
        if (setup->sensors.more) { /* one branch for all of it */
            correct_more(d, setup, lead);
        }
    } else if ((d->state == DRIVE_ALIGN) && drive_align_step(d)) {
        at = d->align.at;
        const ctl_dq_t ref = {d->align.current_now, (num_t)0};
        d->current.ref = ref;
        d->current.torque = (num_t)0;
    } else {
        if (d->state == DRIVE_OFFSET_CALIBRATION) {
            add_to_calibration(d);
        } else {
            measure_currents(d, at);
        }
        set_zero_voltage(d);
        return;
    }
    measure_currents(d, at);
    control_currents(d, setup, at, lead);
}

static inline bool take_sample(drive_t *d, const drive_setup_t *setup)
{
    const uint32_t     previous_seq = d->sample.seq;
    const hal_status_t status = hal_sample_read(&d->sample);
    if (drive_sample_is_nominal(d, &setup->limits, status, previous_seq)) {
        d->lost_samples = 0U;
        d->bad_samples = 0U;
        return true;
    }
    const bool usable = drive_check_sample(d, status, previous_seq);
    ctl_turn_spoil(&d->sensors.log);
    if ((!usable || (d->sample.seq != (previous_seq + 1U))) && (d->tracking.known != DRIVE_ANGLE_UNKNOWN)) {
        d->tracking.known = DRIVE_ANGLE_AGAIN; /* who knows how many periods went by */
    }
    if (usable) {
        drive_find_angle(d, drive_true_angle(d, d->sample.theta_m));
    }
    return usable;
}

void drive_current_isr(drive_t *d)
{
    if ((d->next_ready != 0U) && (d->speed_busy == 0U)) {
        drive_take_over(d);
    }
    const drive_setup_t *const setup = d->setup; /* read once: nothing else changes it */
    const bool                 usable = take_sample(d, setup);
    const uint32_t             started = d->sample.at_cyc;
    if (usable) {
        track(d, setup);
        observe(d, setup);
        speed_tick(d, setup, started);
        act(d, setup);
    } else {
        set_zero_voltage(d); /* nothing to control with */
    }
    const uint32_t took_cyc = hal_clock_cyc() - started;
    d->timing.used_cyc += took_cyc;
    if (timing_is_nominal(&d->timing, took_cyc)) { /* one branch for a restart, a new extreme, and more than a period */
        timing_note_nominal(&d->timing.current, took_cyc);
    } else if (timing_note_abnormal(&d->timing, took_cyc, setup->period_cyc)) {
        drive_trip(d, FAULT_isr_overrun);
    } else {
        /* longer or shorter than those before, or the first of its epoch */
    }
}
