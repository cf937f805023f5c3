/**
 * @file  control/observer/disturbance.h
 * @brief One sample of the torque meter and of the observer behind it, as the current interrupt runs them.
 *
 * The same numbers, bit for bit, as ctl_meter_torque_unchecked and then ctl_observer_step_unchecked. One branch decides for both
 * whether the sample takes the fast path of each: that saves 180 cycles for a plain ARO, and 66 for the others; a branch in each
 * block would cost 16 of these again.
 */
#ifndef CONTROL_OBSERVER_DISTURBANCE_H
#define CONTROL_OBSERVER_DISTURBANCE_H

#include "control/observer/observer.h"
#include "control/observer/torque_meter.h"

/**
 * One sample, of finite numbers.
 * @param observes  false: only the torque is measured.
 * @param fed       part of @p ref_last that is fed forward against the disturbance: no torque that was asked for, so that the observer
 *                  learns what this leaves. 0 unless the observer's parameter `feeds` says that there may be one.
 * @param estimate  as ctl_observer_step returns it; stays as it is when nothing is observed.
 * @return measured torque, as in ctl_meter_step.
 */
static inline num_t ctl_disturbance_step_unchecked(ctl_meter_t *meter, ctl_observer_t *observer, bool observes, angle_t theta,
                                                   num_t speed, num_t ref_last, num_t fed, num_t *estimate)
{
    const num_t travel = ctl_meter_travel(meter, theta);
    const bool  fast = ctl_meter_is_fast(meter, travel);
    if (fast & observes & observer->state.ready) {
        const num_t torque = ctl_meter_torque_fast(meter, theta, travel, ref_last);
        *estimate = ctl_observer_step_fast(observer, theta, speed, torque);
        return torque;
    }
    const num_t asked = num_sub(ref_last, fed);
    const num_t torque =
        fast ? ctl_meter_torque_fast(meter, theta, travel, asked) : ctl_meter_torque_unchecked(meter, theta, asked);
    if (observes) {
        *estimate = ctl_observer_step_unchecked(observer, theta, speed, torque);
    }
    return torque;
}

#endif
