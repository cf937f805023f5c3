#include "control/motor/deadbeat.h"

ctl_diag_t ctl_deadbeat_init(ctl_deadbeat_t *self, const ctl_deadbeat_params_t *params)
{
    if ((self == NULL) || (params == NULL)) {
        return ctl_diag(CTL_ERR_NULL, 0U, (num_t)0);
    }
    const struct {
        num_t    value, min, max;
        uint16_t field;
    } row[] = {
        {params->r, (num_t)0, NUM_MAX, CTL_DEADBEAT_R},
        {params->ld_ts, NUM_EPS, NUM_MAX, CTL_DEADBEAT_LD},
        {params->ts_ld, NUM_EPS, NUM_MAX, CTL_DEADBEAT_LD},
        {params->w_ld, (num_t)0, NUM_MAX, CTL_DEADBEAT_LD},
        {params->lq_ts, NUM_EPS, NUM_MAX, CTL_DEADBEAT_LQ},
        {params->ts_lq, NUM_EPS, NUM_MAX, CTL_DEADBEAT_LQ},
        {params->w_lq, (num_t)0, NUM_MAX, CTL_DEADBEAT_LQ},
        {params->w_psi, (num_t)0, NUM_MAX, CTL_DEADBEAT_PSI},
        {params->correction, (num_t)0, NUM_C(0.5f), CTL_DEADBEAT_CORRECTION},
        {params->c_max, NUM_EPS, NUM_MAX, CTL_DEADBEAT_LIMIT},
        {params->v_max, NUM_EPS, NUM_MAX, CTL_DEADBEAT_LIMIT},
    };
    for (uint16_t i = 0U; i < (uint16_t)(sizeof row / sizeof row[0]); i++) {
        const ctl_diag_t d = ctl_diag_range(row[i].value, row[i].min, row[i].max, row[i].field);
        if (d.status != CTL_OK) {
            return d;
        }
    }
    self->params = *params;
    self->state.rejected = 0U;
    ctl_deadbeat_reset(self);
    return ctl_diag_ok();
}

void ctl_deadbeat_reset(ctl_deadbeat_t *self)
{
    const ctl_dq_t zero = {(num_t)0, (num_t)0};
    self->state.predicted = zero;
    self->state.c = zero;
    self->state.ref = zero;
    self->state.primed = false;
}

/* (3) and the resistance: voltage that the winding takes besides L di/dt */
static ctl_dq_t drop(const ctl_deadbeat_params_t *p, num_t i_d, num_t i_q, num_t w)
{
    const ctl_dq_t v = {num_sub(num_mul(p->r, i_d), num_mul(w, num_mul(p->w_lq, i_q))),
                        num_mac(num_mul(p->r, i_q), w, num_mac(p->w_psi, p->w_ld, i_d))};
    return v;
}

static num_t sane(num_t x, num_t bound)
{
    return num_clamp(x, num_neg(bound), bound);
}

/* Inputs at the end of their range, multiplied four times, leave it: then there is no prediction. */
static num_t calculable(num_t x, num_t otherwise) { return num_is_finite(x) ? x : otherwise; }

ctl_dq_t ctl_deadbeat_step(ctl_deadbeat_t *self, const ctl_dq_t *meas, const ctl_dq_t *ref, num_t speed, const ctl_dq_t *v_last)
{
    const ctl_deadbeat_params_t *const p = &self->params;
    ctl_deadbeat_state_t *const        s = &self->state;

    const ctl_dq_t i = {num_guard(meas->d, s->predicted.d, &s->rejected), num_guard(meas->q, s->predicted.q, &s->rejected)};
    const num_t    w = num_guard(speed, (num_t)0, &s->rejected);
    const ctl_dq_t v = {num_guard(v_last->d, (num_t)0, &s->rejected), num_guard(v_last->q, (num_t)0, &s->rejected)};
    s->ref.d = num_guard(ref->d, s->ref.d, &s->rejected);
    s->ref.q = num_guard(ref->q, s->ref.q, &s->rejected);

    if (s->primed) { /* (4) */
        s->c.d = sane(num_mac(s->c.d, p->correction, num_sub(i.d, s->predicted.d)), p->c_max);
        s->c.q = sane(num_mac(s->c.q, p->correction, num_sub(i.q, s->predicted.q)), p->c_max);
    }
    s->primed = true;

    /* (1): a first guess with the drop of now, then with the drop in the middle of the way */
    const ctl_dq_t now = drop(p, i.d, i.q, w);
    const num_t    rise_d = num_mac(s->c.d, p->ts_ld, num_sub(v.d, now.d));
    const num_t    rise_q = num_mac(s->c.q, p->ts_lq, num_sub(v.q, now.q));
    const ctl_dq_t mid = drop(p, num_mac(i.d, NUM_C(0.5f), rise_d), num_mac(i.q, NUM_C(0.5f), rise_q), w);
    s->predicted.d = calculable(num_add(num_mac(i.d, p->ts_ld, num_sub(v.d, mid.d)), s->c.d), i.d);
    s->predicted.q = calculable(num_add(num_mac(i.q, p->ts_lq, num_sub(v.q, mid.q)), s->c.q), i.q);

    /* (2), the drop in the middle between i1 and the reference */
    const ctl_dq_t later = drop(p, num_mul(num_add(s->predicted.d, s->ref.d), NUM_C(0.5f)),
                                num_mul(num_add(s->predicted.q, s->ref.q), NUM_C(0.5f)), w);
    const ctl_dq_t out = {
        sane(num_mac(later.d, p->ld_ts, num_sub(num_sub(s->ref.d, s->predicted.d), s->c.d)), p->v_max),
        sane(num_mac(later.q, p->lq_ts, num_sub(num_sub(s->ref.q, s->predicted.q), s->c.q)), p->v_max),
    };
    return out;
}
