#include <math.h>

#include "control/observer/angle_memory.h"
#include "sim_host/capi/block.h"

enum { CELLS, GAIN, FORGETTING, WRITE, READ, LIMIT };

typedef struct {
    ctl_angle_memory_t memory;
    double             last_rad, last_value; /* of the newest sample that was good */
    bool               primed;
} angle_memory_t;

static int cells(const double *p) { return (int)p[CELLS]; }

static int start(void *self, const double *p, num_t *memory, int count)
{
    static const int                PARAM_OF[] = {[CTL_AM_GAIN] = GAIN, [CTL_AM_FORGETTING] = FORGETTING, [CTL_AM_WRITE] = WRITE,
                                                  [CTL_AM_READ] = READ, [CTL_AM_LIMIT] = LIMIT,           [CTL_AM_CELLS] = CELLS};
    const ctl_angle_memory_params_t params = {capi_signal_in(p[GAIN]), capi_signal_in(p[FORGETTING]), (ctl_write_t)(int)p[WRITE],
                                              (ctl_read_t)(int)p[READ], capi_signal_in(p[LIMIT])};
    const ctl_diag_t d = ctl_angle_memory_init(&((angle_memory_t *)self)->memory, &params, memory, (uint16_t)count);
    return capi_refused(d, PARAM_OF, sizeof PARAM_OF / sizeof PARAM_OF[0], GAIN);
}

static void write_sample(void *self, const double *in, double *out)
{
    angle_memory_t *const     memory = self;
    ctl_angle_memory_t *const m = &memory->memory;
    const double              theta_rad = in[0];
    const double              value = in[1];
    (void)out;
    if (!isfinite(theta_rad)) { /* an angle_t cannot say "not a number": count it as the block would */
        num_count(&m->state.rejected);
        return;
    }
    /* neither can it say more than half a turn: the unwrapped angle does */
    const double travel = (memory->primed && isfinite(value)) ? theta_rad - memory->last_rad : 0.0;
    if (fabs(travel) > CAPI_PI) {
        num_count(&m->state.rejected);
        ctl_angle_memory_pause(m);
    } else if ((fabs(travel) >= 0.5 * CAPI_PI) && (m->params.write != CTL_WRITE_ONE)) {
        /* the block takes less than a quarter of a turn at once: go along the straight line in three */
        for (int k = 1; k <= 2; k++) {
            const double part = (double)k / 3.0;
            ctl_angle_memory_write(m, capi_angle_in(memory->last_rad + part * travel),
                                   capi_signal_in(memory->last_value + part * (value - memory->last_value)), m->params.gain);
        }
    } else {
        /* an ordinary step */
    }
    if (capi_usable(in, 2) && memory->primed && (fabs(travel) < 0.25 * CAPI_PI)) {
        ctl_angle_memory_write_unchecked(m, capi_angle_in(theta_rad), capi_signal_in(value), m->params.gain);
    } else {
        ctl_angle_memory_write(m, capi_angle_in(theta_rad), capi_signal_in(value), m->params.gain);
    }
    if (isfinite(value)) {
        memory->last_rad = theta_rad;
        memory->last_value = value;
        memory->primed = true;
    }
}

static void read_sample(void *self, const double *in, double *out)
{
    out[0] = capi_out(ctl_angle_memory_read(&((angle_memory_t *)self)->memory, capi_angle_in(in[0])));
}

static void rejected(void *self, const double *in, double *out)
{
    (void)in;
    out[0] = (double)((const angle_memory_t *)self)->memory.state.rejected;
}

static int grid(const void *self, double *out, int room)
{
    const ctl_grid_t *const g = &((const angle_memory_t *)self)->memory.state.grid;
    for (int i = 0; (i < (int)g->cells) && (i < room); i++) {
        out[i] = capi_out(g->cell[i]);
    }
    return g->cells;
}

const capi_block_t block_angle_memory = {
    .name = "angle_memory",
    .doc = "Learns a waveform over the angle: every grid point that the motion passes moves towards what was seen there. Its "
           "table: the grid points.",
    .param =
        {
            [CELLS] = {"cells", "1/turn", CAPI_WHOLE, 200, 4, 4096, "Grid points per turn."},
            [GAIN] = {"gain", "", CAPI_REAL, 0.05, 0.0, 1.0, "Learning gain g of m <- q m + g (v - m).", CAPI_ABOVE,
                      .rule = "such that the numeric can hold it"},
            [FORGETTING] = {"forgetting", "", CAPI_REAL, 1.0, 0.0, 1.0, "q; 1 forgets nothing."},
            [WRITE] =
                {"write", "", CAPI_CHOICE, 0, 0, 2,
                 "Of the points passed since the last sample the newest, all, or all with the average of the samples around.",
                 .choices = "one|all|hat"},
            [READ] = {"read", "", CAPI_CHOICE, 0, 0, 1, "Between two points on a line, or through four.",
                      .choices = "linear|cubic"},
            [LIMIT] = {"limit", "", CAPI_REAL, 100.0, 0.0, INFINITY, "Largest size of a stored value.", CAPI_ABOVE,
                       .rule = "such that the numeric can hold it"},
        },
    .action =
        {
            {"write", "One sample: a value seen at an angle, which may run on beyond a turn.", "theta_rad|value", NULL,
             write_sample},
            {"read", "What was learned for the angle.", "theta_rad", "value", read_sample},
            {"rejected", "Samples that were not finite, and jumps of the angle.", NULL, "count", rejected},
        },
    .size = sizeof(angle_memory_t),
    .cells = cells,
    .start = start,
    .table = grid,
};
