#include "control/observer/fir.h"

#include "control/numeric/angle.h"

/* sin(x) / x with x = 2 pi c d: the ideal low-pass of corner c (of the rate), d samples from its middle, but for a factor
 * that the normalisation removes. Without it fixed point keeps its digits at low corners. */
static num_t ideal(num_t cutoff, uint16_t twice_d)
{
    const num_t x = num_mul(num_mul(cutoff, NUM_C(3.14159265f)), num_from_int((int16_t)twice_d)); /* at most 23.6 rad */
    if (x < NUM_C(0.25f)) {                                                                       /* x^6 / 5040 is 5e-8 there */
        const num_t x2 = num_mul(x, x);
        return num_mac(NUM_C(1.0f), num_mac(NUM_C(-0.16666667f), NUM_C(0.0083333333f), x2), x2);
    }
    num_t sine, cosine;
    angle_sincos(angle_from_rad(x), &sine, &cosine);
    return num_div(sine, x);
}

ctl_diag_t ctl_fir_design(ctl_fir_params_t *params, uint16_t order, num_t cutoff)
{
    if (params == NULL) {
        return ctl_diag(CTL_ERR_NULL, 0U, (num_t)0);
    }
    if (order > CTL_FIR_ORDER_MAX) {
        return ctl_diag_count(CTL_ERR_RANGE, CTL_FIR_ORDER, order);
    }
    if (!((cutoff >= NUM_C(0.0001f)) && (cutoff < NUM_C(0.5f)))) {
        return ctl_diag(CTL_ERR_RANGE, CTL_FIR_CUTOFF, cutoff);
    }
    num_t sum = (num_t)0;
    params->order = order;
    for (uint16_t i = 0U; i <= CTL_FIR_ORDER_MAX; i++) {
        params->tap[i] = (num_t)0;
    }
    for (uint16_t i = 0U; (2U * i) <= order; i++) {
        num_t window = NUM_C(1.0f);
        if (order > 0U) { /* 0.54 - 0.46 cos(2 pi i / n) */
            num_t sine, cosine;
            angle_sincos((angle_t)(((uint64_t)i << 32) / order), &sine, &cosine);
            window = num_mac(NUM_C(0.54f), NUM_C(-0.46f), cosine);
        }
        const num_t    tap = num_mul(window, ideal(cutoff, (uint16_t)(order - (2U * i))));
        const uint16_t mirror = (uint16_t)(order - i);
        params->tap[i] = tap;
        params->tap[mirror] = tap;
        sum = num_add(sum, (mirror > i) ? num_add(tap, tap) : tap);
    }
    for (uint16_t i = 0U; i <= order; i++) {
        params->tap[i] = num_div(params->tap[i], sum);
    }
    return ctl_diag_ok();
}

ctl_diag_t ctl_fir_check(const ctl_fir_params_t *params)
{
    if (params->order > CTL_FIR_ORDER_MAX) {
        return ctl_diag_count(CTL_ERR_RANGE, CTL_FIR_ORDER, params->order);
    }
    num_t size = (num_t)0;
    for (uint16_t i = 0U; i <= params->order; i++) {
        const num_t h = params->tap[i];
        size = num_add(size, num_abs(h));
        if (!num_is_finite(h) || !(size <= NUM_C(4.0f)) ||
            !(num_abs(num_sub(h, params->tap[params->order - i])) <= NUM_C(2.5e-7f))) {
            return ctl_diag(CTL_ERR_RANGE, CTL_FIR_TAP, h);
        }
    }
    return ctl_diag_ok();
}

ctl_diag_t ctl_fir_init(ctl_fir_t *self, const ctl_fir_params_t *params)
{
    if ((self == NULL) || (params == NULL)) {
        return ctl_diag(CTL_ERR_NULL, 0U, (num_t)0);
    }
    const ctl_diag_t d = ctl_fir_check(params);
    if (d.status == CTL_OK) {
        ctl_fir_tune(self, params);
        self->state.rejected = 0U;
        ctl_fir_reset(self, (num_t)0);
    }
    return d;
}

void ctl_fir_tune(ctl_fir_t *self, const ctl_fir_params_t *params)
{
    self->order = params->order;
    for (uint16_t i = 0U; i < CTL_FIR_PAIRS; i++) {
        const uint16_t twice = (uint16_t)(2U * i);
        const num_t    h = params->tap[i];
        self->fold[i] = (twice < params->order) ? h : ((twice == params->order) ? num_mul(h, NUM_C(0.5f)) : (num_t)0);
    }
}

void ctl_fir_reset(ctl_fir_t *self, num_t x)
{
    ctl_window_fill(&self->state.past, num_guard(x, (num_t)0, &self->state.rejected));
}

num_t ctl_fir_step(ctl_fir_t *self, num_t x)
{
    return ctl_fir_step_unchecked(self, num_guard(x, ctl_window_newest(&self->state.past)[0], &self->state.rejected));
}
