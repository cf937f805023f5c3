/**
 * @file  firmware/app/protection.h
 * @brief The limits of a sample, each judged in one place: together by the gate of the current interrupt, and one by one, with
 *        its fault, by drive_check_sample for a sample that does not pass the gate. Over-speed: drive_judge_motion.
 */
#ifndef FIRMWARE_APP_PROTECTION_H
#define FIRMWARE_APP_PROTECTION_H

#include "firmware/app/internal.h"

/* NaN compares false; the chip takes it for an infinity, which is beyond every limit. & instead of &&: one branch for all of them. */
#ifdef CTL_HAS_FPU
static inline bool drive_is_within(float x, float limit) { return fpu_max(x, -x) <= limit; }
#else
static inline bool drive_is_within(float x, float limit) { return (bool)((x <= limit) & (x >= -limit)); }
#endif

/** The phase currents of the sample, less their offsets, within over_current_a. */
static inline bool drive_currents_allowed(const drive_t *d, const drive_limits_t *limits)
{
    const float limit = limits->over_current_a;
    return (bool)(drive_is_within(d->ia_a, limit) & drive_is_within(d->ib_a, limit) & drive_is_within(d->ic_a, limit));
}
static inline bool drive_voltage_not_over(const drive_t *d, const drive_limits_t *limits)
{
    return d->sample.vdc_v <= limits->over_voltage_v;
}
static inline bool drive_voltage_not_under(const drive_t *d, const drive_limits_t *limits)
{
    return d->sample.vdc_v >= limits->under_voltage_v;
}

static inline void drive_take_off_offsets(drive_t *d)
{
    d->ia_a = d->sample.ia_a - d->offset_a_a;
    d->ib_a = d->sample.ib_a - d->offset_b_a;
    d->ic_a = d->sample.ic_a - d->offset_c_a;
}

/** A sample that passes needs no further judgement and may be calculated with. It is hence not the first one. */
static inline bool drive_sample_is_nominal(drive_t *d, const drive_limits_t *limits, hal_status_t status, uint32_t previous_seq)
{
    drive_take_off_offsets(d);
    return (bool)((status == HAL_OK) & (d->sample.seq == (previous_seq + 1U)) & drive_currents_allowed(d, limits) &
                  drive_voltage_not_over(d, limits) & drive_voltage_not_under(d, limits) &
                  (d->tracking.known == DRIVE_ANGLE_KNOWN));
}

#endif
