/**
 * @file  firmware/app/motion_check.h
 * @brief Whether what the encoder shows can be the motion of this motor under this torque.
 *
 * Angle, current interrupt. Between two samples the step of the angle changes by what an acceleration makes in a PWM period,
 * and by two counts of rounding. 0.05 rad more would be 5e6 rad/s^2: no motor reaches a tenth of it. Such a sample is not
 * believed, the drive goes on with the angle that it expects, and when the next samples (encoder_jump_periods) do not come back
 * to it, counts were lost or added: encoder_lost. Seen whatever the speed. A slip that takes n periods is seen when it is
 * larger than n times the limit.
 *
 * Torque, speed interrupt, speed and position mode. The current reference is at its limit, and after speed_deviation_s the speed
 * has moved against that torque by over_speed_rad_s / 256, or turns against it and has not become slower: speed_deviation. The
 * torque has the wrong sign, or the load is stronger than the drive, and the drive cannot know which: a load that overhauls it
 * trips as well, unless its speed changes so fast that the next check sees that the zero is right. Not counted: a speed that
 * comes nearer, a balance at the limit, standing (stall), swinging, and a drive that turns with its torque at its voltage limit.
 * Not seen: a zero that is off by a quarter turn within the few degrees in which friction decides; no torque is left then.
 *
 * Electrical zero, speed interrupt, every mode. With the same current, the q voltage follows the speed, whatever the motor's
 * resistance, flux and load: dvq = p psi cos(error of the zero) dw. Where it falls while the speed rises, three times in a row,
 * the zero is off by more than a quarter turn: electrical_zero. Needs speeds that differ by so much that vq changes by 4 % of
 * the dc link, at a current that stays within 5 % of iq_limit_a or of what the dc link drives through motor_resistance_ohm and
 * motor_lq_h in a speed sample, whichever is less, a voltage below its limit, and 16 counts per electrical turn. Blind at
 * constant speed and at standstill.
 */
#ifndef FIRMWARE_APP_MOTION_CHECK_H
#define FIRMWARE_APP_MOTION_CHECK_H

#include "control/motor/frames.h"
#include "control/numeric/angle.h"
#include "firmware/app/faults.h"
#include "firmware/app/parameters.h"

/** How much is known of the angle: a first sample gives where it is, a second one its step. */
typedef enum {
    DRIVE_ANGLE_UNKNOWN = 0, /**< Not even for the tracking filter. */
    DRIVE_ANGLE_AGAIN,       /**< Samples are missing: begin anew, but for the tracking filter. */
    DRIVE_ANGLE_SEEN,
    DRIVE_ANGLE_KNOWN
} drive_angle_t;

/** From the parameters. */
typedef struct {
    angle_t  jump;          /**< Largest change of the step of the angle. */
    num_t    margin;        /**< Speed that counts as a change. */
    num_t    band;          /**< Currents that count as the same... */
    num_t    band_per_volt; /**< ...and per volt of the dc link, where iq_limit_a is more than it brings into the motor. */
    angle_t  way;           /**< Of a stretch of which the speed is known. */
    uint16_t samples;       /**< At the limit, against the torque; 0: never judged. */
    bool     zero;          /**< Judge the electrical zero. */
} drive_motion_setup_t;

typedef struct {
    num_t    first, slowest; /**< Speed along the torque in a stretch at the limit... */
    bool     forwards;       /**< ...and the torque asked for... */
    angle_t  from;           /**< ...from here on... */
    uint16_t samples;        /**< ...for so many samples. */
    bool     held;           /**< There is an operating point to compare with: */
    ctl_dq_t current;
    num_t    speed, volt_q;
    uint16_t against; /**< Comparisons in a row with the wrong sign. */
} drive_motion_t;

#endif
