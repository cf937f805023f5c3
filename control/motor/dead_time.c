#include "control/motor/dead_time.h"

bool ctl_dead_time(const ctl_dq_t *i, const ctl_rotor_t *rotor, num_t volt, num_t per_current, ctl_dq_t *out)
{
    const bool     good = num_is_finite(i->d) && num_is_finite(i->q);
    const ctl_dq_t none = {(num_t)0, (num_t)0};
    *out = good ? ctl_dead_time_unchecked(*i, *rotor, volt, per_current) : none;
    return good;
}
