/**
 * @file  control/numeric/angle.h
 * @brief Angles as fractions of a turn: 2^32 steps, wrap-around for free, exact in both numerics.
 *
 * Sums, differences and multiples (pole pairs!) of an angle_t wrap by themselves; a difference read as int32_t is the
 * shortest arc. Conversions to radians cost one product.
 */
#ifndef CONTROL_NUMERIC_ANGLE_H
#define CONTROL_NUMERIC_ANGLE_H

#include "control/numeric/num.h"
#include "control/numeric/tmu.h"

typedef uint32_t angle_t;

#define ANGLE_QUARTER UINT32_C(0x40000000)
#define ANGLE_RAD_MAX NUM_C(100.0f) /**< Largest |angle| in rad that angle_from_rad takes. */

/** From radians, |rad| <= ANGLE_RAD_MAX; anything else (NaN included) gives 0. Step 1.5e-9 rad, float adds 2^-23 |rad|. */
angle_t angle_from_rad(num_t rad);

/** angle_from_rad without checks, for |rad| <= ANGLE_RAD_MAX. */
static inline angle_t angle_from_rad_unchecked(num_t rad)
{
#ifdef EVENSPIN_FIXED
    /* 2^32 / (2 pi 2^24) = 40.7436654; the product of two 32-bit numbers keeps its low 32 bits by design */
    return (angle_t)(uint64_t)(((int64_t)rad * INT64_C(683565276)) >> 24);
#else
    /* within half a turn: a small angle keeps all its digits, backwards as well as forwards */
    const num_t turns = rad * 0.15915494309f;
    const num_t steps = (turns - (num_t)(int32_t)(turns + ((turns < 0.0f) ? -0.5f : 0.5f))) * 4294967296.0f;
    return (angle_t)(int32_t)((steps < 2147483520.0f) ? steps : 2147483520.0f); /* half a turn itself does not fit */
#endif
}

/** From radians within +-pi: a step or an advance. Cut to that; NaN gives minus half a turn. One product and one conversion. */
static inline angle_t angle_step_from_rad_unchecked(num_t rad)
{
#ifdef EVENSPIN_FIXED
    return (angle_t)(int32_t)(((int64_t)num_clamp(rad, NUM_C(-3.14159250f), NUM_C(3.14159250f)) * INT64_C(683565276)) >> 24);
#else
    return (angle_t)(int32_t)num_clamp(rad * 6.83565276e8f, -2147483648.0f, 2147483520.0f); /* 2^31 / pi */
#endif
}

/** angle_step_from_rad_unchecked, but NaN gives 0. */
static inline angle_t angle_step_from_rad(num_t rad)
{
#ifdef EVENSPIN_FIXED
    return angle_step_from_rad_unchecked(rad);
#else
    return (rad == rad) ? angle_step_from_rad_unchecked(rad) : 0U;
#endif
}

/** Radians within [-pi, pi]; the upper end by rounding in float. Absolute error below 3e-7 (float), 7e-8 (fixed). */
static inline num_t angle_to_rad_signed(angle_t angle)
{
#ifdef EVENSPIN_FIXED
    return (num_t)(((int64_t)(int32_t)angle * INT64_C(105414357)) >> 32); /* 2 pi 2^24 */
#else
    return (num_t)(int32_t)angle * 1.46291807926715968e-9f; /* pi / 2^31 */
#endif
}

/** Radians within [0, 2 pi]; the upper end by rounding in float. Absolute error below 6e-7 (float), 7e-8 (fixed). */
static inline num_t angle_to_rad(angle_t angle)
{
#ifdef EVENSPIN_FIXED
    return (num_t)(((uint64_t)angle * UINT64_C(105414357)) >> 32);
#else
    return (num_t)angle * 1.46291807926715968e-9f;
#endif
}

/** From turns within +-1/2: cut to that; NaN gives minus half a turn. */
static inline angle_t angle_step_from_turns(num_t turns)
{
#ifdef EVENSPIN_FIXED
    return (angle_t)num_clamp(turns, NUM_C(-0.5f), NUM_C(0.4999999f)) << 8;
#else
    return (angle_t)(int32_t)(num_clamp(turns, -0.5f, 0.49999997f) * 4294967296.0f);
#endif
}

/** Turns, [0, 1]. Absolute error 2^-25 (float), below a step (fixed). */
static inline num_t angle_to_turns(angle_t angle)
{
#ifdef EVENSPIN_FIXED
    return (num_t)(angle >> 8);
#else
    return (num_t)angle * 2.3283064365386963e-10f; /* 2^-32 */
#endif
}

/** Size of a difference of two angles, the shortest arc: at most half a turn. */
static inline uint32_t angle_size(angle_t difference)
{
    return (difference < (2U * ANGLE_QUARTER)) ? difference : (0U - difference);
}

/**
 * Sine and cosine at once, without the chip's help. Absolute error below 1.2e-7 (float), 2.5e-7 (fixed).
 * Cost: one conversion and two polynomials, about 20 operations; no libm.
 */
void angle_sincos_portable(angle_t angle, num_t *sine, num_t *cosine);

/** Sine and cosine at once; with a TMU two of its instructions, absolute error below 3e-7: a float has 24 bits of the angle. */
static inline void angle_sincos(angle_t angle, num_t *sine, num_t *cosine)
{
#ifdef CTL_HAS_TMU
    const num_t turns = (num_t)(int32_t)angle * 2.3283064365386963e-10f; /* 2^-32 */
    *sine = tmu_sin_turns(turns);
    *cosine = tmu_cos_turns(turns);
#else
    angle_sincos_portable(angle, sine, cosine);
#endif
}

/** Sine and cosine of @p angle and @p lead_turns more, |lead_turns| below 1/2. With a TMU, which takes the fraction of a turn, the
 *  lead costs a sum; the bound is that of angle_sincos. NaN gives sine and cosine of some angle. */
static inline void angle_sincos_lead(angle_t angle, num_t lead_turns, num_t *sine, num_t *cosine)
{
#ifdef CTL_HAS_TMU
    const num_t turns = ((num_t)(int32_t)angle * 2.3283064365386963e-10f) + lead_turns;
    *sine = tmu_sin_turns(turns);
    *cosine = tmu_cos_turns(turns);
#else
    angle_sincos_portable(angle + angle_step_from_turns(lead_turns), sine, cosine);
#endif
}

#endif
