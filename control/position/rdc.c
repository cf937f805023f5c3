#include "control/position/rdc.h"

ctl_diag_t ctl_rdc_init(ctl_rdc_t *self, const ctl_rdc_params_t *params)
{
    if ((self == NULL) || (params == NULL)) {
        return ctl_diag(CTL_ERR_NULL, 0U, (num_t)0);
    }
    ctl_diag_t d = ctl_diag_range(params->inertia, (num_t)0, NUM_MAX, CTL_RDC_INERTIA);
    if (d.status == CTL_OK) {
        d = ctl_friction_check(&params->friction);
        if (d.status != CTL_OK) {
            d.field = (d.field == (uint16_t)CTL_FRICTION_STATIC) ? (uint16_t)CTL_RDC_STATIC : (uint16_t)CTL_RDC_FRICTION;
        }
    }
    if (d.status == CTL_OK) {
        d = ctl_harmonics_check(&params->harmonics);
        d.field = (d.status == CTL_OK) ? 0U : (uint16_t)CTL_RDC_HARMONICS;
    }
    for (uint16_t i = 0U; (i < 3U) && (d.status == CTL_OK); i++) {
        d = ctl_diag_range(params->p_row[i], -NUM_MAX, NUM_MAX, CTL_RDC_P);
    }
    ctl_diag_also(&d, params->rho, (num_t)0, NUM_MAX, CTL_RDC_RHO);
    ctl_diag_also(&d, params->sigma, NUM_EPS, NUM_MAX, CTL_RDC_SIGMA);
    ctl_diag_also(&d, params->sample_s, NUM_EPS, NUM_MAX, CTL_RDC_SAMPLE);
    ctl_diag_also(&d, params->integral_max, NUM_EPS, NUM_MAX, CTL_RDC_SAMPLE);
    if (d.status == CTL_OK) {
        self->params = *params;
        self->state.rejected = 0U;
        ctl_rdc_reset(&self->state);
    }
    return d;
}

void ctl_rdc_reset(ctl_rdc_state_t *state)
{
    state->x1 = (num_t)0;
    state->robust = (num_t)0;
    state->fed = (num_t)0;
}

num_t ctl_rdc_robust(num_t s, num_t rho, num_t sigma)
{
    if (s > sigma) {
        return num_neg(rho);
    }
    if (s < num_neg(sigma)) {
        return rho;
    }
    return num_is_finite(s) ? num_neg(num_mul(rho, num_div(s, sigma))) : (num_t)0;
}

num_t ctl_rdc_step(ctl_rdc_t *self, const ctl_setpoint_t *command, num_t error, num_t speed_error)
{
    uint32_t *const rejected = &self->state.rejected;
    ctl_setpoint_t  c = *command;
    c.speed = num_guard(c.speed, (num_t)0, rejected);
    c.acceleration = num_guard(c.acceleration, (num_t)0, rejected);
    const num_t e = num_guard(error, (num_t)0, rejected);
    return ctl_rdc_step_unchecked(&self->params, &self->state, &c, e, num_guard(speed_error, (num_t)0, rejected));
}
