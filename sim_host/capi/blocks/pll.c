#include "control/motor/pll.h"

#include <math.h>

#include "sim_host/capi/block.h"

enum { KP, KI, TS };

static int start(void *self, const double *p, num_t *memory, int cells)
{
    static const int PARAM_OF[] = {[CTL_PLL_KP] = KP, [CTL_PLL_KI] = KI, [CTL_PLL_RAD_PER_SPEED] = TS, [CTL_PLL_SPEED_MAX] = TS};
    const double     ts_s = p[TS];
    const ctl_pll_params_t params = {capi_signal_in(p[KP] * ts_s), capi_signal_in(p[KI] * ts_s), capi_signal_in(ts_s),
                                     capi_signal_in(3.0 / ts_s)};
    (void)memory;
    (void)cells;
    return capi_refused(ctl_pll_init(self, &params), PARAM_OF, sizeof PARAM_OF / sizeof PARAM_OF[0], TS);
}

static void step(void *self, const double *in, double *out) { out[0] = capi_out(ctl_pll_step(self, capi_angle_in(in[0]))); }

static void reset(void *self, const double *in, double *out)
{
    (void)out;
    ctl_pll_reset(self, capi_angle_in(in[0]));
}

const capi_block_t block_pll = {
    .name = "pll",
    .doc = "Tracking filter: angle in, speed out.",
    .param =
        {
            [KP] = {"kp", "1/s", CAPI_REAL, 754.0, 0.0, INFINITY, "Proportional gain.", CAPI_ABOVE,
                    .rule = "at most 1 / ts_s, and such that the numeric can hold kp ts_s"},
            [KI] = {"ki", "1/s^2", CAPI_REAL, 142122.0, 0.0, INFINITY, "Integral gain.", CAPI_ABOVE,
                    .rule = "such that the numeric can hold ki ts_s"},
            [TS] = {"ts_s", "s", CAPI_REAL, 1.0e-4, 0.0, INFINITY, "Sampling time.", CAPI_ABOVE,
                    .rule = "such that the numeric can hold it"},
        },
    .action =
        {
            {"step", "Advance one sample.", "angle_rad", "speed_rad_s", step},
            {"reset", "At rest at this angle.", "angle_rad", NULL, reset},
        },
    .size = sizeof(ctl_pll_t),
    .start = start,
};
