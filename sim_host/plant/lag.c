#include "sim_host/plant/lag.h"

#include <math.h>

#define POWERS 4
#define TERMS 14 /* 1 / 15! of the last term for z <= 1 */

/* y1 = exp(-z) y0 + z sum_j c_j j! phi_(j+1)(-z) for u = sum_j c_j (t/h)^j, z = h / tau, with
 * phi_k(x) = sum_n x^n / (n + k)!, so that phi_k(x) = x phi_(k+1)(x) + 1 / k!. Down from the series where z is small, up
 * from the exponential where it is not: each loses no digits there. */
void sim_lag_prepare(sim_lag_t *lag, double tau_s, double h_s)
{
    static const double FACTORIAL[POWERS + 1] = {1.0, 1.0, 2.0, 6.0, 24.0};
    const double        z = h_s / tau_s;
    double              phi[POWERS + 1];
    if (z < 1.0) {
        double term = 1.0 / FACTORIAL[POWERS];
        phi[POWERS] = term;
        for (int n = 1; n < TERMS; n++) {
            term *= -z / (n + POWERS);
            phi[POWERS] += term;
        }
        for (int k = POWERS - 1; k >= 0; k--) {
            phi[k] = 1.0 / FACTORIAL[k] - z * phi[k + 1];
        }
    } else {
        phi[0] = exp(-z);
        for (int k = 0; k < POWERS; k++) {
            phi[k + 1] = (1.0 / FACTORIAL[k] - phi[k]) / z;
        }
    }
    lag->h_s = h_s;
    lag->weight[0] = phi[0];
    for (int j = 0; j < POWERS; j++) {
        lag->weight[j + 1] = z * FACTORIAL[j] * phi[j + 1];
    }
}

double sim_lag_step(const sim_lag_t *lag, const sim_lag_input_t *in, double y)
{
    const double a = in->slope0 * lag->h_s;
    const double b = in->slope1 * lag->h_s;
    const double rise = in->u1 - in->u0;
    const double c[POWERS] = {in->u0, a, 3.0 * rise - 2.0 * a - b, a + b - 2.0 * rise};
    double       next = lag->weight[0] * y;
    for (int j = 0; j < POWERS; j++) {
        next += lag->weight[j + 1] * c[j];
    }
    return next;
}
