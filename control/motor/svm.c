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
        *out = *v; /* the usual case: no root, no division */
        return true;
    }
    const num_t d = num_div(v->d, big);
    const num_t q = num_div(v->q, big);
    const num_t unit_length = num_sqrt(num_mac(num_mul(d, d), q, q)); /* 1 .. sqrt(2) */
    const num_t allowed = num_div(limit, unit_length);                 /* of the largest component */
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
    ctl_abc_t phase;
    if (!ctl_inverse_clarke(v, &phase) || !num_is_finite(v_dc) || !(v_dc > (num_t)0)) {
        duty->a = HALF;
        duty->b = HALF;
        duty->c = HALF;
        return false;
    }
    const num_t high = num_max(phase.a, num_max(phase.b, phase.c));
    const num_t low = num_min(phase.a, num_min(phase.b, phase.c));
    const num_t common = num_mul(num_add(high, low), HALF);
    const num_t scale = num_div(NUM_C(1.0f), v_dc);
    duty->a = num_clamp(num_mac(HALF, num_sub(phase.a, common), scale), (num_t)0, NUM_C(1.0f));
    duty->b = num_clamp(num_mac(HALF, num_sub(phase.b, common), scale), (num_t)0, NUM_C(1.0f));
    duty->c = num_clamp(num_mac(HALF, num_sub(phase.c, common), scale), (num_t)0, NUM_C(1.0f));
    return true;
}
