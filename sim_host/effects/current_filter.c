#include "sim_host/plant/effect.h"

static void parts(const double *p, sim_parts_t *x) { x->current_lag_s = p[0]; }

const sim_effect_t effect_current_filter = {
    .name = "current_filter",
    .acts_on = "current_sensor",
    .doc = "First-order low-pass of the measured phase currents, in continuous time; gain, offset, noise and rounding come after "
           "it.",
    .signature = "Logged current lags behind the true one, which overshoots; voltage peak after a current step.",
    .confused_with = {"current_loop_delay", "inductance_saturation"},
    .shown_by = {{"standstill_steps", "at 10 kHz"}},
    .told_apart = "A filter changes slope and voltage peak, a delay shifts the whole answer.",
    .param_count = 1,
    .param =
        {
            {"tau_s", "s", "Time constant.", 0.0, 0.0, 0.1, SIM_AMPLITUDE, 100e-6},
        },
    .parts = parts,
};
