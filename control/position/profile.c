#include "control/position/profile.h"

#include "control/position/ramp.h"

ctl_diag_t ctl_profile_check(const ctl_profile_params_t *params)
{
    if ((params->speed < 1) || (params->speed > CTL_RAMP_STEP_MAX)) {
        return ctl_diag(CTL_ERR_RANGE, CTL_PROFILE_SPEED, (num_t)0);
    }
    if ((params->acceleration < 0) || (params->acceleration > CTL_RAMP_STEP_MAX)) {
        return ctl_diag(CTL_ERR_RANGE, CTL_PROFILE_ACCELERATION, (num_t)0);
    }
    if ((params->smooth < 1U) || (params->smooth > CTL_PROFILE_SMOOTH_MAX)) {
        return ctl_diag_count(CTL_ERR_RANGE, CTL_PROFILE_SMOOTH, params->smooth);
    }
    ctl_diag_t d = ctl_diag_range(params->speed_scale, NUM_EPS, NUM_MAX, CTL_PROFILE_SCALE);
    ctl_diag_also(&d, params->accel_scale, NUM_EPS, NUM_MAX, CTL_PROFILE_SCALE);
    return d;
}

ctl_diag_t ctl_profile_init(ctl_profile_t *self, const ctl_profile_params_t *params)
{
    const ctl_diag_t d = ((self == NULL) || (params == NULL)) ? ctl_diag(CTL_ERR_NULL, 0U, (num_t)0) : ctl_profile_check(params);
    if (d.status == CTL_OK) {
        self->params = *params;
        ctl_profile_reset(&self->state, 0);
    }
    return d;
}

/* Moving at one speed for longer than the mean is long: the trapezoid is ahead by (n - 1) / 2 steps, and half a unit of an
 * odd number of them is in `remainder`. */
static void settle(ctl_profile_state_t *s, uint16_t smooth, int64_t step)
{
    const int64_t n = (int64_t)smooth;
    const int64_t twice = step * (n - 1);
    const int64_t odd = (int64_t)((uint64_t)twice & 1U);
    const int64_t left = (twice < 0) ? -odd : odd; /* of twice / 2, as its remainder */
    const int64_t half = (int64_t)(smooth >> 1);
    s->raw = ctl_position_add(s->position, (twice - left) >> 1); /* even; arithmetic on every compiler that builds this */
    s->remainder = (left == 0) ? 0 : ((left > 0) ? -half : half);
    s->step = step;
    s->last = step;
    s->sum = step * n;
    s->head = 0U;
    s->smooth = smooth;
    s->still = (step == 0) ? smooth : 0U;
    s->settled = step;
    s->known = 0U;
}

ctl_diag_t ctl_profile_tune(ctl_profile_t *self, const ctl_profile_params_t *params)
{
    const ctl_diag_t d = ((self == NULL) || (params == NULL)) ? ctl_diag(CTL_ERR_NULL, 0U, (num_t)0) : ctl_profile_check(params);
    if (d.status == CTL_OK) {
        self->params = *params;
    }
    return d;
}

void ctl_profile_shift(ctl_profile_state_t *state, ctl_position_t shift)
{
    state->raw = ctl_position_sub(state->raw, shift);
    state->position = ctl_position_sub(state->position, shift);
}

void ctl_profile_reset(ctl_profile_state_t *state, ctl_position_t position)
{
    state->position = position;
    state->last = 0;
    state->smooth = 0U;
}

/* x / n, cut towards zero, for |x| < 2^47 and n < 2^15: two quotients of 32 bits, which take a tenth of one of 64. */
static int64_t quotient(int64_t x, uint16_t n)
{
    const uint64_t size = (uint64_t)((x < 0) ? -x : x);
    const uint32_t top = (uint32_t)(size >> 16);
    const uint32_t high = top / n;
    const uint32_t low = (((top - (high * n)) << 16) | ((uint32_t)size & 0xFFFFU)) / n;
    const int64_t  whole = (int64_t)(((uint64_t)high << 16) + low);
    return (x < 0) ? -whole : whole;
}

ctl_setpoint_t ctl_profile_step(ctl_profile_t *self, ctl_position_t target)
{
    return ctl_profile_step_unchecked(&self->params, &self->state, target);
}

ctl_setpoint_t ctl_profile_step_unchecked(const ctl_profile_params_t *p, ctl_profile_state_t *s, ctl_position_t target)
{
    if (s->smooth != p->smooth) {
        settle(s, p->smooth, s->last);
    }
    s->step = ctl_ramp_next(p->speed, p->acceleration, ctl_position_sub(target, s->raw), s->step);
    s->raw = ctl_position_add(s->raw, s->step);

    s->head = (uint16_t)(((s->head + 1U) < p->smooth) ? (s->head + 1U) : 0U);
    const bool all_known = s->known >= p->smooth;
    s->sum += s->step - *(all_known ? &s->past[s->head] : &s->settled);
    s->past[s->head] = s->step;
    s->known = (uint16_t)(s->known + (all_known ? 0U : 1U));
    const int64_t  whole = s->sum + s->remainder;
    const uint16_t samples = (p->smooth > 0U) ? p->smooth : 1U; /* parameters that nobody has made */
    const int64_t  step = quotient(whole, samples);             /* 64 steps of 31 bits, and a remainder below one */
    s->remainder = whole - (step * (int64_t)samples);
    s->position = ctl_position_add(s->position, step);

    ctl_setpoint_t out;
    out.position = s->position;
#ifdef EVENSPIN_FIXED
    /* steps and their changes are below 2^31 and a little: the products fit */
    out.speed = num_sat64(((step * p->speed_scale) + 0x8000) >> 16);
    out.acceleration = (p->acceleration > 0) ? num_sat64((((step - s->last) * p->accel_scale) + 0x800) >> 12) : 0;
#else
    out.speed = ctl_float_of_long(step) * (1.0f / 65536.0f) * p->speed_scale;
    out.acceleration = (p->acceleration > 0) ? (ctl_float_of_long(step - s->last) * (1.0f / 4096.0f) * p->accel_scale) : 0.0f;
#endif
    s->last = step;
    s->still = (s->step != 0) ? 0U : (uint16_t)((s->still < p->smooth) ? (s->still + 1U) : s->still);
    out.done = (s->position == target) && (s->still == p->smooth);
    return out;
}
