/**
 * @file  control/motor/thermal.h
 * @brief I2t: how hot a winding or a switch is, of what it bears for ever.
 *
 *     d heat / dt = (load - heat) / tau,   load = (current / continuous current)^2          (1)
 *
 * heat 1 is the temperature rise that the continuous current leads to; a load that stands for long leads to a heat of its own size.
 * From cold, a current I reaches a heat h after -tau ln(1 - h (continuous / I)^2); this turns the time for which a data sheet allows an
 * overload into a time constant. A whole number of 2^-56 keeps the heat: at a time constant of an hour the heat of a sample is
 * 3e-7 of the load, less than a float can add to 1. The same in both numerics, SI.
 *
 * Between CTL_THERMAL_DERATES and 1 the load that is allowed falls from what the drive can do to 1, and beyond that on the same line to
 * nothing: heat 1 is met in the limit and not passed, as long as the current keeps to what is allowed.
 *
 * Total    any load, NaN and infinity included, counts as within 0 and CTL_THERMAL_LOAD_MAX, NaN as the largest; any state comes back
 *          to it within some tau. Cost: 2 products of 32 bits, 1 of 64.
 */
#ifndef CONTROL_MOTOR_THERMAL_H
#define CONTROL_MOTOR_THERMAL_H

#include <stdbool.h>
#include <stdint.h>

#define CTL_THERMAL_LOAD_MAX 64.0f
#define CTL_THERMAL_DERATES 0.9f
#define CTL_THERMAL_TRIPS 1.1f /**< The current did not keep to what is allowed. */

typedef struct {
    float    per_square; /**< 1 / continuous current^2, 1/A^2. */
    uint32_t rate;       /**< Sample time / tau, 2^-32, up to 2^31. */
} ctl_thermal_params_t;

typedef int64_t ctl_heat_t; /**< 2^-56. */

/** @param tau_s  twice @p sample_s or more */
static inline uint32_t ctl_thermal_rate(float sample_s, float tau_s)
{
    const float share = (tau_s > (2.0f * sample_s)) ? (sample_s / tau_s) : 0.5f;
    return (uint32_t)(share * 4294967296.0f);
}

/** (1), one sample. @param square  of the current, A^2. */
static inline void ctl_thermal_step(const ctl_thermal_params_t *p, ctl_heat_t *heat, float square)
{
    const float   load = square * p->per_square;
    const float   top = (load < CTL_THERMAL_LOAD_MAX) ? load : CTL_THERMAL_LOAD_MAX; /* NaN: the largest */
    const float   cut = (top > 0.0f) ? top : 0.0f;
    const int32_t load_q24 = (int32_t)(cut * 16777216.0f);
    *heat += ((int64_t)load_q24 - (*heat >> 32)) * (int64_t)p->rate;
}

/** Heat as a number. */
static inline float ctl_thermal_heat(ctl_heat_t heat) { return (float)(int32_t)(heat >> 32) * (1.0f / 16777216.0f); }

/** Whether the heat is beyond @p limit, in 2^-24. */
static inline bool ctl_thermal_beyond(ctl_heat_t heat, int32_t limit_q24) { return (int32_t)(heat >> 32) > limit_q24; }

/** Load that is allowed at a heat, of a drive that can do @p most. */
static inline float ctl_thermal_allowed(float heat, float most)
{
    if (!(most > 1.0f) || (heat <= CTL_THERMAL_DERATES)) {
        return most;
    }
    const float line = 1.0f + (((1.0f - heat) / (1.0f - CTL_THERMAL_DERATES)) * (most - 1.0f));
    return (line > 0.0f) ? line : 0.0f;
}

#endif
