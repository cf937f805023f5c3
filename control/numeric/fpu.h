/**
 * @file  control/numeric/fpu.h
 * @brief The smaller and the larger of two floats as one instruction of the chip's floating-point unit, by names of ours.
 *        Nothing else may use its intrinsics.
 *
 * Where CTL_HAS_FPU is defined these exist, each one instruction of one cycle:
 *
 *     fpu_min(a, b), fpu_max(a, b)   __fmin, __fmax      MINF32, MAXF32
 *
 * Elsewhere num_min, num_max, num_clamp and num_abs compare and choose. The results are the same for numbers. The chip takes
 * a NaN for an infinity of its sign, so that a clamp gives one of its limits there, too, though not always the lower one.
 *
 * EVENSPIN_TMU_MARKED   as in tmu.h: functions that somebody else provides.
 */
#ifndef CONTROL_NUMERIC_FPU_H
#define CONTROL_NUMERIC_FPU_H

#ifndef EVENSPIN_FIXED

#if defined(__TMS320C28XX_FPU32__)
#define CTL_HAS_FPU
static inline float fpu_min(float a, float b) { return __fmin(a, b); }
static inline float fpu_max(float a, float b) { return __fmax(a, b); }
#elif defined(EVENSPIN_TMU_MARKED)
#define CTL_HAS_FPU
float fpu_min(float a, float b) __attribute__((const));
float fpu_max(float a, float b) __attribute__((const));
#endif

#endif

#endif
