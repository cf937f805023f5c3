#include "control/motor/frames.h"

static bool take(num_t in, num_t *out)
{
    const bool good = num_is_finite(in);
    *out = good ? in : (num_t)0;
    return good;
}

static bool take_rotor(const ctl_rotor_t *in, ctl_rotor_t *out)
{
    const bool sine = take(in->sine, &out->sine);
    const bool cosine = take(in->cosine, &out->cosine);
    out->sine = num_clamp(out->sine, NUM_C(-1.0f), NUM_C(1.0f));
    out->cosine = num_clamp(out->cosine, NUM_C(-1.0f), NUM_C(1.0f));
    return sine && cosine;
}

bool ctl_clarke(const ctl_abc_t *in, ctl_ab_t *out)
{
    ctl_abc_t  x;
    const bool a = take(in->a, &x.a);
    const bool b = take(in->b, &x.b);
    const bool c = take(in->c, &x.c);
    *out = ctl_clarke_unchecked(x);
    return a && b && c;
}

bool ctl_inverse_clarke(const ctl_ab_t *in, ctl_abc_t *out)
{
    ctl_ab_t   x;
    const bool alpha = take(in->alpha, &x.alpha);
    const bool beta = take(in->beta, &x.beta);
    *out = ctl_inverse_clarke_unchecked(x);
    return alpha && beta;
}

bool ctl_park(const ctl_ab_t *in, const ctl_rotor_t *rotor, ctl_dq_t *out)
{
    ctl_ab_t    x;
    ctl_rotor_t r;
    const bool  alpha = take(in->alpha, &x.alpha);
    const bool  beta = take(in->beta, &x.beta);
    const bool  angle = take_rotor(rotor, &r);
    *out = ctl_park_unchecked(x, r);
    return alpha && beta && angle;
}

bool ctl_inverse_park(const ctl_dq_t *in, const ctl_rotor_t *rotor, ctl_ab_t *out)
{
    ctl_dq_t    x;
    ctl_rotor_t r;
    const bool  d = take(in->d, &x.d);
    const bool  q = take(in->q, &x.q);
    const bool  angle = take_rotor(rotor, &r);
    *out = ctl_inverse_park_unchecked(x, r);
    return d && q && angle;
}
