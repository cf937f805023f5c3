#include "control/motor/notch.h"

#include "control/numeric/angle.h"

/* tan(w/2) of the bilinear transform, put into sine and cosine of w: a2 = (1 - damping sin w) / (1 + damping sin w) */
void ctl_notch_design(ctl_notch_params_t *p, float cycles, float damping, float depth)
{
    num_t sine, cosine;
    angle_sincos(angle_from_rad(num_from_float(cycles * 6.28318530718f)), &sine, &cosine);
    const float width = damping * num_to_float(sine);
    const float a2 = (1.0f - width) / (1.0f + width);
    p->a2 = num_from_float(a2);
    p->a1 = num_from_float(-(1.0f + a2) * num_to_float(cosine));
    p->mean = num_from_float(0.5f * (1.0f + depth));
}

ctl_diag_t ctl_notch_check(const ctl_notch_params_t *p)
{
    if (p == NULL) {
        return ctl_diag(CTL_ERR_NULL, 0U, (num_t)0);
    }
    ctl_diag_t d = ctl_diag_range(p->a1, NUM_C(-2.0f), NUM_C(2.0f), CTL_NOTCH_A1);
    ctl_diag_also(&d, p->a2, NUM_C(-0.99999f), NUM_C(0.99999f), CTL_NOTCH_A2);
    ctl_diag_also(&d, p->mean, NUM_C(0.5f), NUM_C(1.0f), CTL_NOTCH_MEAN);
    if ((d.status == CTL_OK) && !(num_abs(p->a1) < num_add(NUM_C(1.0f), p->a2))) {
        d = ctl_diag(CTL_ERR_RELATION, CTL_NOTCH_A1, p->a1);
    }
    return d;
}

num_t ctl_notch_step(const ctl_notch_params_t *p, ctl_notch_state_t *s, num_t x)
{
    return ctl_notch_step_unchecked(p, s, num_is_finite(x) ? x : s->in[0]);
}
