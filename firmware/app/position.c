/* The position loop, at the rate of the speed loop: motion profile, P-PI cascade, and what its method adds. */
#include "firmware/app/internal.h"

static void begin(drive_t *d)
{
    drive_position_t *const o = &d->position;
    ctl_profile_reset(&o->profile, o->now);
    ctl_pi_reset(&o->pi, (num_t)0);
    ctl_rdc_reset(&o->rdc);
    ctl_ilc_reset(&o->ilc, true);
    ctl_ilc_reset(&o->learn, true);
    o->src.state.primed = false;
    o->error_count = 0U;
    for (uint16_t i = 0U; i < 8U; i++) {
        o->delayed[i] = (num_t)0;
        o->fed_delayed[i] = (num_t)0;
    }
    o->active = true;
}

static void show(drive_shown_t *s, ctl_position_t position)
{
    const uint16_t idle = (uint16_t)(s->at ^ 1U);
    s->value[idle] = position;
    s->at = idle;
}

void drive_position_measure(drive_t *d)
{
    drive_position_t *const o = &d->position;
    const angle_t           theta = d->tracking.theta_m;
    if (!o->primed) {
        o->raw = (ctl_position_t)(uint64_t)theta;
        o->now = ctl_position_sub(o->raw, o->zero);
        o->primed = true;
    }
    o->raw = ctl_position_follow(o->raw, theta);
    o->before = o->now;
    o->now = ctl_position_sub(o->raw, o->zero);
    o->speed = num_mul(ctl_position_difference(o->now, o->before), d->setup->position.speed_per_rad);
    show(&o->now_shown, o->now);
}

/* Search the index: where to go meanwhile. When it has been passed, its position becomes zero. */
static ctl_position_t search(drive_t *d, ctl_position_t target)
{
    drive_position_t *const o = &d->position;
    const bool              forward = d->params->homing_speed_rad_s >= 0.0f;
    if (d->home_wanted) {
        d->home_wanted = false;
        o->homing = true;
        o->homed = false;
        o->home_limit = o->now + (forward ? (CTL_ONE_TURN + (CTL_ONE_TURN / 4)) : -(CTL_ONE_TURN + (CTL_ONE_TURN / 4)));
    }
    if (!o->homing) {
        return target;
    }
    if (d->speed.edge.index_passes != 0U) {
        const angle_t        at = angle_from_rad(num_from_float(d->speed.edge.index_rad));
        const ctl_position_t index = ctl_position_follow(o->raw, drive_true_angle(d, at));
        const ctl_position_t shift = ctl_position_sub(index, o->zero);
        o->zero = index;
        o->now = ctl_position_sub(o->now, shift);
        show(&o->now_shown, o->now);
        o->before = ctl_position_sub(o->before, shift);
        o->homed = true;
        o->homing = false;
        ctl_profile_shift(&o->profile, shift); /* go on from here, without a step in the command */
        return target;
    }
    if (forward ? (o->now >= o->home_limit) : (o->now <= o->home_limit)) {
        drive_trip(d, FAULT_homing);
    }
    return o->home_limit + (forward ? CTL_ONE_TURN : -CTL_ONE_TURN);
}

static void guard(drive_t *d)
{
    drive_position_t *const             o = &d->position;
    const drive_position_setup_t *const q = &d->setup->position;
    const ctl_position_t                margin = CTL_ONE_TURN / 100;

    if (num_abs(o->error) <= q->error_max) {
        o->error_count = 0U;
    } else if (o->error_count < q->error_samples) {
        o->error_count++;
    } else {
        drive_trip(d, FAULT_following_error);
    }
    if (!o->homing && ((o->now > (q->max + margin)) || (o->now < (q->min - margin)))) {
        drive_trip(d, FAULT_position_limit);
    }
}

/* The torque, and the part of it that is fed forward, as late as the bus between controller and drive makes them. */
static void hand_over(drive_speed_t *v, drive_position_t *o, num_t torque, num_t fed, uint16_t samples)
{
    o->delay_head = (uint16_t)((o->delay_head + 1U) & 7U);
    o->delayed[o->delay_head] = torque;
    o->fed_delayed[o->delay_head] = fed;
    const uint16_t at = (uint16_t)((o->delay_head - samples) & 7U);
    v->iq_ref = o->delayed[at];
    v->fed = o->fed_delayed[at];
}

/* Cut to what turns_q32 takes, twice the widest soft limits. */
static ctl_position_t target_of(const drive_command_t *c)
{
    const int32_t most = 2000000;
    const int32_t turns = (c->target_turns > most) ? most : ((c->target_turns < -most) ? -most : c->target_turns);
    return ((ctl_position_t)turns * CTL_ONE_TURN) + drive_turns_q32(c->target_rad * (1.0f / DRIVE_TWO_PI));
}

void drive_position_step(drive_t *d, const drive_command_t *command)
{
    drive_position_t *const             o = &d->position;
    const drive_position_setup_t *const q = &d->setup->position;

    if (!o->active) {
        begin(d);
    }
    const ctl_position_t target = target_of(command);
    ctl_position_t       to = (target > q->max) ? q->max : ((target < q->min) ? q->min : target);
    to = search(d, to);
    o->setpoint = ctl_profile_step_unchecked(o->homing ? &q->homing : &q->profile, &o->profile, to);
    show(&o->ref_shown, o->setpoint.position);
    o->error = ctl_position_difference(o->setpoint.position, o->now);
    guard(d);

    const num_t   speed_error = num_sub(o->setpoint.speed, o->speed);
    const angle_t theta = (angle_t)(uint64_t)o->raw;
    num_t         feed = q->feed_speed ? o->setpoint.speed : (num_t)0;
    if (q->method == DRIVE_POSITION_SILC) {
        feed = num_add(feed, ctl_ilc_step(&o->ilc, theta, speed_error));
    } else if (q->method == DRIVE_POSITION_SRC) {
        /* plugged into the velocity loop: its error before the correction */
        feed = num_add(feed, ctl_src_step(&o->src, theta, o->speed, num_sub(num_mac(feed, q->kp, o->error), o->speed)));
    } else {
        /* ppi, rdc: no learning of the speed */
    }
    const num_t wanted = num_mac(feed, q->kp, o->error);
    d->motion.asked = wanted;
    const num_t feedback = ctl_pi_output(&o->pi, num_sub(wanted, o->speed));
    num_t       torque = feedback;
    num_t       fed = (num_t)0;
    if (q->method == DRIVE_POSITION_RDC) {
        torque = num_add(torque, ctl_rdc_step_unchecked(&q->rdc, &o->rdc, &o->setpoint, num_neg(o->error), num_neg(speed_error)));
        fed = o->rdc.fed;
        if (q->learns) {
            torque = num_add(torque, ctl_ilc_step(&o->learn, theta, num_add(feedback, o->rdc.robust)));
        }
    }
    const num_t limited = drive_within_room(d, torque);
    ctl_pi_commit(&o->pi, num_add(feedback, num_sub(limited, torque)));
    ctl_pi_reset(&d->speed.pi, limited); /* speed mode goes on with this torque */
    hand_over(&d->speed, o, limited, fed, q->torque_delay);
}

static inline float in_rad(ctl_position_t position)
{
    /* turns and part separately: a float has 24 bits */
    const int32_t turns = (int32_t)(position >> 32);
    const float   part = (float)(uint32_t)(uint64_t)position * 1.46291807926715968e-9f;
    return ((float)turns * DRIVE_TWO_PI) + part;
}

/* The speed interrupt writes the other one: this is whole unless it comes twice in between. */
static inline ctl_position_t whole(const drive_shown_t *s) { return s->value[s->at & 1U]; }

float drive_position_rad(const drive_t *d) { return in_rad(whole(&d->position.now_shown)); }
float drive_position_ref_rad(const drive_t *d) { return in_rad(whole(&d->position.ref_shown)); }
