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
    if (d.status == CTL_OK) {
        d = ctl_diag_range(params->rho, (num_t)0, NUM_MAX, CTL_RDC_RHO);
    }
    if (d.status == CTL_OK) {
        d = ctl_diag_range(params->sigma, NUM_EPS, NUM_MAX, CTL_RDC_SIGMA);
    }
    if (d.status == CTL_OK) {
        d = ctl_diag_range(params->sample_s, NUM_EPS, NUM_MAX, CTL_RDC_SAMPLE);
    }
    if (d.status == CTL_OK) {
        d = ctl_diag_range(params->integral_max, NUM_EPS, NUM_MAX, CTL_RDC_SAMPLE);
    }
    if (d.status == CTL_OK) {
        self->params = *params;
        self->state.rejected = 0U;
        ctl_rdc_reset(self);
    }
    return d;
}

void ctl_rdc_reset(ctl_rdc_t *self)
{
    self->state.x1 = (num_t)0;
    self->state.robust = (num_t)0;
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
    const ctl_rdc_params_t *const p = &self->params;
    ctl_rdc_state_t *const        s = &self->state;
    const num_t                   x2 = num_guard(error, (num_t)0, &s->rejected);
    const num_t                   x3 = num_guard(speed_error, (num_t)0, &s->rejected);
    const num_t                   v = num_guard(command->speed, (num_t)0, &s->rejected);
    const num_t                   a = num_guard(command->acceleration, (num_t)0, &s->rejected);

    s->x1 = num_clamp(num_mac(s->x1, p->sample_s, x2), num_neg(p->integral_max), p->integral_max);
    const num_t measure = num_mac(num_mac(num_mul(p->p_row[0], s->x1), p->p_row[1], x2), p->p_row[2], x3);
    s->robust = ctl_rdc_robust(measure, p->rho, p->sigma);

    const num_t model = num_mac(num_add(ctl_friction(&p->friction, v), ctl_harmonics(&p->harmonics, command->position)), p->inertia, a);
    return num_add(model, s->robust);
}
