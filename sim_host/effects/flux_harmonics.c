#include <math.h>

#include "sim_host/plant/effect.h"

static void flux(const double *p, const sim_model_t *m, double theta_e_rad, double time_s, sim_flux_t *h)
{
    (void)time_s;
    const double ripple_wb = p[1] * p[0] * m->psi_wb;
    h->q_wb += ripple_wb * cos(6.0 * theta_e_rad);
    h->d_wb -= (1.0 - 2.0 * p[2]) * ripple_wb * sin(6.0 * theta_e_rad); /* cancels where both harmonics take a half */
}

const sim_effect_t effect_flux_harmonics = {
    .name = "flux_harmonics",
    .acts_on = "flux",
    .doc = "Fifth and seventh flux harmonics: sixth electrical order in back-EMF and in torque per ampere, relative to the flux "
           "linkage.",
    .signature = "Sixth electrical order in the voltage that grows with speed, and in the torque that grows with the q current.",
    .confused_with = {"cogging", "dead_time"},
    .shown_by = {{"staircase", "at high speed"}, {"staircase_load", ""}},
    .told_apart = "Its voltage grows with speed and its torque with current.",
    .param_count = 3,
    .param =
        {
            {"torque_ripple_rel", "", "Amplitude relative to the flux linkage.", 0.0, -0.5, 0.5, SIM_AMPLITUDE, 0.03},
            {"sign", "", "+1 or -1: phase of the ripple.", 1.0, -1.0, 1.0, SIM_SIGN, 1.0},
            {"fifth_share", "", "Share of the fifth harmonic; the seventh has the rest. 0.5: no ripple in the d axis.", 0.5, -2.0,
             3.0, SIM_DETAIL, 0.5},
        },
    .flux = flux,
};
