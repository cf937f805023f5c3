/* Functions without a memory for Python: interpolation, fal, angles, and those of the position drive. */
#include <math.h>

#include "control/numeric/lagrange.h"
#include "control/numeric/num_math.h"
#include "control/position/friction.h"
#include "control/position/rdc.h"
#include "control/position/src.h"
#include "control/repetitive/fal.h"
#include "sim_host/capi/block.h"

/* Of a parameter with no upper end. */
static bool refuse_below(es_error_t *error, const char *name, double given, double min, bool above)
{
    (void)capi_refuse_range(error, ES_OUT_OF_RANGE, "block_param", name, given, min, INFINITY, "");
    if (error != NULL) {
        error->above = above;
    }
    return false;
}

static bool refuse_within(es_error_t *error, const char *name, double given, double min, double max)
{
    return capi_refuse_range(error, ES_OUT_OF_RANGE, "block_param", name, given, min, max, "");
}

/* Within its range, but not beside `other`. */
static bool refuse_beside(es_error_t *error, es_code_t code, const char *name, double given, const char *other)
{
    return capi_refuse_with(error, code, "block_param", name, given, other);
}

bool es_lagrange(int order, double frac, double *a_out, es_error_t *error)
{
    if (a_out == NULL) {
        return capi_refuse(error, ES_NO_OBJECT, "block_param", "out", 0.0);
    }
    if ((order < 0) || (order >= (int)CTL_LAGRANGE_TAPS)) {
        return refuse_within(error, "order", order, 0.0, (double)(CTL_LAGRANGE_TAPS - 1U));
    }
    const double longest = (order > 0) ? order : 1;
    if (!((frac >= 0.0) && (frac <= longest))) {
        return refuse_within(error, "frac", frac, 0.0, longest);
    }
    num_t a[CTL_LAGRANGE_TAPS];
    ctl_lagrange((uint16_t)order, capi_in(frac), a);
    for (int k = 0; k <= order; k++) {
        a_out[k] = capi_out(a[k]);
    }
    return true;
}

static bool make_fal(ctl_fal_t *fal, double alpha, double delta, es_error_t *error)
{
    const ctl_fal_params_t p = {capi_signal_in(alpha), capi_signal_in(delta)};
    const ctl_diag_t       d = ctl_fal_init(fal, &p);
    if (d.status == CTL_OK) {
        return true;
    }
    if (d.field == (uint16_t)CTL_FAL_ALPHA) {
        (void)refuse_within(error, "alpha", alpha, 0.0, 1.0);
        if (error != NULL) {
            error->above = true;
        }
        return false;
    }
    return refuse_below(error, "delta", delta, 0.0, true);
}

bool es_fal(double e, double alpha, double delta, double *y, es_error_t *error)
{
    ctl_fal_t fal;
    if ((y == NULL) || !make_fal(&fal, alpha, delta, error)) {
        return false;
    }
    *y = capi_out(ctl_fal(&fal, capi_signal_in(e)));
    return true;
}

bool es_fal_lambda(double e, double alpha, double delta, double *y, es_error_t *error)
{
    ctl_fal_t fal;
    if ((y == NULL) || !make_fal(&fal, alpha, delta, error)) {
        return false;
    }
    *y = capi_out(ctl_fal_lambda(&fal, capi_signal_in(e)));
    return true;
}

void es_sincos(double angle_rad, double *sine, double *cosine)
{
    num_t s, c;
    angle_sincos(capi_angle_in(angle_rad), &s, &c);
    *sine = capi_out(s);
    *cosine = capi_out(c);
}

double es_pow(double base, double exponent) { return capi_out(num_pow(capi_in(base), capi_in(exponent))); }

/* ---- position drive ---------------------------------------------------------------------------------------------------------- */

bool es_stribeck(double speed, double coulomb, double stat, double v_s, double shape, double *torque, es_error_t *error)
{
    const ctl_friction_t p = {(num_t)0, capi_signal_in(coulomb), capi_signal_in(stat), capi_signal_in(v_s),
                              capi_signal_in(shape)};
    const ctl_diag_t     d = ctl_friction_check(&p);
    if (d.status == CTL_OK) {
        *torque = capi_out(capi_usable(&speed, 1) ? ctl_friction_unchecked(&p, capi_signal_in(speed))
                                                  : ctl_friction(&p, capi_signal_in(speed)));
        return true;
    }
    switch (d.field) {
    case CTL_FRICTION_COULOMB:
        return refuse_below(error, "coulomb", coulomb, 0.0, false);
    case CTL_FRICTION_STATIC:
        return (d.status == CTL_ERR_RELATION) ? refuse_beside(error, ES_BELOW_OTHER, "static", stat, "coulomb")
                                              : refuse_below(error, "static", stat, 0.0, false);
    case CTL_FRICTION_SHAPE:
        return refuse_within(error, "shape", shape, 0.1, 10.0);
    default:
        return refuse_below(error, "v_s", v_s, 0.0, true);
    }
}

bool es_rdc_robust_term(const double *e, const double *p_row, double inertia, double rho, double sigma, double *torque,
                        es_error_t *error)
{
    if (!(inertia > 0.0)) {
        return refuse_below(error, "inertia", inertia, 0.0, true);
    }
    const ctl_rdc_params_t p = {
        .inertia = capi_signal_in(inertia),
        .friction = {(num_t)0, (num_t)0, (num_t)0, NUM_C(1.0f), NUM_C(1.0f)},
        .p_row = {capi_signal_in(p_row[0] / inertia), capi_signal_in(p_row[1] / inertia), capi_signal_in(p_row[2] / inertia)},
        .rho = capi_signal_in(rho),
        .sigma = capi_signal_in(sigma),
        .sample_s = NUM_EPS, /* the integral is given, it does not advance */
        .integral_max = NUM_C(100.0f),
    };
    ctl_rdc_t        rdc;
    const ctl_diag_t d = ctl_rdc_init(&rdc, &p);
    if (d.status == CTL_OK) {
        const ctl_setpoint_t rest = {0, (num_t)0, (num_t)0, true};
        rdc.state.x1 = capi_signal_in(e[0]);
        *torque = capi_out(
            capi_usable(e, 3) ? ctl_rdc_step_unchecked(&rdc.params, &rdc.state, &rest, capi_signal_in(e[1]), capi_signal_in(e[2]))
                              : ctl_rdc_step(&rdc, &rest, capi_signal_in(e[1]), capi_signal_in(e[2])));
        return true;
    }
    switch (d.field) {
    case CTL_RDC_SIGMA:
        return refuse_below(error, "sigma", sigma, 0.0, true);
    case CTL_RDC_RHO:
        return refuse_below(error, "rho", rho, 0.0, false);
    case CTL_RDC_P:
        return refuse_beside(error, ES_NUMERIC, "p_row", p_row[0], "inertia");
    default:
        return refuse_beside(error, ES_NUMERIC, "inertia", inertia, "");
    }
}

bool es_spatial_lowpass(double cutoff_per_rad, double speed, double ts, double *b, double *a, es_error_t *error)
{
    const double k = cutoff_per_rad * fabs(speed) * ts * 0.5;
    if (!(cutoff_per_rad > 0.0)) {
        return refuse_below(error, "cutoff_per_rad", cutoff_per_rad, 0.0, true);
    }
    if (!(ts > 0.0)) {
        return refuse_below(error, "ts", ts, 0.0, true);
    }
    if (!(k <= 1.0)) {
        const double fastest = 2.0 / (cutoff_per_rad * ts);
        return refuse_within(error, "speed", speed, -fastest, fastest);
    }
    const ctl_src_filter_t f = ctl_src_filter(capi_in(k));
    b[0] = capi_out(f.b0);
    b[1] = 2.0 * b[0];
    b[2] = b[0];
    a[0] = 1.0;
    a[1] = capi_out(f.a1);
    a[2] = capi_out(f.a2);
    return true;
}
