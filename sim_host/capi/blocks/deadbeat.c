#include "control/motor/deadbeat.h"

#include <math.h>

#include "sim_host/capi/block.h"

enum { R, LD, LQ, PSI, POLE_PAIRS, TS, CORRECTION };

#define NO_LIMIT 1.0e6

static int start(void *self, const double *p, num_t *memory, int cells)
{
    static const int            PARAM_OF[] = {[CTL_DEADBEAT_R] = R,
                                              [CTL_DEADBEAT_LD] = LD,
                                              [CTL_DEADBEAT_LQ] = LQ,
                                              [CTL_DEADBEAT_PSI] = PSI,
                                              [CTL_DEADBEAT_CORRECTION] = CORRECTION};
    const ctl_deadbeat_params_t params = {
        .r = capi_signal_in(p[R]),
        .ld_ts = capi_signal_in(p[LD] / p[TS]),
        .lq_ts = capi_signal_in(p[LQ] / p[TS]),
        .ts_ld = capi_signal_in(p[TS] / p[LD]),
        .ts_lq = capi_signal_in(p[TS] / p[LQ]),
        .w_ld = capi_signal_in(p[POLE_PAIRS] * p[LD]),
        .w_lq = capi_signal_in(p[POLE_PAIRS] * p[LQ]),
        .w_psi = capi_signal_in(p[POLE_PAIRS] * p[PSI]),
        .correction = capi_signal_in(p[CORRECTION]),
        .c_max = capi_in(NO_LIMIT),
        .v_max = capi_in(NO_LIMIT),
    };
    (void)memory;
    (void)cells;
    return capi_refused(ctl_deadbeat_init(self, &params), PARAM_OF, sizeof PARAM_OF / sizeof PARAM_OF[0], R);
}

static void step(void *self, const double *in, double *out)
{
    ctl_deadbeat_t *const d = self;
    const ctl_dq_t        meas = {capi_signal_in(in[0]), capi_signal_in(in[1])};
    const ctl_dq_t        ref = {capi_signal_in(in[2]), capi_signal_in(in[3])};
    const ctl_dq_t        last = {capi_signal_in(in[5]), capi_signal_in(in[6])};
    const num_t           speed = capi_signal_in(in[4]);
    const ctl_dq_t        v = capi_usable(in, 7) ? ctl_deadbeat_step_unchecked(&d->params, &d->state, meas, ref, speed, last)
                                                 : ctl_deadbeat_step(d, &meas, &ref, speed, &last);
    out[0] = capi_out(v.d);
    out[1] = capi_out(v.q);
}

const capi_block_t block_deadbeat = {
    .name = "deadbeat",
    .doc = "Deadbeat control of the dq currents: the reference is reached two samples later.",
    .param =
        {
            [R] = {"r_ohm", "ohm", CAPI_REAL, 0.36, 0.0, 1000.0, "Phase resistance."},
            [LD] = {"ld_h", "H", CAPI_REAL, 0.2e-3, 0.0, 1.0, "Inductance of the d axis.", CAPI_ABOVE,
                    .rule = "such that the numeric can hold ld_h / ts_s and ts_s / ld_h"},
            [LQ] = {"lq_h", "H", CAPI_REAL, 0.2e-3, 0.0, 1.0, "Inductance of the q axis.", CAPI_ABOVE,
                    .rule = "such that the numeric can hold lq_h / ts_s and ts_s / lq_h"},
            [PSI] = {"psi_wb", "Wb", CAPI_REAL, 6.4e-3, 0.0, 10.0, "Flux linkage."},
            [POLE_PAIRS] = {"pole_pairs", "", CAPI_WHOLE, 4, 1, 50, "Pole pairs."},
            [TS] = {"ts_s", "s", CAPI_REAL, 1.0e-4, 0.0, INFINITY, "Sampling time.", CAPI_ABOVE},
            [CORRECTION] = {"correction", "", CAPI_REAL, 0.1, 0.0, 0.5, "Gain with which what the model leaves is learned."},
        },
    .action =
        {
            {"step",
             "dq currents now and wanted, mechanical speed, dq voltage that acts now; gives the voltage for the next period.",
             "id_a|iq_a|id_ref_a|iq_ref_a|speed_m_rad_s|vd_last_v|vq_last_v", "vd_v|vq_v", step},
        },
    .size = sizeof(ctl_deadbeat_t),
    .start = start,
};
