#include "control/position/friction.h"

ctl_diag_t ctl_friction_check(const ctl_friction_t *p)
{
    if (p == NULL) {
        return ctl_diag(CTL_ERR_NULL, 0U, (num_t)0);
    }
    ctl_diag_t d = ctl_diag_range(p->viscous, (num_t)0, NUM_MAX, CTL_FRICTION_VISCOUS);
    ctl_diag_also(&d, p->coulomb, (num_t)0, NUM_MAX, CTL_FRICTION_COULOMB);
    ctl_diag_also(&d, p->stat, (num_t)0, NUM_MAX, CTL_FRICTION_STATIC);
    if ((d.status == CTL_OK) && (p->stat < p->coulomb)) {
        d = ctl_diag(CTL_ERR_RELATION, CTL_FRICTION_STATIC, p->stat);
    }
    ctl_diag_also(&d, p->stribeck, NUM_EPS, NUM_MAX, CTL_FRICTION_STRIBECK);
    ctl_diag_also(&d, p->shape, NUM_C(0.1f), NUM_C(10.0f), CTL_FRICTION_SHAPE);
    return d;
}

num_t ctl_friction(const ctl_friction_t *p, num_t speed)
{
    return num_is_finite(speed) ? ctl_friction_unchecked(p, speed) : (num_t)0;
}
