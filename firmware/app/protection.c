#include "firmware/app/protection.h"

#include "firmware/app/internal.h"
#include "hal/hal_inverter.h"

#define FORWARD UINT32_C(0x7FFFFFFF) /* a sequence number beyond this step has gone back */
#define UNDER_VOLTAGE_SAMPLES 20U    /* in a row, 2 ms: a bench supply that folds back for a moment is no reason to stop */

void drive_trip(drive_t *d, drive_fault_t fault)
{
    hal_inverter_disarm();
    if (d->fault == FAULT_none) {
        d->fault = fault;
    }
    d->state = DRIVE_FAULT;
}

static bool is_number(float x) { return drive_is_within(x, 1.0e12f); }

void drive_check_hardware(drive_t *d)
{
    static const drive_fault_t FAULT_OF[HAL_INVERTER_FAULTS] = {FAULT_none,
                                                                FAULT_hardware_over_current,
                                                                FAULT_gate_driver,
                                                                FAULT_over_temperature,
                                                                FAULT_gate_driver_supply,
                                                                FAULT_gate_driver_link,
                                                                FAULT_trip_path,
                                                                FAULT_current_sum,
                                                                FAULT_late_interrupt,
                                                                FAULT_processor_halted,
                                                                FAULT_processor_clock,
                                                                FAULT_processor_memory,
                                                                FAULT_safe_torque_off,
                                                                FAULT_ram_test,
                                                                FAULT_program_test,
                                                                FAULT_processor_test};
    const hal_inverter_fault_t found = hal_inverter_fault();
    const drive_fault_t        fault = (found < HAL_INVERTER_FAULTS) ? FAULT_OF[found] : FAULT_gate_driver;
    if (fault == FAULT_none) {
        return;
    }
    if (d->fault == FAULT_gate_driver) {
        d->fault = fault; /* its fault line came first; meanwhile the driver has been asked why */
    }
    drive_trip(d, fault);
}

/* Too much voltage destroys and trips at once, which the filter of a divider makes safe from spikes. Too little only ends the
 * control of the current: it has to last. */
static void check_bus(drive_t *d)
{
    const hal_sample_t *const s = &d->sample;
    if (!drive_voltage_not_over(d, &d->setup->limits)) {
        drive_trip(d, FAULT_over_voltage);
    }
    if (drive_is_armed(d) && !drive_voltage_not_under(d, &d->setup->limits)) {
        d->low_bus_samples = (s->seq == (d->low_bus_seq + 1U)) ? (uint16_t)(d->low_bus_samples + 1U) : 1U;
        d->low_bus_seq = s->seq;
        if (d->low_bus_samples >= UNDER_VOLTAGE_SAMPLES) {
            drive_trip(d, FAULT_under_voltage);
        }
    }
}

/* Samples that are missing: one at a stale read or a number that does not rise, and as many as PWM periods went by unseen. */
static void note_lost(drive_t *d, uint32_t missing)
{
    const uint32_t lost = (uint32_t)d->lost_samples + ((missing < UINT16_MAX) ? missing : UINT16_MAX);
    num_count(&d->rejected);
    d->lost_samples = (uint16_t)((lost < UINT16_MAX) ? lost : UINT16_MAX);
    if (d->lost_samples >= d->params->lost_sample_limit) {
        drive_trip(d, FAULT_lost_sample);
    }
}

bool drive_check_sample(drive_t *d, hal_status_t status, uint32_t previous_seq)
{
    const drive_params_t *const p = d->params;
    const hal_sample_t *const   s = &d->sample;

    drive_check_hardware(d);

    if (status == HAL_STALE) {
        note_lost(d, 1U);
        return false;
    }
    if (d->seen_sample && (s->seq != (previous_seq + 1U))) {
        const uint32_t step = s->seq - previous_seq;
        /* at rest a save may keep the interrupts away for long, and nothing depends on them: a gap is one */
        const bool one = (step == 0U) || (step > FORWARD) || !drive_is_armed(d);
        note_lost(d, one ? 1U : (step - 1U));
    } else {
        d->lost_samples = 0U;
    }
    d->seen_sample = true;

    if (status == HAL_SENSOR_FAULT) {
        num_count(&d->rejected);
        drive_trip(d, FAULT_encoder_error);
        return false;
    }
    if (!is_number(s->ia_a) || !is_number(s->ib_a) || !is_number(s->ic_a) || !is_number(s->vdc_v)) {
        num_count(&d->rejected);
        if (d->bad_samples < UINT16_MAX) {
            d->bad_samples++;
        }
        if (d->bad_samples >= p->non_finite_limit) {
            drive_trip(d, FAULT_non_finite);
        }
        return false;
    }
    d->bad_samples = 0U;

    drive_take_off_offsets(d);
    if (!drive_currents_allowed(d, &d->setup->limits)) {
        drive_trip(d, FAULT_over_current);
    }
    check_bus(d);
    return true;
}
