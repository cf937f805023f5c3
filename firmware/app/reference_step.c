/* Which d and q current make the torque that the speed or position loop asks for: MTPA and field weakening, at the rate of the speed
 * loop. control/motor/current_reference.h has the equations. */
#include "firmware/app/internal.h"

#define INV_SQRT3 NUM_C(0.57735026919f)

void drive_refer_currents(drive_t *d)
{
    const drive_reference_setup_t *const s = &d->setup->reference;
    ctl_reference_state_t                next = d->reference; /* the current interrupt may come in between, and reads it */
    if ((d->state != DRIVE_RUN) || drive_active_order(d)->torque) {
        ctl_reference_reset(&s->plan, &next);
    } else {
        const num_t              dc = num_mul(drive_per_base(d->sample.vdc_v, d->scale.inv_voltage), INV_SQRT3);
        const num_t              asked = num_sub(d->speed.iq_ref, d->observer.estimate);
        const ctl_reference_in_t in = {.torque = num_clamp(asked, num_neg(next.room), next.room),
                                       .speed = d->tracking.pll.state.w,
                                       .v_limit = num_min(d->setup->current.voltage_limit, dc),
                                       .volt = d->current.volt};
        ctl_reference_step(&s->plan, &next, &in);
    }
    d->reference = next;
}
