#include "control/motor/svm.h"

#include "control/numeric/num_math.h"

#define HALF NUM_C(0.5f)

bool ctl_vector_limit(const ctl_dq_t *v, num_t limit, ctl_dq_t *out)
{
    if (!num_is_finite(v->d) || !num_is_finite(v->q) || !(limit >= (num_t)0)) {
        out->d = (num_t)0;
        out->q = (num_t)0;
        return false;
    }
    /* in units of the largest component, so that neither numeric overflows in the squares */
    const num_t big = num_max(num_abs(v->d), num_abs(v->q));
    if (big <= num_mul(limit, NUM_C(0.7071f))) {
        *out = *v; /* the nominal case: no root, no division */
        return true;
    }
    const num_t d = num_div(v->d, big);
    const num_t q = num_div(v->q, big);
    const num_t unit_length = num_sqrt(num_mac(num_mul(d, d), q, q)); /* 1 .. sqrt(2) */
    const num_t allowed = num_div(limit, unit_length);                /* of the largest component */
    if (big <= allowed) {
        *out = *v;
        return true;
    }
    out->d = num_mul(d, allowed);
    out->q = num_mul(q, allowed);
    return false;
}

bool ctl_svm(const ctl_ab_t *v, num_t v_dc, ctl_abc_t *duty)
{
    if (!num_is_finite(v->alpha) || !num_is_finite(v->beta) || !num_is_finite(v_dc) || !(v_dc >= NUM_EPS)) {
        duty->a = HALF;
        duty->b = HALF;
        duty->c = HALF;
        return false;
    }
    const ctl_abc_t open = ctl_svm_unchecked(*v, v_dc);
    duty->a = num_clamp(open.a, (num_t)0, NUM_C(1.0f));
    duty->b = num_clamp(open.b, (num_t)0, NUM_C(1.0f));
    duty->c = num_clamp(open.c, (num_t)0, NUM_C(1.0f));
    return true;
}
