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
    ctl_deadbeat_reset(&self->state);
    return ctl_diag_ok();
}

void ctl_deadbeat_reset(ctl_deadbeat_state_t *state)
{
    const ctl_dq_t zero = {(num_t)0, (num_t)0};
    state->predicted = zero;
    state->c = zero;
    state->ref = zero;
    state->primed = false;
}

ctl_dq_t ctl_deadbeat_step(ctl_deadbeat_t *self, const ctl_dq_t *meas, const ctl_dq_t *ref, num_t speed, const ctl_dq_t *v_last)
{
    ctl_deadbeat_state_t *const s = &self->state;
    uint32_t *const             rejected = &s->rejected;
    const ctl_dq_t              i = {num_guard(meas->d, s->predicted.d, rejected), num_guard(meas->q, s->predicted.q, rejected)};
    const num_t                 w = num_guard(speed, (num_t)0, rejected);
    const ctl_dq_t              v = {num_guard(v_last->d, (num_t)0, rejected), num_guard(v_last->q, (num_t)0, rejected)};
    const ctl_dq_t              r = {num_guard(ref->d, s->ref.d, rejected), num_guard(ref->q, s->ref.q, rejected)};
    const ctl_dq_t              out = ctl_deadbeat_step_unchecked(&self->params, s, i, r, w, v);
    /* inputs at the end of their range, multiplied four times, leave it: then there is no prediction */
    s->predicted.d = num_is_finite(s->predicted.d) ? s->predicted.d : i.d;
    s->predicted.q = num_is_finite(s->predicted.q) ? s->predicted.q : i.q;
    return out;
}
