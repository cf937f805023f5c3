#include "sim_host/plant/effect.h"

static void parts(const double *p, sim_parts_t *x) { x->delay_periods = p[0]; }

const sim_effect_t effect_current_loop_delay = {
    .name = "current_loop_delay",
    .acts_on = "inverter",
    .doc = "The voltage of a period acts this many PWM periods later than the drive counts on; with a broken number it changes "
           "inside "
           "a period. The angle that the drive adds for its own delay stays as it is.",
    .signature = "Current steps ring and come late as a whole; d voltage that grows with the square of the speed.",
    .confused_with = {"current_filter", "inductance_saturation"},
    .shown_by = {{"standstill_steps", "at 10 kHz"}, {"staircase", "at high speed"}},
    .told_apart = "A delay shifts the whole answer, a filter changes its slope.",
    .param_count = 1,
    .param =
        {
            {"extra_periods", "", "PWM periods beyond the nominal delay, whole or not.", 0.0, 0.0, SIM_DELAY_PERIODS,
             SIM_AMPLITUDE, 1.0},
        },
    .parts = parts,
};
