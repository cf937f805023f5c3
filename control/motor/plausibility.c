#include "control/motor/plausibility.h"

ctl_diag_t ctl_plausibility_init(ctl_plausibility_t *self, const ctl_plausibility_params_t *params)
{
    if ((self == NULL) || (params == NULL)) {
        return ctl_diag(CTL_ERR_NULL, 0U, (num_t)0);
    }
    const struct {
        num_t value, min;
    } row[] = {{params->ld, NUM_EPS},           {params->lq, NUM_EPS},        {params->psi, (num_t)0},
               {params->r_half, (num_t)0},      {params->v, NUM_EPS},         {params->rest, NUM_EPS},
               {params->per_current, (num_t)0}, {params->per_change, (num_t)0}, {params->per_speed, (num_t)0},
               {params->per_volt, (num_t)0},    {params->per_dc, (num_t)0},   {params->per_volt_change, (num_t)0}};
    for (uint16_t k = 0U; k < (uint16_t)(sizeof row / sizeof row[0]); k++) {
        const ctl_diag_t d = ctl_diag_range(row[k].value, row[k].min, NUM_MAX, (uint16_t)(k + 1U));
        if (d.status != CTL_OK) {
            return d;
        }
    }
    static const ctl_plausibility_state_t NOTHING = {{(num_t)0, (num_t)0}, {(num_t)0, (num_t)0}, {(num_t)0, (num_t)0},
                                                     {(num_t)0, (num_t)0}, {(num_t)0, (num_t)0}, (num_t)0,
                                                     CTL_PLAUSIBILITY_SKIP, 0U};
    self->params = *params;
    self->state = NOTHING;
    return ctl_diag_ok();
}

bool ctl_plausibility_step(ctl_plausibility_t *self, const ctl_plausibility_in_t *in)
{
    const num_t given[] = {in->current_dq.d, in->current_dq.q, in->rotor.sine, in->rotor.cosine,
                           in->speed,        in->v_dc,         in->volt.alpha, in->volt.beta};
    for (uint16_t k = 0U; k < (uint16_t)(sizeof given / sizeof given[0]); k++) {
        if (!num_is_finite(given[k])) {
            ctl_plausibility_restart(&self->state);
            self->state.against++;
            return self->state.against < CTL_PLAUSIBILITY_AGAINST;
        }
    }
    const bool plausible = ctl_plausibility_step_unchecked(&self->params, &self->state, in);
    if (!num_is_finite(self->state.error.alpha) || !num_is_finite(self->state.error.beta) ||
        !num_is_finite(self->state.allowed) || !num_is_finite(self->state.before.alpha) ||
        !num_is_finite(self->state.before.beta)) { /* inputs at the end of their range, multiplied */
        ctl_plausibility_restart(&self->state);
    }
    return plausible;
}
