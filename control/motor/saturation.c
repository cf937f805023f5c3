#include "control/motor/saturation.h"

bool ctl_saturation(const ctl_saturation_params_t *p, const ctl_dq_t *i, ctl_dq_t *share)
{
    uint32_t    rejected = 0U;
    const num_t d = num_guard(i->d, (num_t)0, &rejected);
    const num_t q = num_guard(i->q, (num_t)0, &rejected);
    share->d = ctl_saturation_unchecked(p, d, q);
    share->q = ctl_saturation_unchecked(p, q, d);
    return rejected == 0U;
}
