#include "control/repetitive/repetitive.h"
#include <math.h>

#include "sim_host/capi/block.h"

enum {
    GAIN,
    LEAD,
    Q_SIDE,
    Q_CENTRE,
    Q_SIDE2,
    ORDER,
    FAL_AT,
    ALPHA,
    DELTA,
    TRUNCATE,
    MEMORY,
    CAPACITY,
    LIMIT,
    FREEZE_ABOVE,
    FREEZE_SAMPLES
};

#define TAPS 8 /* a caller thinks in periods: room for the taps around the longest one comes on top */

static int cells(const double *p) { return (int)p[CAPACITY] + (((int)p[MEMORY] == (int)CTL_RC_ANGLE) ? 0 : TAPS); }

static int start(void *self, const double *p, num_t *memory, int count)
{
    static const int PARAM_OF[] = {
        [CTL_RC_GAIN] = GAIN,     [CTL_RC_LEAD] = LEAD,           [CTL_RC_Q] = Q_CENTRE,        [CTL_RC_ORDER] = ORDER,
        [CTL_RC_FAL_AT] = FAL_AT, [CTL_RC_FAL_ALPHA] = ALPHA,     [CTL_RC_FAL_DELTA] = DELTA,   [CTL_RC_MEMORY] = MEMORY,
        [CTL_RC_LIMIT] = LIMIT,   [CTL_RC_FREEZE] = FREEZE_ABOVE, [CTL_RC_CAPACITY] = CAPACITY,
    };
    const ctl_rc_params_t params = {
        .gain = capi_signal_in(p[GAIN]),
        .lead = (uint16_t)p[LEAD],
        .q = {capi_signal_in(p[Q_SIDE]), capi_signal_in(p[Q_CENTRE]), capi_signal_in(p[Q_SIDE2])},
        .order = (uint16_t)p[ORDER],
        .truncate = p[TRUNCATE] != 0.0,
        .fal_at = (ctl_rc_fal_at_t)(int)p[FAL_AT],
        .fal = {capi_signal_in(p[ALPHA]), capi_signal_in(p[DELTA])},
        .memory = (ctl_rc_memory_t)(int)p[MEMORY],
        .limit = capi_signal_in(p[LIMIT]),
        .freeze_above = capi_signal_in(p[FREEZE_ABOVE]),
        .freeze_samples = (uint16_t)p[FREEZE_SAMPLES],
    };
    return capi_refused(ctl_rc_init(self, &params, memory, (uint16_t)count), PARAM_OF, sizeof PARAM_OF / sizeof PARAM_OF[0],
                        GAIN);
}

static void step(void *self, const double *in, double *out)
{
    const double period = in[1];
    ctl_period_t n = {0U, (num_t)0};
    if (period >= 65535.0) {
        n.whole = 65535U;
    } else if (period > 0.0) {
        n.whole = (uint16_t)period;
        n.fraction = capi_in(period - (double)n.whole);
    } else {
        /* not a period: the block cuts it and counts */
    }
    /* the interrupt takes no period that the memory does not hold */
    ctl_rc_t *const rc = self;
    const bool      usable = capi_usable(in, 1) && (period > 0.0) && (n.whole <= rc->longest);
    const num_t     error = capi_signal_in(in[0]);
    const angle_t   theta_e = capi_angle_in(in[2]);
    out[0] =
        capi_out(usable ? ctl_rc_step_unchecked(rc, error, n.whole, n.fraction, theta_e) : ctl_rc_step(rc, error, n, theta_e));
}

static void reset(void *self, const double *in, double *out)
{
    (void)in;
    (void)out;
    ctl_rc_reset(self, false);
}

static void rejected(void *self, const double *in, double *out)
{
    (void)in;
    out[0] = (double)((const ctl_rc_t *)self)->state.rejected;
}

const capi_block_t block_rc =
    {
        .name = "rc",
        .doc = "Repetitive controller: CRC (order 0), FORC (order 1 to 3), fal-FORC (with fal_at).",
        .param =
            {
                [GAIN] = {"gain", "", CAPI_REAL, 0.6, 0.0, 100.0, "Learning gain k_rc."},
                [LEAD] = {"lead", "sample", CAPI_WHOLE, 5, 0, 15, "Phase lead m of z^m.",
                          .rule = "at least 2 where the memory is indexed by angle"},
                [Q_SIDE] = {"q_side", "", CAPI_REAL, 0.45, -1.0, 1.0,
                            "Taps beside the middle one of Q(z) = side2 (z^2 + z^-2) + side (z + z^-1) + centre."},
                [Q_CENTRE] = {"q_centre", "", CAPI_REAL, 0.10, -1.0, 1.0, "Middle tap of Q(z).",
                              .rule = "such that |Q| <= 1 at every frequency; with three taps: |q_centre| + 2 |q_side| <= 1"},
                [Q_SIDE2] = {"q_side2", "", CAPI_REAL, 0.0, -1.0, 1.0, "Taps of Q(z) two samples away; 0: three taps."},
                [ORDER] = {"order", "", CAPI_WHOLE, 2, 0, 3, "Lagrange order of the fractional delay; 0 takes whole samples."},
                [FAL_AT] = {"fal_at", "", CAPI_CHOICE, 0, 0, 2,
                            "fal at the input of the memory (A), or lambda at the output (B).", .choices = "none|input|output"},
                [ALPHA] = {"alpha", "", CAPI_REAL, 1.0, 0.0, 1.0, "Exponent of fal.", CAPI_ABOVE,
                           .rule = "such that the numeric can hold it"},
                [DELTA] = {"delta", "", CAPI_REAL, 1.0, 0.0, INFINITY, "Half width of the linear part of fal, unit of the error.",
                           CAPI_ABOVE, .rule = "such that the numeric can hold delta^(alpha-1)"},
                [TRUNCATE] = {"truncate", "", CAPI_FLAG, 1, 0, 1, "Order 0: 1 cuts the period to whole samples, 0 rounds."},
                [MEMORY] = {"memory", "", CAPI_CHOICE, 0, 0, 2,
                            "On a change of the period: keep the samples, clear them, or index them by electrical angle.",
                            .choices = "keep|clear|angle"},
                [CAPACITY] = {"capacity", "", CAPI_WHOLE, 512, 1, 32000, "Samples of memory, or cells per electrical turn.",
                              .rule = "at least lead + order + 5, and at most 4096 cells per turn"},
                [LIMIT] = {"limit", "", CAPI_REAL, 1000.0, 0.0, INFINITY, "Largest correction, unit of the error.", CAPI_ABOVE,
                           .rule = "such that the numeric can hold it"},
                [FREEZE_ABOVE] = {"freeze_above", "", CAPI_REAL, 0.0, 0.0, INFINITY,
                                  "Learning stops while the error is larger; 0: never."},
                [FREEZE_SAMPLES] = {"freeze_samples", "sample", CAPI_WHOLE, 80, 0, 60000,
                                    "Samples for which learning then stays stopped."},
            },
        .action =
            {
                {"step", "Advance one sample; gives the correction to add to the error.", "error|period_samples|theta_e_rad",
                 "correction", step},
                {"reset", "Forget what was learned.", NULL, NULL, reset},
                {"rejected", "Errors that were not finite.", NULL, "count", rejected},
            },
        .size = sizeof(ctl_rc_t),
        .cells = cells,
        .start = start,
};
