/**
 * @file  control/numeric/tmu.h
 * @brief The trigonometric unit of the chip (TMU, type 0), by names of ours. Nothing else may use its intrinsics.
 *
 * Where CTL_HAS_TMU is defined these exist, each one instruction:
 *
 *     tmu_sin_turns(x), tmu_cos_turns(x)   sine and cosine of x turns, |x| <= 1        SINPUF32, COSPUF32: 4 cycles
 *     tmu_sqrt(x)                          square root of x >= 0                       SQRTF32: 5 cycles
 *
 * A quotient needs no name: with --fp_mode=relaxed the compiler makes DIVF32 of `/`.
 * Elsewhere angle_sincos_portable and num_sqrt_portable do the same work; angle_sincos and num_sqrt take what there is.
 * The fixed-point build does not use the unit.
 *
 * EVENSPIN_TMU_MARKED   the unit as functions that somebody else provides: `evenspin cycles` counts their calls as these
 *                       instructions, and a test holds both forms against each other.
 */
#ifndef CONTROL_NUMERIC_TMU_H
#define CONTROL_NUMERIC_TMU_H

#ifndef EVENSPIN_FIXED

#if defined(__TMS320C28XX_TMU__) || defined(__TMS320C28XX_TMU0__)
#define CTL_HAS_TMU
static inline float tmu_sin_turns(float x) { return __sinpuf32(x); }
static inline float tmu_cos_turns(float x) { return __cospuf32(x); }
static inline float tmu_sqrt(float x) { return __sqrt(x); }
#elif defined(EVENSPIN_TMU_MARKED)
#define CTL_HAS_TMU
float tmu_sin_turns(float x) __attribute__((const));
float tmu_cos_turns(float x) __attribute__((const));
float tmu_sqrt(float x) __attribute__((const));
#endif

#endif

#endif
