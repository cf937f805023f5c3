/* What is judged in every PWM period beside the control, after the duties are set: whether voltages, currents and angle belong to
 * this motor. It calculates again what it needs, so that the control leaves nothing behind for it. */
#include "firmware/app/internal.h"
#include "firmware/app/protection.h"

#define LINK_NEW 0.25f /* share of a new sample in the mean of the dc link */
#define LINK_STEADY                                                                                                              \
    0.00390625f /* of the dc link: what changes by more in four periods is ahead of the filter of its measurement */

/* A share of the voltage is off while the measurement follows a dc link that changes. */
static inline bool link_is_steady(drive_t *d)
{
    const float moved_v = d->sample.vdc_v - d->link_mean_v;
    d->link_mean_v += LINK_NEW * moved_v;
    return drive_is_within(moved_v, LINK_STEADY * d->sample.vdc_v);
}

static inline bool has_current(const drive_align_t *a)
{
    return (a->phase > (uint16_t)DRIVE_ALIGN_RESTS) && (a->phase < (uint16_t)DRIVE_ALIGN_DONE);
}

void drive_watch_isr(drive_t *d)
{
    const drive_plausibility_setup_t *const setup = &d->setup->plausibility;
    const ctl_plausibility_params_t        *numbers = &setup->run;

    const bool judged = (bool)(((d->lost_samples | d->bad_samples) == 0U) & link_is_steady(d) & setup->used);
    angle_t    at = d->tracking.theta_e;
    num_t      lead = num_mul(d->setup->current.advance, d->tracking.pll.state.w);
    if (d->state != DRIVE_RUN) {
        if ((d->state != DRIVE_ALIGN) || !has_current(&d->align)) {
            ctl_plausibility_restart(&d->plausibility);
            return;
        }
        numbers = &setup->align;
        at = d->align.at;
        lead = (num_t)0;
    }
    if (!num_is_finite(num_add(d->current.volt.d, d->current.volt.q))) {
        drive_trip(d, FAULT_non_finite); /* a controller has lost its state, and only a start gives it another one */
    }
    if (d->speed_count > d->setup->speed.between) {
        d->speed_count = 0U; /* it changed by itself: the speed loop would stand still for up to 6.5 s */
    }
    if (!judged) {
        ctl_plausibility_restart(&d->plausibility);
        return;
    }
    ctl_plausibility_in_t in = {.current_dq = d->current.meas,
                                .speed = d->tracking.pll.state.w,
                                .v_dc = drive_per_base(d->sample.vdc_v, d->scale.inv_voltage)};
    ctl_rotor_t           ahead;
    angle_sincos(at, &in.rotor.sine, &in.rotor.cosine);
    angle_sincos_lead(at, lead, &ahead.sine, &ahead.cosine);
    in.volt = ctl_inverse_park_unchecked(d->current.volt, ahead);
    if (!ctl_plausibility_step_unchecked(numbers, &d->plausibility, &in)) {
        drive_trip(d, FAULT_current_implausible);
    }
}

float drive_contradiction(const drive_t *d)
{
    const ctl_plausibility_state_t *const s = &d->plausibility;
    const float                           allowed = num_to_float(s->allowed);
    return (allowed > 0.0f) ? (num_to_float(ctl_plausibility_size(s->error.alpha, s->error.beta)) / allowed) : 0.0f;
}
