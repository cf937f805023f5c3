/* Motion that contradicts torque: motion_check.h says what each check sees and what it does not. */
#include "firmware/app/motion_check.h"

#include "control/numeric/num_math.h"

#include "firmware/app/internal.h"

#define JUMP_MAX (UINT32_C(0x7FFFFFFF)) /* half a turn: no angle is further away */
#define MARGIN_SHARE (1.0f / 256.0f)    /* of over_speed_rad_s: above the noise and ripple of a measured speed */
#define BAND_SHARE                                                                                                               \
    0.05f                            /* of iq_limit_a: with its share of the resistance below FLOOR_SHARE on every drive that
                                            can bring iq_limit_a into its motor at all */
#define FLOOR_SHARE NUM_C(0.04f)     /* of the dc link: that and the dead time when the current changes its sign */
#define USABLE_SHARE NUM_C(0.93f)    /* of the voltage limit: beyond it the current does what it wants */
#define SPEED_SHARE NUM_C(0.125f)    /* of the speed: harmonics of the flux stay below */
#define RIPPLE_SHARE NUM_C(0.03125f) /* of the speed: an encoder disc off centre by 0.02 rad makes 0.04 from peak to peak */
#define NEARER_SHARE NUM_C(0.5f)     /* of the margin: what counts as nearer */
#define OHM_SHARE NUM_C(0.3f)        /* of the resistive drop: copper warmer by 75 K */
#define INV_SQRT3 NUM_C(0.57735026919f)
#define AGAINST_LIMIT 3U
#define SPEED_COUNTS 3.0f      /* between which a speed has been measured */
#define COUNTS_PER_CYCLE 16.0f /* below that the voltages follow the steps of the angle */
#define MEAN_S 1.0e-3f         /* of the operating points of the electrical zero */

/* The travel from rest under the same acceleration grows with the square of the time: a coarse encoder gets more of it. */
static void make_stall(const drive_params_t *p, drive_setup_t *s)
{
    drive_motion_setup_t *const m = &s->motion;
    const float                 count = 1.0f / p->encoder_counts;
    const float                 turn = (count > DRIVE_STALL_TURN) ? count : DRIVE_STALL_TURN;
    const float                 sample_s = (float)p->speed_divider / (float)DRIVE_PWM_HZ;
    const float                 samples = p->stall_s / sample_s * num_to_float(num_sqrt(drive_number(turn / DRIVE_STALL_TURN)));

    m->stall_angle = (angle_t)(turn * 4294967296.0f * ((count > DRIVE_STALL_TURN) ? 0.75f : 1.0f));
    m->stall_samples = (samples < 65535.0f) ? (uint16_t)(samples + 0.5f) : UINT16_MAX;
    m->stall_samples = ((m->stall_samples == 0U) && (p->stall_s > 0.0f)) ? 1U : m->stall_samples;
    m->stall_travel = drive_number((float)DRIVE_STALL_MOTIONS * turn * DRIVE_TWO_PI / (sample_s * s->scale.speed_rad_s));
}

void drive_make_motion(const drive_params_t *p, drive_setup_t *s)
{
    drive_motion_setup_t *const m = &s->motion;
    const float                 steps_per_rad = 683565275.58f; /* 2^32 / 2 pi */
    const float                 jump = (p->encoder_jump_rad + (2.0f * DRIVE_TWO_PI / p->encoder_counts)) * steps_per_rad;
    const float                 samples = p->speed_deviation_s * (float)DRIVE_PWM_HZ / (float)p->speed_divider;

    m->plain_rad_s = s->tracking.corrects ? -1.0f : p->over_speed_rad_s;
    m->jump = (jump < 2147483520.0f) ? (angle_t)jump : JUMP_MAX;
    m->margin = drive_number(p->over_speed_rad_s * MARGIN_SHARE * s->scale.inv_speed);
    m->band = drive_number(p->iq_limit_a * BAND_SHARE * s->scale.inv_current);
    const float ohm = p->motor_resistance_ohm + (p->motor_lq_h * (float)DRIVE_PWM_HZ / (float)p->speed_divider);
    m->band_per_volt = drive_number(BAND_SHARE * 0.57735027f / ohm * s->scale.voltage_v * s->scale.inv_current);
    m->samples = (samples < 16000.0f) ? (uint16_t)samples : 16000U; /* twice that is counted, too */
    m->samples = ((m->samples == 0U) && (p->speed_deviation_s > 0.0f)) ? 1U : m->samples;
    const float mean = MEAN_S * (float)DRIVE_PWM_HZ / (float)p->speed_divider;
    m->mean_samples = (mean > 1.0f) ? (uint16_t)(mean + 0.5f) : 1U;
    m->per_mean_sample = drive_number(1.0f / (float)m->mean_samples);
    m->due_per_sample = (m->samples > 0U)
                            ? drive_number(0.25f * p->over_speed_rad_s * MARGIN_SHARE * s->scale.inv_speed / (float)m->samples)
                            : (num_t)0;
    const float travel = SPEED_COUNTS / p->encoder_counts; /* turns, below 1/4 */
    m->travel = (angle_t)(travel * 4294967296.0f);
    m->zero = (p->zero_check != 0U) && (p->encoder_counts >= (COUNTS_PER_CYCLE * (float)p->pole_pairs));
    const float per_amp = s->scale.current_a * s->scale.inv_voltage;
    m->ohm = drive_number(p->motor_resistance_ohm * per_amp);
    m->reactance_d = drive_number(p->motor_ld_h * (float)p->pole_pairs * s->scale.speed_rad_s * per_amp);
    m->reactance = drive_number(p->motor_lq_h * (float)p->pole_pairs * s->scale.speed_rad_s * per_amp);
    make_stall(p, s);
}

/* ---- angle, current interrupt ------------------------------------------------------------------------------------------- */

angle_t drive_true_angle(const drive_t *d, angle_t shown)
{
    const drive_tracking_setup_t *const s = &d->setup->tracking;
    const angle_t                       theta = s->encoder_reversed ? (0U - shown) : shown;
    num_t                               slope;
    return s->corrects ? (theta - angle_step_from_rad_unchecked(ctl_fourier(&s->error, theta, &slope))) : theta;
}

/* Whatever the first sample shows is what track() expects, and so is the second; its step is known from then on. */
void drive_find_angle(drive_t *d, angle_t theta)
{
    drive_tracking_t *const t = &d->tracking;
    if (t->known == DRIVE_ANGLE_KNOWN) {
        return;
    }
    if (t->known == DRIVE_ANGLE_UNKNOWN) {
        ctl_pll_reset(&t->pll, theta);
    }
    if (t->known != DRIVE_ANGLE_SEEN) {
        t->theta_m = theta; /* no step yet */
    }
    t->expected = theta;
    t->known = (t->known == DRIVE_ANGLE_SEEN) ? DRIVE_ANGLE_KNOWN : DRIVE_ANGLE_SEEN;
}

angle_t drive_judge_motion(drive_t *d, float speed_abs_rad_s)
{
    drive_tracking_t *const t = &d->tracking;
    const angle_t           jump = d->setup->motion.jump;
    const angle_t           theta = drive_true_angle(d, d->sample.theta_m);
    const float             limit = d->params->over_speed_rad_s;

    if (!(speed_abs_rad_s <= limit)) {
        drive_trip(d, FAULT_over_speed);
    }
    if (((theta - t->expected) + jump) <= (2U * jump)) {
        t->jump_periods = 0U;
        return theta;
    }
    if (d->sample.seq != (t->jump_seq + 1U)) {
        t->jump_periods = 0U; /* the last sample was none */
    }
    t->jump_seq = d->sample.seq;
    if (t->jump_periods < d->params->encoder_jump_periods) {
        t->jump_periods++;
        return t->expected;
    }
    drive_trip(d, FAULT_encoder_lost);
    t->jump_periods = 0U;
    t->known = DRIVE_ANGLE_AGAIN; /* follow it from where it is now */
    return theta;
}

/* ---- torque and voltage, speed interrupt ---------------------------------------------------------------------------------- */

/* How the voltage stands to what there is of it. */
typedef struct {
    num_t dc, usable;
    bool  cut; /* The current loop could not exceed it. */
} voltage_t;

static voltage_t look_at_voltage(const drive_t *d)
{
    const ctl_dq_t  v = d->current.volt;
    const num_t     dc = drive_per_base(d->sample.vdc_v, d->scale.inv_voltage);
    const num_t     usable = num_mul(USABLE_SHARE, num_min(d->setup->current.voltage_limit, num_mul(dc, INV_SQRT3)));
    const voltage_t out = {dc, usable, num_mac(num_mul(v.d, v.d), v.q, v.q) > num_mul(usable, usable)};
    return out;
}

/* Turning with the torque, with all the voltage there is on the q axis: the back-EMF stands against the current, so the zero is
 * right, and the drive is too fast for the torque asked for. */
static bool lacks_voltage(const drive_t *d, const voltage_t *v, bool forwards, num_t along)
{
    const num_t push = forwards ? d->current.volt.q : num_neg(d->current.volt.q);
    return v->cut && (along > (num_t)0) && (push > num_mul(NUM_C(0.5f), v->usable));
}

/* The back-EMF stands on the q axis and has the sign of the speed, by more than the resistance may be wrong. */
static bool sees_right_zero(const drive_t *d, const voltage_t *v)
{
    const drive_motion_setup_t *const s = &d->setup->motion;
    const num_t                       speed = d->speed.meas;
    const ctl_dq_t                    i = d->current.meas;
    const num_t                       drop = num_mul(s->ohm, i.q);
    const num_t emf_q = num_sub(num_sub(d->current.volt.q, drop), num_mul(num_mul(s->reactance_d, speed), i.d));
    const num_t emf_d = num_mac(d->current.volt.d, num_mul(s->reactance, speed), i.q);
    const num_t doubt = num_mac(num_mul(OHM_SHARE, num_abs(drop)), FLOOR_SHARE, v->dc); /* temperature; dead time */
    return ((speed > (num_t)0) ? emf_q : num_neg(emf_q)) > num_add(num_abs(emf_d), doubt);
}

/* A stretch at the limit begins again with another torque and with every gain over its slowest moment. At its end the speed must have
 * kept what it had. */
static void trip_against_torque(drive_t *d, bool fresh, bool forwards, num_t along)
{
    drive_motion_t *const m = &d->motion;
    const num_t           margin = d->setup->motion.margin;
    bool                  again = fresh || (num_sub(along, m->slowest) > margin);

    if (!again && (m->samples >= d->setup->motion.samples) &&
        (angle_size(d->tracking.theta_m - m->from) >= d->setup->motion.travel)) {
        if (num_sub(m->first, along) > num_mac(margin, RIPPLE_SHARE, num_abs(along))) {
            drive_trip(d, FAULT_speed_deviation);
        }
        again = true;
    }
    if (again) {
        m->forwards = forwards;
        m->first = along;
        m->slowest = along;
        m->from = d->tracking.theta_m;
        m->samples = 0U;
    } else {
        m->slowest = num_min(m->slowest, along);
        m->samples = (uint16_t)(m->samples + ((m->samples < UINT16_MAX) ? 1U : 0U));
    }
}

/* At the limit the speed has to come nearer to the one that is asked for: nearer than it has been, and on the whole by a little in
 * every such time; a ripple that swings back is neither. */
static void trip_without_approach(drive_t *d, const voltage_t *v, bool fresh, bool forwards, num_t along)
{
    drive_motion_t *const             m = &d->motion;
    const drive_motion_setup_t *const s = &d->setup->motion;
    const uint16_t                    time = 2U * s->samples;
    const num_t                       wanted = forwards ? m->asked : num_neg(m->asked);

    if (fresh || (num_sub(wanted, along) <= s->margin)) {
        m->nearest = along;
        m->due = along;
        m->since = 0U;
        m->pushing = 0U;
        m->pushed_from = d->tracking.theta_m;
        m->travelled = false;
        return;
    }
    m->due = num_add(m->due, s->due_per_sample);
    m->pushing = (uint16_t)(m->pushing + ((m->pushing < UINT16_MAX) ? 1U : 0U));
    m->since++;
    if (num_sub(along, m->nearest) > num_mul(NEARER_SHARE, s->margin)) {
        m->nearest = along;
        m->since = 0U;
    }
    m->travelled |= angle_size(d->tracking.theta_m - m->pushed_from) >= s->travel;
    if (m->travelled && ((m->since >= time) || ((m->pushing >= time) && (along < m->due)))) {
        if (!sees_right_zero(d, v)) {
            drive_trip(d, FAULT_speed_deviation);
        }
        m->nearest = along;
        m->due = along;
        m->since = 0U;
        m->pushing = 0U;
    }
}

/* The speed asked for would have turned the shaft by now, and the encoder shows no motion: a blocked shaft, a stuck encoder, which
 * its tracking filter does not notice, or a zero that is off by a quarter turn. */
static void trip_on_stall(drive_t *d, bool at_limit)
{
    drive_motion_t *const             m = &d->motion;
    const drive_motion_setup_t *const s = &d->setup->motion;
    const angle_t                     now = d->tracking.theta_m;
    const bool moves = ((now - m->stall_from) + s->stall_angle) > (2U * s->stall_angle); /* in either direction */

    if (!at_limit || moves) {
        m->stall_from = now;
        m->stall_samples = 0U;
        m->stall_travel = (num_t)0;
        return;
    }
    m->stall_travel = num_add(m->stall_travel, num_abs(m->asked));
    if (m->stall_samples < s->stall_samples) {
        m->stall_samples++;
    } else if (m->stall_travel >= s->stall_travel) {
        drive_trip(d, FAULT_stall);
    } else {
        /* at so low a speed a shaft that turns stands for longer */
    }
}

static void judge_zero(drive_t *d, ctl_dq_t current, num_t speed, num_t volt_q, const voltage_t *v)
{
    drive_motion_t *const             m = &d->motion;
    const drive_motion_setup_t *const s = &d->setup->motion;
    const num_t                       faster = num_sub(speed, m->speed);
    const num_t                       higher = num_sub(volt_q, m->volt_q);
    const num_t                       band = num_min(s->band, num_mul(s->band_per_volt, v->dc));

    if (!m->held || (num_abs(num_sub(current.q, m->current.q)) > band) || (num_abs(num_sub(current.d, m->current.d)) > band) ||
        m->sum_cut) {
        m->held = !m->sum_cut;
    } else if ((num_abs(higher) < num_mul(FLOOR_SHARE, v->dc)) ||
               (num_abs(faster) < num_mac(s->margin, SPEED_SHARE, num_abs(speed)))) {
        return; /* no verdict yet */
    } else if ((higher > (num_t)0) == (faster > (num_t)0)) {
        m->against = 0U;
        m->first = m->slowest =
            m->forwards ? speed : num_neg(speed); /* the torque has the sign that was asked for: a load is stronger */
        m->from = d->tracking.theta_m;
        m->samples = 0U;
    } else {
        m->against++;
        if (m->against >= AGAINST_LIMIT) {
            drive_trip(d, FAULT_electrical_zero);
        }
    }
    m->current = current;
    m->speed = speed;
    m->volt_q = volt_q;
}

static void forget_sums(drive_motion_t *m)
{
    m->sum_current.d = m->sum_current.q = (num_t)0;
    m->sum_speed = m->sum_volt_q = (num_t)0;
    m->summed = 0U;
    m->sum_cut = false;
}

/* By means over MEAN_S: the voltage equation is linear, so it holds for means of all its terms as it does for them. */
static void trip_on_wrong_zero(drive_t *d, const voltage_t *v)
{
    drive_motion_t *const m = &d->motion;
    const num_t           share = d->setup->motion.per_mean_sample;

    m->sum_current.d = num_mac(m->sum_current.d, share, d->current.meas.d);
    m->sum_current.q = num_mac(m->sum_current.q, share, d->current.meas.q);
    m->sum_speed = num_mac(m->sum_speed, share, d->speed.meas);
    m->sum_volt_q = num_mac(m->sum_volt_q, share, d->current.volt.q);
    m->sum_cut |= v->cut;
    m->summed++;
    if (m->summed >= d->setup->motion.mean_samples) {
        judge_zero(d, m->sum_current, m->sum_speed, m->sum_volt_q, v);
        forget_sums(m);
    }
}

void drive_check_motion(drive_t *d)
{
    drive_motion_t *const m = &d->motion;
    const num_t           torque = d->current.ref.q;

    if (d->state != DRIVE_RUN) {
        forget_sums(m);
        m->held = false;
        m->against = 0U;
        m->samples = 0U;
        m->stall_samples = 0U;
        return;
    }
    const voltage_t    v = look_at_voltage(d);
    const drive_mode_t mode = drive_active_command(d)->mode;
    if ((mode == DRIVE_MODE_SPEED) || (mode == DRIVE_MODE_POSITION)) {
        const bool at_limit = drive_is_at_limit(d);
        if (d->setup->motion.samples != 0U) {
            const bool  forwards = torque > (num_t)0;
            const num_t along = forwards ? d->speed.meas : num_neg(d->speed.meas);
            const bool  fresh = !at_limit || (forwards != m->forwards) || lacks_voltage(d, &v, forwards, along);
            trip_without_approach(d, &v, fresh, forwards, along);
            trip_against_torque(d, fresh, forwards, along);
        }
        if (d->setup->motion.stall_samples != 0U) {
            trip_on_stall(d, at_limit);
        }
    }
    if (d->setup->motion.zero) {
        trip_on_wrong_zero(d, &v);
    }
}
