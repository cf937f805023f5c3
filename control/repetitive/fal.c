#include "control/repetitive/fal.h"

#include "control/numeric/num_math.h"

ctl_diag_t ctl_fal_init(ctl_fal_t *self, const ctl_fal_params_t *params)
{
    if ((self == NULL) || (params == NULL)) {
        return ctl_diag(CTL_ERR_NULL, 0U, (num_t)0);
    }
    ctl_diag_t d = ctl_diag_range(params->alpha, NUM_EPS, NUM_C(1.0f), CTL_FAL_ALPHA);
    if (d.status == CTL_OK) {
        d = ctl_diag_range(params->delta, NUM_EPS, NUM_MAX, CTL_FAL_DELTA);
    }
    if (d.status != CTL_OK) {
        return d;
    }
    const num_t slope = num_pow(params->delta, num_sub(params->alpha, NUM_C(1.0f)));
    if (slope >= NUM_MAX) { /* saturated: fal would jump at the knee */
        return ctl_diag(CTL_ERR_RELATION, CTL_FAL_DELTA, params->delta);
    }
    self->params = *params;
    self->slope = slope;
    return d;
}

num_t ctl_fal(const ctl_fal_t *self, num_t e)
{
    const num_t size = num_abs(e);
    if (size > self->params.delta) {
        const num_t y = num_pow(num_min(size, NUM_MAX), self->params.alpha);
        return (e < (num_t)0) ? num_neg(y) : y;
    }
    return (size <= self->params.delta) ? num_mul(self->slope, e) : (num_t)0; /* NaN: neither */
}

num_t ctl_fal_lambda(const ctl_fal_t *self, num_t e)
{
    const num_t size = num_abs(e);
    if (size > self->params.delta) {
        return num_min(num_pow(num_min(size, NUM_MAX), num_sub(self->params.alpha, NUM_C(1.0f))), self->slope);
    }
    return self->slope;
}
