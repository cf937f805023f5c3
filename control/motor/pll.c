#include "control/motor/pll.h"

#define PI_RAD NUM_C(3.14159265f)

ctl_diag_t ctl_pll_init(ctl_pll_t *self, const ctl_pll_params_t *params)
{
    if ((self == NULL) || (params == NULL)) {
        return ctl_diag(CTL_ERR_NULL, 0U, (num_t)0);
    }
    ctl_diag_t d = ctl_diag_range(params->kp_ts, NUM_EPS, NUM_C(1.0f), CTL_PLL_KP);
    ctl_diag_also(&d, params->ki_ts, NUM_EPS, NUM_MAX, CTL_PLL_KI);
    ctl_diag_also(&d, params->rad_per_speed_ts, NUM_EPS, NUM_MAX, CTL_PLL_RAD_PER_SPEED);
    ctl_diag_also(&d, params->speed_max, NUM_EPS, NUM_MAX, CTL_PLL_SPEED_MAX);
    if ((d.status == CTL_OK) && !(num_mul(params->speed_max, params->rad_per_speed_ts) <= PI_RAD)) {
        d = ctl_diag(CTL_ERR_RELATION, CTL_PLL_SPEED_MAX, params->speed_max);
    }
    if (d.status != CTL_OK) {
        return d;
    }
    self->params = *params;
    ctl_pll_reset(self, 0U);
    return d;
}

void ctl_pll_reset(ctl_pll_t *self, angle_t theta)
{
    self->state.th = theta;
    self->state.w = (num_t)0;
    self->state.error = (num_t)0;
}
