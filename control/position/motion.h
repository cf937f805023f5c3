/**
 * @file  control/position/motion.h
 * @brief Positions over many turns: whole turns and a binary angle in one number, exact in both numerics.
 */
#ifndef CONTROL_POSITION_MOTION_H
#define CONTROL_POSITION_MOTION_H

#include "control/numeric/angle.h"
#include "control/numeric/diag.h"

/** 2^-32 turns, 31 bits of whole turns. */
typedef int64_t ctl_position_t;

#define CTL_ONE_TURN INT64_C(0x100000000)
/** Differences are cut to this when they become radians: +-19 turns. */
#define CTL_DIFFERENCE_MAX (INT64_C(19) * CTL_ONE_TURN)

/** a + b and a - b; beyond 2^31 turns they wrap. */
static inline ctl_position_t ctl_position_add(ctl_position_t a, ctl_position_t b)
{
    return (ctl_position_t)((uint64_t)a + (uint64_t)b);
}
static inline ctl_position_t ctl_position_sub(ctl_position_t a, ctl_position_t b)
{
    return (ctl_position_t)((uint64_t)a - (uint64_t)b);
}

/** The position nearest to @p last whose angle is @p angle: follows an encoder over the turns. */
static inline ctl_position_t ctl_position_follow(ctl_position_t last, angle_t angle)
{
    return ctl_position_add(last, (int32_t)(angle - (angle_t)(uint64_t)last));
}

/** Nearest float to a whole number within +-2^40. TI's compiler calls its library for that, which lies in flash; here both parts
 *  are exact, and their sum is rounded once. */
static inline float ctl_float_of_long(int64_t x)
{
    return ((float)(int32_t)(x >> 16) * 65536.0f) + (float)(uint16_t)((uint64_t)x & 0xFFFFU);
}

/** a - b in rad, within +-119 rad. */
static inline num_t ctl_position_difference(ctl_position_t a, ctl_position_t b)
{
    int64_t d = ctl_position_sub(a, b);
    d = (d > CTL_DIFFERENCE_MAX) ? CTL_DIFFERENCE_MAX : ((d < -CTL_DIFFERENCE_MAX) ? -CTL_DIFFERENCE_MAX : d);
#ifdef EVENSPIN_FIXED
    return (num_t)(((d * INT64_C(105414357)) + INT64_C(0x80000000)) >> 32); /* 2 pi 2^24 / 2^32; 19 turns give 0.93 2^63 */
#else
    return ctl_float_of_long(d) * 1.46291807926715968e-9f; /* 2 pi / 2^32 */
#endif
}

#endif
