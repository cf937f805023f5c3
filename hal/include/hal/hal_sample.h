/**
 * @file  hal/include/hal/hal_sample.h
 * @brief The measurements of one PWM period.
 */
#ifndef HAL_HAL_SAMPLE_H
#define HAL_HAL_SAMPLE_H

#include "hal/hal_types.h"

/** What the converter saw at one PWM centre; all fields belong to the same instant. */
typedef struct {
    float    ia_a, ib_a, ic_a; /**< Phase currents, A, positive into the motor. Two-sensor boards give ic = -ia - ib. */
    float    vdc_v;            /**< DC link, V. */
    uint32_t theta_m;          /**< Shaft angle, turns in 2^-32. */
    uint32_t at_cyc;           /**< When the angle was taken, on hal_clock_cyc: the begin of this interrupt. */
    uint32_t seq;              /**< +1 per PWM period that went by, whoever counted it; a gap is as many lost samples. */
} hal_sample_t;

/**
 * Newest sample. From the current interrupt only. At most 200 cycles; does not wait.
 * @return HAL_OK; HAL_STALE: the conversion is not new; HAL_SENSOR_FAULT: encoder or converter reports an error; HAL_TRIPPED:
 *         neither, but hal_inverter_fault has something to say. The struct is written in every case.
 */
hal_status_t hal_sample_read(hal_sample_t *out);

typedef enum { HAL_TEMPERATURE_MOTOR = 0, HAL_TEMPERATURE_BRIDGE, HAL_TEMPERATURES } hal_temperature_t;

/**
 * Temperature of a winding, or of the switches, degrees Celsius: the port knows its sensor, NTC or KTY, and filters over 0.1 s or so.
 * From the main loop, in every pass where the drive judges it; does not wait.
 * @return HAL_OK; HAL_UNSUPPORTED: this board has no such sensor, now and ever; HAL_SENSOR_FAULT: it is open or shorted.
 */
hal_status_t hal_temperature(hal_temperature_t which, float *celsius);

#endif
