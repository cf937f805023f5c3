/* Frames and modulation for Python. */
#include "control/motor/frames.h"
#include "control/motor/svm.h"
#include "sim_host/capi/block.h"

bool es_clarke(double a, double b, double c, double *alpha_beta)
{
    const ctl_abc_t x = {capi_signal_in(a), capi_signal_in(b), capi_signal_in(c)};
    ctl_ab_t        y;
    const bool      good = ctl_clarke(&x, &y);
    alpha_beta[0] = capi_out(y.alpha);
    alpha_beta[1] = capi_out(y.beta);
    return good;
}

bool es_inverse_clarke(double alpha, double beta, double *abc)
{
    const ctl_ab_t x = {capi_signal_in(alpha), capi_signal_in(beta)};
    ctl_abc_t      y;
    const bool     good = ctl_inverse_clarke(&x, &y);
    abc[0] = capi_out(y.a);
    abc[1] = capi_out(y.b);
    abc[2] = capi_out(y.c);
    return good;
}

static ctl_rotor_t rotor_at(double angle_rad)
{
    ctl_rotor_t r;
    angle_sincos(capi_angle_in(angle_rad), &r.sine, &r.cosine);
    return r;
}

bool es_park(double alpha, double beta, double angle_rad, double *dq)
{
    const ctl_ab_t    x = {capi_signal_in(alpha), capi_signal_in(beta)};
    const ctl_rotor_t r = rotor_at(angle_rad);
    ctl_dq_t          y;
    const bool        good = ctl_park(&x, &r, &y);
    dq[0] = capi_out(y.d);
    dq[1] = capi_out(y.q);
    return good;
}

bool es_inverse_park(double d, double q, double angle_rad, double *alpha_beta)
{
    const ctl_dq_t    x = {capi_signal_in(d), capi_signal_in(q)};
    const ctl_rotor_t r = rotor_at(angle_rad);
    ctl_ab_t          y;
    const bool        good = ctl_inverse_park(&x, &r, &y);
    alpha_beta[0] = capi_out(y.alpha);
    alpha_beta[1] = capi_out(y.beta);
    return good;
}

bool es_vector_limit(double d, double q, double limit, double *dq)
{
    const ctl_dq_t x = {capi_signal_in(d), capi_signal_in(q)};
    ctl_dq_t       y;
    const bool     untouched = ctl_vector_limit(&x, capi_signal_in(limit), &y);
    dq[0] = capi_out(y.d);
    dq[1] = capi_out(y.q);
    return untouched;
}

bool es_svm(double v_alpha, double v_beta, double v_dc, double *duty_abc)
{
    const ctl_ab_t x = {capi_signal_in(v_alpha), capi_signal_in(v_beta)};
    ctl_abc_t      y;
    const bool     good = ctl_svm(&x, capi_signal_in(v_dc), &y);
    duty_abc[0] = capi_out(y.a);
    duty_abc[1] = capi_out(y.b);
    duty_abc[2] = capi_out(y.c);
    return good;
}
