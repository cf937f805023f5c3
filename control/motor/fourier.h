/**
 * @file  control/motor/fourier.h
 * @brief The first two orders of a periodic function of an angle, and its slope.
 *
 *     f(x) = cos1 cos x + sin1 sin x + cos2 cos 2x + sin2 sin 2x                                         (1)
 *     f'(x) = -cos1 sin x + sin1 cos x - 2 cos2 sin 2x + 2 sin2 cos 2x                                   (2)
 *
 * Total    every angle is a valid one; |f| is at most the sum of the four sizes, |f'| at most twice that.
 * Cost     one sine and cosine, 12 products.
 */
#ifndef CONTROL_MOTOR_FOURIER_H
#define CONTROL_MOTOR_FOURIER_H

#include "control/numeric/angle.h"

typedef struct {
    num_t cos1, sin1, cos2, sin2; /**< Finite. */
} ctl_fourier_t;

/** Value of the function at @p x. @param slope  (2), per rad. */
num_t ctl_fourier(const ctl_fourier_t *p, angle_t x, num_t *slope);
/** Whether any of it is other than 0. */
bool ctl_fourier_is_used(const ctl_fourier_t *p);
bool ctl_fourier_differs(const ctl_fourier_t *one, const ctl_fourier_t *other);

#endif
