/* Frames and modulation for Python. */
#include "control/motor/frames.h"
#include "control/motor/svm.h"
#include "sim_host/capi/block.h"

#define V_DC_MIN NUM_C(1.0e-3f) /* the drive modulates with no less */

bool es_clarke(double a, double b, double c, double *alpha_beta)
{
    const double    in[] = {a, b, c};
    const ctl_abc_t x = {capi_signal_in(a), capi_signal_in(b), capi_signal_in(c)};
    const bool      usable = capi_usable(in, 3);
    ctl_ab_t        y;
    if (usable) {
        y = ctl_clarke_unchecked(x);
    } else {
        (void)ctl_clarke(&x, &y);
    }
    alpha_beta[0] = capi_out(y.alpha);
    alpha_beta[1] = capi_out(y.beta);
    return usable;
}

bool es_inverse_clarke(double alpha, double beta, double *abc)
{
    const double   in[] = {alpha, beta};
    const ctl_ab_t x = {capi_signal_in(alpha), capi_signal_in(beta)};
    const bool     usable = capi_usable(in, 2);
    ctl_abc_t      y;
    if (usable) {
        y = ctl_inverse_clarke_unchecked(x);
    } else {
        (void)ctl_inverse_clarke(&x, &y);
    }
    abc[0] = capi_out(y.a);
    abc[1] = capi_out(y.b);
    abc[2] = capi_out(y.c);
    return usable;
}

static ctl_rotor_t rotor_at(double angle_rad)
{
    ctl_rotor_t r;
    angle_sincos(capi_angle_in(angle_rad), &r.sine, &r.cosine);
    return r;
}

bool es_park(double alpha, double beta, double angle_rad, double *dq)
{
    const double      in[] = {alpha, beta};
    const ctl_ab_t    x = {capi_signal_in(alpha), capi_signal_in(beta)};
    const ctl_rotor_t r = rotor_at(angle_rad);
    const bool        usable = capi_usable(in, 2);
    ctl_dq_t          y;
    if (usable) {
        y = ctl_park_unchecked(x, r);
    } else {
        (void)ctl_park(&x, &r, &y);
    }
    dq[0] = capi_out(y.d);
    dq[1] = capi_out(y.q);
    return usable;
}

bool es_inverse_park(double d, double q, double angle_rad, double *alpha_beta)
{
    const double      in[] = {d, q};
    const ctl_dq_t    x = {capi_signal_in(d), capi_signal_in(q)};
    const ctl_rotor_t r = rotor_at(angle_rad);
    const bool        usable = capi_usable(in, 2);
    ctl_ab_t          y;
    if (usable) {
        y = ctl_inverse_park_unchecked(x, r);
    } else {
        (void)ctl_inverse_park(&x, &r, &y);
    }
    alpha_beta[0] = capi_out(y.alpha);
    alpha_beta[1] = capi_out(y.beta);
    return usable;
}

bool es_vector_limit(double d, double q, double limit, double *dq)
{
    const double   in[] = {d, q, limit};
    const ctl_dq_t x = {capi_signal_in(d), capi_signal_in(q)};
    ctl_dq_t       y;
    const bool     untouched = (capi_usable(in, 3) && (limit >= 0.0)) ? ctl_vector_limit_unchecked(x, capi_signal_in(limit), &y)
                                                                      : ctl_vector_limit(&x, capi_signal_in(limit), &y);
    dq[0] = capi_out(y.d);
    dq[1] = capi_out(y.q);
    return untouched;
}

/* Duties as the timer of a board holds them: it clips, so the step does not. */
static double clipped(num_t duty) { return capi_out(num_clamp(duty, (num_t)0, NUM_C(1.0f))); }

bool es_svm(double v_alpha, double v_beta, double v_dc, double *duty_abc)
{
    const double   in[] = {v_alpha, v_beta, v_dc};
    const ctl_ab_t x = {capi_signal_in(v_alpha), capi_signal_in(v_beta)};
    const num_t    dc = capi_signal_in(v_dc);
    const bool     usable = capi_usable(in, 3) && (dc >= V_DC_MIN);
    ctl_abc_t      y;
    if (usable) {
        y = ctl_svm_unchecked(x, dc);
    } else {
        (void)ctl_svm(&x, dc, &y);
    }
    duty_abc[0] = clipped(y.a);
    duty_abc[1] = clipped(y.b);
    duty_abc[2] = clipped(y.c);
    return usable;
}
