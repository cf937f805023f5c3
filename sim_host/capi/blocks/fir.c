#include "control/observer/fir.h"

#include "sim_host/capi/block.h"

enum { ORDER, CUTOFF };

typedef struct {
    ctl_fir_t        fir;
    ctl_fir_params_t params; /* for the table */
} low_pass_t;

static int start(void *self, const double *p, num_t *memory, int cells)
{
    low_pass_t *const made = self;
    (void)memory;
    (void)cells;
    ctl_diag_t d = ctl_fir_design(&made->params, (uint16_t)p[ORDER], capi_signal_in(p[CUTOFF]));
    if (d.status == CTL_OK) {
        d = ctl_fir_init(&made->fir, &made->params);
    }
    return (d.status == CTL_OK) ? CAPI_STARTED : CUTOFF;
}

static void step(void *self, const double *in, double *out)
{
    ctl_fir_t *const fir = &((low_pass_t *)self)->fir;
    const num_t      x = capi_signal_in(in[0]);
    out[0] = capi_out(capi_usable(in, 1) ? ctl_fir_step_unchecked(fir, x) : ctl_fir_step(fir, x));
}

static void delay(void *self, const double *in, double *out)
{
    (void)in;
    out[0] = 0.5 * ((const low_pass_t *)self)->params.order;
}

static int taps(const void *self, double *out, int room)
{
    const ctl_fir_params_t *const fir = &((const low_pass_t *)self)->params;
    for (int i = 0; (i <= (int)fir->order) && (i < room); i++) {
        out[i] = capi_out(fir->tap[i]);
    }
    return (int)fir->order + 1;
}

const capi_block_t block_fir = {
    .name = "fir",
    .doc = "Symmetric low-pass (Hamming window): linear phase, the same delay at every frequency. Its table: the taps.",
    .param =
        {
            [ORDER] = {"order", "", CAPI_WHOLE, 9, 0, 15, "It has order + 1 taps."},
            [CUTOFF] = {"cutoff_over_rate", "", CAPI_REAL, 0.1, 0.0001, 0.5, "Corner over sampling rate.", CAPI_BELOW,
                        .rule = "such that the numeric can hold the taps"},
        },
    .action =
        {
            {"step", "Advance one sample.", "x", "y", step},
            {"delay", "Half the order; it need not be a whole number.", NULL, "delay_samples", delay},
        },
    .size = sizeof(low_pass_t),
    .start = start,
    .table = taps,
};
