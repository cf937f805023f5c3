#include "control/motor/fourier.h"

num_t ctl_fourier(const ctl_fourier_t *p, angle_t x, num_t *slope)
{
    num_t s, c;
    angle_sincos(x, &s, &c);
    const num_t s2 = num_mul(num_mul(NUM_C(2.0f), s), c);
    const num_t c2 = num_sub(num_mul(c, c), num_mul(s, s));
    const num_t slope2 = num_sub(num_mul(p->sin2, c2), num_mul(p->cos2, s2));
    *slope = num_mac(num_sub(num_mul(p->sin1, c), num_mul(p->cos1, s)), NUM_C(2.0f), slope2);
    return num_mac(num_mac(num_mac(num_mul(p->cos1, c), p->sin1, s), p->cos2, c2), p->sin2, s2);
}

bool ctl_fourier_is_used(const ctl_fourier_t *p)
{
    static const ctl_fourier_t NONE = {(num_t)0, (num_t)0, (num_t)0, (num_t)0};
    return ctl_fourier_differs(p, &NONE);
}

bool ctl_fourier_differs(const ctl_fourier_t *one, const ctl_fourier_t *other)
{
    return (one->cos1 != other->cos1) || (one->sin1 != other->sin1) || (one->cos2 != other->cos2) || (one->sin2 != other->sin2);
}
