#include "control/position/harmonics.h"

uint32_t ctl_cycles_q20(float cycles_per_turn)
{
    if (!(cycles_per_turn > 0.0f)) {
        return 0U;
    }
    return (cycles_per_turn < 4095.0f) ? (uint32_t)((cycles_per_turn * 1048576.0f) + 0.5f) : UINT32_C(4293918720);
}

ctl_diag_t ctl_harmonics_check(const ctl_harmonics_t *p)
{
    if (p == NULL) {
        return ctl_diag(CTL_ERR_NULL, 0U, (num_t)0);
    }
    if (p->lines > CTL_HARMONICS_MAX) {
        return ctl_diag_count(CTL_ERR_RANGE, CTL_HARMONICS_LINES, p->lines);
    }
    for (uint16_t i = 0U; i < p->lines; i++) {
        if (!num_is_finite(p->line[i].amplitude)) {
            return ctl_diag(CTL_ERR_RANGE, CTL_HARMONICS_AMPLITUDE, p->line[i].amplitude);
        }
    }
    return ctl_diag_ok();
}
