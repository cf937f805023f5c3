#include "control/motor/mt_speed.h"

#include <math.h>

#include "sim_host/capi/block.h"

enum { COUNTS, CLOCK, TS };

#define SPEED_MAX 1.0e5
#define STOP_SAMPLES 100U

static int start(void *self, const double *p, num_t *memory, int cells)
{
    static const int PARAM_OF[] = {
        [CTL_MT_SAMPLE] = CLOCK, [CTL_MT_SPEED_1_COUNT] = COUNTS, [CTL_MT_SPEED_MAX] = COUNTS, [CTL_MT_STOP] = COUNTS};
    const double cycles = p[CLOCK] * p[TS];
    (void)memory;
    (void)cells;
    if (!(cycles >= 1.0) || !(cycles < 4.0e9)) {
        return CLOCK;
    }
    const ctl_mt_params_t params = {(uint32_t)(cycles + 0.5), capi_signal_in(2.0 * CAPI_PI / p[COUNTS] / p[TS]),
                                    capi_in(SPEED_MAX), STOP_SAMPLES};
    return capi_refused(ctl_mt_init(self, &params), PARAM_OF, sizeof PARAM_OF / sizeof PARAM_OF[0], COUNTS);
}

/* Counters of 32 bits wrap. */
static uint32_t counter(double x) { return (fabs(x) < 9.0e18) ? (uint32_t)(int64_t)x : 0U; }

static void step(void *self, const double *in, double *out)
{
    out[0] = capi_out(ctl_mt_step(self, (int32_t)counter(in[0]), counter(in[1]), counter(in[2])));
}

const capi_block_t block_mt = {
    .name = "mt",
    .doc = "Speed from encoder counts over the time between edges.",
    .param =
        {
            [COUNTS] = {"counts_per_rev", "count/turn", CAPI_WHOLE, 4000, 1, 16777216, "Counts per mechanical turn.",
                        .rule = "such that one count per sample is a speed that the numeric can hold"},
            [CLOCK] = {"clock_hz", "Hz", CAPI_REAL, 200.0e6, 0.0, INFINITY, "Clock that times the edges.", CAPI_ABOVE,
                       .rule = "such that clock_hz ts_s is within 1 .. 4e9"},
            [TS] = {"ts_s", "s", CAPI_REAL, 1.0e-3, 0.0, INFINITY, "Sampling time.", CAPI_ABOVE},
        },
    .action =
        {
            {"step", "Counter at the last edge, its time and the time now in clock cycles (32 bits each).",
             "edge_count|edge_cyc|now_cyc", "speed_rad_s", step},
        },
    .size = sizeof(ctl_mt_t),
    .start = start,
};
