#include "control/motor/saturation.h"

bool ctl_saturation(const ctl_saturation_params_t *p, const ctl_dq_t *i, ctl_dq_t *share)
{
    const bool  good = num_is_finite(i->d) && num_is_finite(i->q);
    const num_t d = good ? i->d : (num_t)0;
    const num_t q = good ? i->q : (num_t)0;
    share->d = ctl_saturation_unchecked(p, d, q);
    share->q = ctl_saturation_unchecked(p, q, d);
    return good;
}
