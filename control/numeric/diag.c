#include "control/numeric/diag.h"

ctl_diag_t ctl_diag_count(ctl_status_t status, uint16_t field, uint16_t given)
{
    return ctl_diag(status, field, num_from_int((int16_t)((given < 32767U) ? given : 32767U)));
}

ctl_diag_t ctl_diag_range(num_t x, num_t lo, num_t hi, uint16_t field)
{
    return ((x >= lo) && (x <= hi)) ? ctl_diag_ok() : ctl_diag(CTL_ERR_RANGE, field, x);
}

void ctl_diag_also(ctl_diag_t *d, num_t x, num_t lo, num_t hi, uint16_t field)
{
    if (d->status == CTL_OK) {
        *d = ctl_diag_range(x, lo, hi, field);
    }
}
