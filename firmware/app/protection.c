#include "firmware/app/internal.h"
#include "hal/hal_inverter.h"

void drive_trip(drive_t *d, drive_fault_t fault)
{
    hal_inverter_disarm();
    if (d->fault == FAULT_none) {
        d->fault = fault;
    }
    d->state = DRIVE_FAULT;
}

/* NaN compares false, hence the negation. */
static bool inside(float x, float limit) { return (x <= limit) && (x >= -limit); }

static bool is_number(float x) { return inside(x, 1.0e12f); }

static void check_hardware(drive_t *d)
{
    switch (hal_inverter_fault()) {
    case HAL_INVERTER_OVER_CURRENT:
        drive_trip(d, FAULT_hardware_over_current);
        break;
    case HAL_INVERTER_DRIVER_FAULT:
        drive_trip(d, FAULT_gate_driver);
        break;
    case HAL_INVERTER_OVER_TEMPERATURE:
        drive_trip(d, FAULT_over_temperature);
        break;
    case HAL_INVERTER_FINE:
    default:
        break;
    }
}

bool drive_check_sample(drive_t *d, hal_status_t status, uint32_t previous_seq)
{
    const drive_params_t *const p = d->params;
    const hal_sample_t *const   s = &d->sample;

    check_hardware(d);

    if ((status == HAL_STALE) || (d->seen_sample && (s->seq != (previous_seq + 1U)))) {
        num_count(&d->rejected);
        if (d->lost_samples < UINT16_MAX) {
            d->lost_samples++;
        }
        if (d->lost_samples >= p->lost_sample_limit) {
            drive_trip(d, FAULT_lost_sample);
        }
        if (status == HAL_STALE) {
            return false;
        }
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

    d->ia_a = s->ia_a - d->offset_a_a;
    d->ib_a = s->ib_a - d->offset_b_a;
    d->ic_a = s->ic_a - d->offset_c_a;
    if (!inside(d->ia_a, p->over_current_a) || !inside(d->ib_a, p->over_current_a) || !inside(d->ic_a, p->over_current_a)) {
        drive_trip(d, FAULT_over_current);
    }
    if (s->vdc_v > p->over_voltage_v) {
        drive_trip(d, FAULT_over_voltage);
    }
    if (drive_is_armed(d) && (s->vdc_v < p->under_voltage_v)) {
        drive_trip(d, FAULT_under_voltage);
    }
    return true;
}
