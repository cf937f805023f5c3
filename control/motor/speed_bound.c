#include "control/motor/speed_bound.h"

num_t ctl_speed_bound_step(const ctl_speed_bound_params_t *p, ctl_speed_bound_t *s, num_t asked, num_t err_low, num_t err_high,
                           num_t room)
{
    const num_t least = num_neg(room);
    const num_t wanted = num_clamp(num_guard(asked, (num_t)0, &s->rejected), least, room);
    const num_t to_low = num_mul(p->kp, num_guard(err_low, (num_t)0, &s->rejected));
    const num_t to_high = num_mul(p->kp, num_guard(err_high, (num_t)0, &s->rejected));
    const num_t x = num_clamp(s->x, least, room);
    const num_t low = num_add(x, to_low);
    const num_t high = num_add(x, to_high);
    num_t       out = wanted;

    if ((wanted > high) || (wanted < low)) {
        const bool  too_fast = wanted > high;
        const num_t err = too_fast ? err_high : err_low;
        const num_t bound = too_fast ? high : low;
        out = num_clamp(bound, least, room);
        const bool outward = ((bound > out) && (err > (num_t)0)) || ((bound < out) && (err < (num_t)0));
        s->x = outward ? x : num_clamp(num_mac(x, p->ki_ts, num_guard(err, (num_t)0, &s->rejected)), least, room);
    } else {
        const num_t less = num_sub(x, num_mul(p->relax, x));
        s->x = (x > (num_t)0) ? num_min(num_max(less, num_sub(wanted, to_high)), x)
                              : num_max(num_min(less, num_sub(wanted, to_low)), x);
    }
    return out;
}
