#include "control/motor/frames.h"

#define ONE_THIRD NUM_C(0.33333333333f)
#define INV_SQRT3 NUM_C(0.57735026919f)
#define HALF_SQRT3 NUM_C(0.86602540378f)

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
    /* differences first: a fixed-point sum 2 a - b - c would saturate before it is divided */
    out->alpha = num_mul(num_add(num_sub(x.a, x.b), num_sub(x.a, x.c)), ONE_THIRD);
    out->beta = num_mul(num_sub(x.b, x.c), INV_SQRT3);
    return a && b && c;
}

bool ctl_inverse_clarke(const ctl_ab_t *in, ctl_abc_t *out)
{
    ctl_ab_t   x;
    const bool alpha = take(in->alpha, &x.alpha);
    const bool beta = take(in->beta, &x.beta);
    const num_t half = num_mul(x.alpha, NUM_C(-0.5f));
    const num_t side = num_mul(x.beta, HALF_SQRT3);
    out->a = x.alpha;
    out->b = num_add(half, side);
    out->c = num_sub(half, side);
    return alpha && beta;
}

bool ctl_park(const ctl_ab_t *in, const ctl_rotor_t *rotor, ctl_dq_t *out)
{
    ctl_ab_t    x;
    ctl_rotor_t r;
    const bool  alpha = take(in->alpha, &x.alpha);
    const bool  beta = take(in->beta, &x.beta);
    const bool  angle = take_rotor(rotor, &r);
    out->d = num_add(num_mul(x.alpha, r.cosine), num_mul(x.beta, r.sine));
    out->q = num_sub(num_mul(x.beta, r.cosine), num_mul(x.alpha, r.sine));
    return alpha && beta && angle;
}

bool ctl_inverse_park(const ctl_dq_t *in, const ctl_rotor_t *rotor, ctl_ab_t *out)
{
    ctl_dq_t    x;
    ctl_rotor_t r;
    const bool  d = take(in->d, &x.d);
    const bool  q = take(in->q, &x.q);
    const bool  angle = take_rotor(rotor, &r);
    out->alpha = num_sub(num_mul(x.d, r.cosine), num_mul(x.q, r.sine));
    out->beta = num_add(num_mul(x.d, r.sine), num_mul(x.q, r.cosine));
    return d && q && angle;
}
