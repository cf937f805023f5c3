/* A torque that should turn the shaft, or hold it, and does not: what may wait for the main loop (motion_check.h has both, and the stall
 * that the speed interrupt finds). Times are counted in samples of the current interrupt, since no pass is like another. */
#include "control/numeric/num_math.h"
#include "firmware/app/internal.h"

#define PULL_SHARE 0.99f /* of stall_torque_a: rounding must not hide that it is asked for */

void drive_make_stall(const drive_params_t *p, drive_setup_t *s)
{
    drive_stall_setup_t *const m = &s->stall;
    const float count = p->encoder_counts * DRIVE_STALL_TURN; /* the travel from rest grows with the square of the time */
    const float per_s = (float)DRIVE_PWM_HZ * ((count < 1.0f) ? num_to_float(num_sqrt(num_from_float(1.0f / count))) : 1.0f);
    m->slip_periods = (uint32_t)(2.0f * p->stall_s * per_s);
    m->pull_periods = (p->stall_torque_a > 0.0f) ? (uint32_t)(p->stall_torque_s * per_s) : 0U;
    m->pull = drive_number(PULL_SHARE * p->stall_torque_a * s->scale.inv_current);
    m->travel_rad = (float)DRIVE_STALL_MOTIONS * DRIVE_TWO_PI * ((count < 1.0f) ? (1.0f / p->encoder_counts) : DRIVE_STALL_TURN);
}

static void begin_again(drive_t *d, angle_t now)
{
    d->stall.from = now;
    d->stall.since = d->sample.seq;
    d->stall.motions = 0U;
}

/* A shaft that is to rest turns against the torque, slowly. One that is being stopped does so, too: at the end of the time it must
 * still turn. */
static void trip_on_slip(drive_t *d, bool moves, angle_t now)
{
    const num_t margin = d->setup->motion.margin;
    const num_t along = (d->current.ref.q > (num_t)0) ? d->speed.meas : num_neg(d->speed.meas);
    if (!moves) {
        return;
    }
    if ((along >= (num_t)0) || (num_neg(along) > margin) || (num_abs(d->motion.asked) > margin)) {
        begin_again(d, now);
        return;
    }
    d->stall.from = now;
    d->stall.motions++;
    if ((d->stall.motions >= DRIVE_STALL_MOTIONS) && ((d->sample.seq - d->stall.since) >= d->setup->stall.slip_periods)) {
        drive_trip(d, FAULT_stall);
    }
}

/* A motion in either direction is one. In torque mode the limit of the speed has to leave room for it. */
static void trip_on_pull(drive_t *d, bool moves, angle_t now, bool limited)
{
    const uint32_t periods = d->sample.seq - d->stall.since;
    const float    speed = drive_active_command(d)->speed_ref_rad_s;
    const float    most_rad = ((speed < 0.0f) ? -speed : speed) * (float)periods * (1.0f / (float)DRIVE_PWM_HZ);
    if (moves) {
        begin_again(d, now);
    } else if ((periods >= d->setup->stall.pull_periods) && (!limited || (most_rad >= d->setup->stall.travel_rad))) {
        drive_trip(d, FAULT_stall);
    } else {
        /* it may still move */
    }
}

void drive_attend_stall(drive_t *d)
{
    const drive_stall_setup_t *const s = &d->setup->stall;
    const drive_mode_t               mode = drive_active_command(d)->mode;
    const angle_t                    limit = d->setup->motion.stall_angle;
    const angle_t                    now = d->tracking.theta_m;
    const bool                       moves = ((now - d->stall.from) + limit) > (2U * limit);
    const bool                       slips = (mode == DRIVE_MODE_SPEED) || (mode == DRIVE_MODE_POSITION);
    const bool                       pushes = slips ? drive_is_at_limit(d) : (num_abs(d->current.torque) >= s->pull);

    if ((d->state != DRIVE_RUN) || !pushes || ((slips ? s->slip_periods : s->pull_periods) == 0U)) {
        begin_again(d, now);
    } else if (slips) {
        trip_on_slip(d, moves, now);
    } else {
        trip_on_pull(d, moves, now, mode == DRIVE_MODE_TORQUE);
    }
}
