/* The input for safe torque off: its hardware takes the gates away, and hal_inverter_fault says so in the same PWM period. Here is what two
 * channels tell about each other: one that no longer opens shows as the other one does. It stays known until both have opened together.
 * Main loop; the time is the number of samples. */
#include "firmware/app/internal.h"
#include "hal/hal_inverter.h"

void drive_attend_sto(drive_t *d)
{
    drive_sto_t *const s = &d->sto;
    const uint32_t     now = d->sample.seq;
    s->channels = hal_sto() & HAL_STO_BOTH;
    if ((s->channels == 0U) || (s->channels == HAL_STO_BOTH)) {
        s->since = now;
        s->stuck = (s->channels == 0U) ? s->stuck : 0U;
    } else if ((now - s->since) > (uint32_t)(d->params->sto_discrepancy_s * (float)DRIVE_PWM_HZ)) {
        s->stuck = HAL_STO_BOTH - s->channels;
    } else {
        /* one contact moves before the other */
    }
    if (d->fault == FAULT_safe_torque_off) {
        d->fault_detail = (uint16_t)(s->channels + (4U * s->stuck));
    }
    if ((s->stuck != 0U) && (d->fault == FAULT_none)) {
        d->fault_detail = s->stuck;
        drive_trip(d, FAULT_sto_discrepancy);
    }
}
