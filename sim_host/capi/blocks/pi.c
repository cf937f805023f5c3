#include "control/motor/pi.h"

#include <math.h>

#include "sim_host/capi/block.h"

enum { KP, KI_TS, OUT_MIN, OUT_MAX, ANTI_WINDUP };

static int start(void *self, const double *p, num_t *memory, int cells)
{
    static const int      PARAM_OF[] = {[CTL_PI_KP] = KP,
                                        [CTL_PI_KI_TS] = KI_TS,
                                        [CTL_PI_OUT_MIN] = OUT_MIN,
                                        [CTL_PI_OUT_MAX] = OUT_MAX,
                                        [CTL_PI_ANTI_WINDUP] = ANTI_WINDUP};
    const ctl_pi_params_t params = {capi_signal_in(p[KP]), capi_signal_in(p[KI_TS]), capi_signal_in(p[OUT_MIN]),
                                    capi_signal_in(p[OUT_MAX]), (ctl_pi_anti_windup_t)(int)p[ANTI_WINDUP]};
    (void)memory;
    (void)cells;
    return capi_refused(ctl_pi_init(self, &params), PARAM_OF, sizeof PARAM_OF / sizeof PARAM_OF[0], KP);
}

static void output(void *self, const double *in, double *out) { out[0] = capi_out(ctl_pi_output(self, capi_signal_in(in[0]))); }

static void commit(void *self, const double *in, double *out)
{
    (void)out;
    ctl_pi_commit(self, capi_signal_in(in[0]));
}

/* The current loop: limited as a vector with the other axis, so nothing is noted until it learns. */
static void propose(void *self, const double *in, double *out)
{
    ctl_pi_t *const pi = self;
    if (!capi_usable(in, 1)) {
        num_count(&pi->state.rejected);
    }
    out[0] = capi_out(ctl_pi_propose_unchecked(pi, capi_usable(in, 1) ? capi_signal_in(in[0]) : (num_t)0));
}

static void learn(void *self, const double *in, double *out)
{
    (void)out;
    if (capi_usable(in, 1)) {
        ctl_pi_learn_unchecked(self, capi_signal_in(in[0]));
    }
}

static void rejected(void *self, const double *in, double *out)
{
    (void)in;
    out[0] = (double)((const ctl_pi_t *)self)->state.rejected;
}

static void reset(void *self, const double *in, double *out)
{
    (void)out;
    ctl_pi_reset(self, capi_signal_in(in[0]));
}

const capi_block_t block_pi = {
    .name = "pi",
    .doc =
        "PI controller with conditional anti-windup: output and commit are the speed loop, propose and learn the current loop.",
    .param =
        {
            [KP] = {"kp", "", CAPI_REAL, 1.0, 0.0, INFINITY, "Proportional gain, output unit per error unit."},
            [KI_TS] = {"ki_ts", "", CAPI_REAL, 0.0, 0.0, INFINITY, "Integral gain per sample k_i T_s."},
            [OUT_MIN] = {"out_min", "", CAPI_REAL, -1.0, -INFINITY, INFINITY, "Lower limit of the output.",
                         .rule = "below out_max"},
            [OUT_MAX] = {"out_max", "", CAPI_REAL, 1.0, -INFINITY, INFINITY, "Upper limit of the output."},
            [ANTI_WINDUP] = {"anti_windup", "", CAPI_CHOICE, 0, 0, 1,
                             "While limited the integrator holds, or only if the error pushes further out.",
                             .choices = "hold|hold-outward"},
        },
    .action =
        {
            {"output", "Proposal for this sample, within the limits.", "error", "output", output},
            {"commit", "What the actuator did; once per output.", "realised", NULL, commit},
            {"propose", "Output without the limits, for one that is limited as a vector.", "error", "output", propose},
            {"learn", "The error of such a proposal, when the vector was not limited.", "error", NULL, learn},
            {"rejected", "Errors that were not finite.", NULL, "count", rejected},
            {"reset", "Start again with this integrator.", "integrator", NULL, reset},
        },
    .size = sizeof(ctl_pi_t),
    .start = start,
};
