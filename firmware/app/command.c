/* What the user wants, from the main loop to the interrupts: judged, bounded by the limits in force, handed over as a whole. */
#include <stddef.h>

#include "control/numeric/num_math.h"
#include "firmware/app/internal.h"
#include "firmware/app/memory_check.h"

#define NUMBER_MAX 1.0e6f

/* The set in force, or the one that waits for the interrupt: what the command will meet. */
static const drive_params_t *coming(const drive_t *d) { return &drive_newest(d)->params; }

static bool inside(float x, float limit) { return (x <= limit) && (x >= -limit); } /* false for NaN */

static float cut(float x, float limit) { return (x > limit) ? limit : ((x < -limit) ? -limit : x); }

/* What @p id leaves for the q axis: the d axis comes first, it may hold the voltage down. */
static float room_a(const drive_params_t *p, float longest, float id_a)
{
    const float part = (longest > 0.0f) ? (id_a / longest) : 1.0f; /* within +-1 */
    const float room = longest * num_to_float(num_sqrt(num_from_float((1.0f - part) * (1.0f + part))));
    return (room < p->iq_limit_a) ? room : p->iq_limit_a;
}

uint16_t drive_command_refuses(const drive_t *d, const drive_command_t *c, float *limit)
{
    const drive_params_t *const p = coming(d);
    const float                 number[4] = {c->speed_ref_rad_s, c->id_ref_a, c->iq_ref_a, c->target_rad};
    static const uint16_t       FIELD[4] = {DRIVE_COMMAND_SPEED, DRIVE_COMMAND_ID, DRIVE_COMMAND_IQ, DRIVE_COMMAND_ANGLE};
    for (uint16_t i = 0U; i < 4U; i++) {
        if (!inside(number[i], NUMBER_MAX)) {
            *limit = NUMBER_MAX;
            return FIELD[i];
        }
    }
    *limit = (float)DRIVE_MODE_SPEED;
    if (((c->mode == DRIVE_MODE_POSITION) && drive_newest(d)->setup.speed.rc_used) ||
        ((c->mode == DRIVE_MODE_TORQUE) && drive_learns_load(d))) {
        return DRIVE_COMMAND_MODE;
    }
    *limit = p->over_speed_rad_s;
    if (!inside(c->speed_ref_rad_s, *limit)) {
        return DRIVE_COMMAND_SPEED;
    }
    *limit = ((c->mode == DRIVE_MODE_CURRENT) || !drive_newest(d)->setup.reference.used) ? drive_id_max_a(p) : 0.0f;
    if (!inside(c->id_ref_a, *limit)) {
        return DRIVE_COMMAND_ID;
    }
    *limit = room_a(p, drive_longest_a(p), c->id_ref_a);
    if (((c->mode == DRIVE_MODE_CURRENT) || (c->mode == DRIVE_MODE_TORQUE)) && !inside(c->iq_ref_a, *limit)) {
        return DRIVE_COMMAND_IQ;
    }
    return DRIVE_COMMAND_FINE;
}

void drive_hand_over(drive_t *d, const drive_command_t *c)
{
    const drive_params_t *const      p = coming(d);
    const uint16_t                   idle = (uint16_t)((d->command_at & 1U) ^ 1U);
    drive_order_t *const             order = &d->order[idle];
    const drive_speed_setup_t *const speed = &drive_newest(d)->setup.speed;
    const float                      longest = drive_longest_a(p) * d->thermal.share;
    const float                      id = cut(cut(c->id_ref_a, drive_id_max_a(p)), longest);
    d->command[idle] = *c;
    d->command[idle].speed_ref_rad_s = cut(c->speed_ref_rad_s, p->over_speed_rad_s);
    order->torque = c->mode == DRIVE_MODE_CURRENT;
    order->id = drive_per_base(id, d->scale.inv_current);
    order->iq = drive_per_base(c->iq_ref_a, d->scale.inv_current);
    order->speed = drive_ramp_steps(d->command[idle].speed_ref_rad_s);
    order->speed_limit = num_abs(drive_per_base(d->command[idle].speed_ref_rad_s, d->scale.inv_speed));
    order->ramp = (d->stopping.how == DRIVE_STOP_RAMP) ? DRIVE_RAMP_STOP : (speed->ramps ? DRIVE_RAMP_SET : DRIVE_RAMP_NONE);
    order->iq_max = drive_per_base(room_a(p, longest, id), d->scale.inv_current);
    drive_order_excitation(d, order);
    order->room = (d->thermal.share < 1.0f) ? drive_per_base(longest, d->scale.inv_current) : NUM_MAX;
    hal_order();
    d->command_at = idle;
    drive_keep_command(d, idle);
}

void drive_command_again(drive_t *d)
{
    const drive_command_t same = d->command[d->command_at & 1U];
    drive_hand_over(d, &same);
}

bool drive_command(drive_t *d, const drive_command_t *command)
{
    float          limit = 0.0f;
    const uint16_t bad = drive_command_refuses(d, command, &limit);
    if ((bad != DRIVE_COMMAND_FINE) && ((limit >= NUMBER_MAX) || (bad == DRIVE_COMMAND_SPEED) || (bad == DRIVE_COMMAND_MODE))) {
        return false;
    }
    if (d->stopping.how == DRIVE_STOP_RAMP) {
        d->stopping.resume = *command; /* for the next start */
    } else {
        drive_forget_excitation(d);
        drive_hand_over(d, command); /* a current beyond its limit is cut */
    }
    return true;
}
