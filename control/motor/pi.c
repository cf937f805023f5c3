#include "control/motor/pi.h"

ctl_diag_t ctl_pi_init(ctl_pi_t *self, const ctl_pi_params_t *params)
{
    if ((self == NULL) || (params == NULL)) {
        return ctl_diag(CTL_ERR_NULL, 0U, (num_t)0);
    }
    ctl_diag_t d = ctl_diag_range(params->kp, (num_t)0, NUM_MAX, CTL_PI_KP);
    ctl_diag_also(&d, params->ki_ts, (num_t)0, NUM_MAX, CTL_PI_KI_TS);
    ctl_diag_also(&d, params->out_min, -NUM_MAX, NUM_MAX, CTL_PI_OUT_MIN);
    ctl_diag_also(&d, params->out_max, -NUM_MAX, NUM_MAX, CTL_PI_OUT_MAX);
    if ((d.status == CTL_OK) && !(params->out_min < params->out_max)) {
        d = ctl_diag(CTL_ERR_RELATION, CTL_PI_OUT_MIN, params->out_min);
    }
    if ((d.status == CTL_OK) && ((uint16_t)params->anti_windup > (uint16_t)CTL_PI_HOLD_OUTWARD)) {
        d = ctl_diag_count(CTL_ERR_RANGE, CTL_PI_ANTI_WINDUP, (uint16_t)params->anti_windup);
    }
    if (d.status != CTL_OK) {
        return d;
    }
    static const ctl_pi_state_t REST = {0};
    ctl_pi_tune(self, params);
    self->state = REST;
    return d;
}

void ctl_pi_reset(ctl_pi_t *self, num_t x)
{
    ctl_pi_state_t *const s = &self->state;
    s->x = num_clamp(num_guard(x, (num_t)0, &s->rejected), self->params.out_min, self->params.out_max);
    s->err = (num_t)0;
    s->wanted = s->x;
#ifdef EVENSPIN_FIXED
    s->below = 0;
#endif
}

/* (2) */
static void integrate(ctl_pi_t *self)
{
#ifdef EVENSPIN_FIXED
    ctl_pi_state_t *const s = &self->state;
    const int64_t         more = ((int64_t)self->params.ki_ts * s->err) + s->below;
    const num_t           sum = num_sat64(s->x + (more >> 24));
    s->x = num_clamp(sum, num_neg(self->bound), self->bound);
    s->below = (s->x == sum) ? (int32_t)(more & INT64_C(0xFFFFFF)) : 0;
#else
    ctl_pi_learn_unchecked(self, self->state.err);
#endif
}

num_t ctl_pi_output(ctl_pi_t *self, num_t err)
{
    ctl_pi_state_t *const s = &self->state;
    s->err = num_guard(err, (num_t)0, &s->rejected);
    s->wanted = ctl_pi_propose_unchecked(self, s->err);
    return num_clamp(s->wanted, self->params.out_min, self->params.out_max);
}

void ctl_pi_commit(ctl_pi_t *self, num_t realised)
{
    ctl_pi_state_t *const s = &self->state;
    const num_t           done = num_guard(realised, s->wanted, &s->rejected);
    bool                  hold = false;
    if (done != s->wanted) {
        const bool too_low = done < s->wanted; /* the actuator could not follow upwards */
        hold = (self->params.anti_windup == CTL_PI_HOLD) || (too_low ? (s->err > (num_t)0) : (s->err < (num_t)0));
    }
    if (!hold) {
        integrate(self);
    }
}
