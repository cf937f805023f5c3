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
 * Torque, speed interrupt, speed and position mode, while the current reference is at its limit (0.9 of iq_limit_a, or of what
 * the d axis leaves of it). Margin: over_speed_rad_s / 256.
 * - After speed_deviation_s the speed has moved against the torque by the margin and 1/32 of itself: speed_deviation. The torque has
 *   the wrong sign, or the load is stronger than the drive, and the drive cannot know which: a load that overhauls it trips as well,
 *   unless its speed changes so fast that the check of the zero sees that it is right, or so slowly that it stays within this.
 * - For twice that the speed has come no nearer to the reference, by half a margin: speed_deviation. No torque is left (the zero is
 *   off by about a quarter turn), or the load holds the balance, and only the back-EMF can decide: where it stands on the q axis, by
 *   more than 0.3 of the resistive drop and 4 % of the dc link, the load is excused. For the default motor that is from 80 rad/s on;
 *   a drive that is held in balance at its limit below that trips. A start under 20 times the rotor's inertia and 0.9 of the torque
 *   does not.
 * - For stall_s the shaft has not moved by 1.4 degrees: stall. Blocked, a stuck encoder, a zero off by a quarter turn at rest, or
 *   static friction stronger than the drive: at its limit the current cannot grow any more, so waiting longer helps only where the
 *   friction falls by itself; stall_s is longer for such a machine. Longer by itself where the reference would not have turned the
 *   shaft by three times that motion yet, and with less than 256 counts a turn, where a motion is a count: by sqrt(256 / counts).
 * - A shaft that is to rest, by a reference within the margin of 0, turns against the torque, slower than the margin and for twice
 *   stall_s and three motions or longer: stall (main loop, stall.c). The load is a little stronger than the drive. One that stands is
 *   held, and in order.
 *
 * Stall in current and torque mode, main loop (stall.c), with stall_torque_a: from that torque on the shaft has to move by 1.4 degrees
 * within stall_torque_s, in whatever direction, for a load that overhauls the torque is in order there. So is a torque at standstill,
 * which looks the same as a blocked shaft and a stuck encoder: it is off by default. In torque mode it waits until the limit of the
 * speed would have turned the shaft by three motions; with a limit of 0, for ever.
 *
 * Not counted: a drive whose speed is within the margin of its reference, swinging, and a drive that turns with its torque at its
 * voltage limit. Together they leave a wrong zero 0.1 s at the limit without coming nearer, from rest and while running, at every
 * angle, with 256 counts a turn or more. Not seen: a zero off by so little less than a quarter turn that the remaining torque turns
 * the shaft towards its reference; its drive gets there, slowly and hot.
 *
 * Electrical zero, speed interrupt, every mode. With the same current, the q voltage follows the speed, whatever the motor's
 * resistance, flux and load: dvq = p psi cos(error of the zero) dw. Where it falls while the speed rises, three times in a row,
 * the zero is off by more than a quarter turn: electrical_zero. Needs speeds that differ by so much that vq changes by 4 % of
 * the dc link, at a current that stays within 5 % of iq_limit_a or of what the dc link drives through motor_resistance_ohm and
 * motor_lq_h in a speed sample, whichever is less, a voltage below its limit, and 16 counts per electrical turn. A speed loop faster
 * than 1 kHz is judged by its means over 1 ms: the noise of a current that one period answers is several percent of the dc link in vq.
 * Blind at constant speed and at standstill.
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
    DRIVE_ANGLE_AGAIN,       /**< Samples are missing: begin again, but for the tracking filter. */
    DRIVE_ANGLE_SEEN,
    DRIVE_ANGLE_KNOWN
} drive_angle_t;

#define DRIVE_STALL_TURN (1.0f / 256.0f) /**< A motion, mechanical: 1.4 degrees; an elastic shaft yields by less. */
#define DRIVE_STALL_MOTIONS 3U           /**< That the speed asked for would have made, or a load against the torque. */

/** From the parameters. */
typedef struct {
    angle_t jump;      /**< Largest change of the step of the angle. */
    float plain_rad_s; /**< Largest speed at which nothing but that is judged; negative: every angle has to be corrected first. */
    num_t margin;      /**< Speed that counts as a change. */
    num_t band;        /**< Largest difference of currents that count as equal. */
    num_t band_per_volt;     /**< `band` per volt of the dc link, where iq_limit_a is more than the link brings into the motor. */
    angle_t  travel;         /**< Of a stretch of which the speed is known. */
    uint16_t samples;        /**< At the limit, against the torque; 0: never judged. */
    bool     zero;           /**< Judge the electrical zero. */
    num_t    ohm, reactance; /**< Voltage per current, and that per speed, */
    num_t    reactance_d;    /**< of a current in the d axis. */
    uint16_t mean_samples;   /**< Of a mean by which the electrical zero is judged, and 1 per that. */
    num_t    per_mean_sample;
    num_t    due_per_sample; /**< Least gain of speed at the limit. */
    angle_t  stall_angle;    /**< A motion. */
    uint16_t stall_samples;  /**< At the limit without one; 0: never judged. */
    num_t    stall_travel;   /**< Sum of the speeds asked for over which a shaft that turns has moved. */
} drive_motion_setup_t;

typedef struct {
    num_t    first, slowest; /**< Speed along the torque in a stretch at the limit. */
    bool     forwards;       /**< Direction of the torque command in that stretch. */
    angle_t  from;           /**< Encoder at the beginning of that stretch. */
    uint16_t samples;        /**< Length of that stretch. */
    ctl_dq_t sum_current;    /**< Sums over the samples of a mean, */
    num_t    sum_speed, sum_volt_q;
    uint16_t summed;  /**< so many so far, */
    bool     sum_cut; /**< one of which lacked voltage. */
    bool     held;    /**< There is an operating point to compare with: current, speed, volt_q. */
    ctl_dq_t current;
    num_t    speed, volt_q;
    uint16_t against;       /**< Comparisons in a row with the wrong sign. */
    num_t    nearest;       /**< Largest speed along the torque at the limit. */
    uint16_t since;         /**< Samples since `nearest` was reached. */
    num_t    due;           /**< Least speed that is expected by now. */
    uint16_t pushing;       /**< Samples at the limit so far. */
    angle_t  pushed_from;   /**< Encoder when these samples began. */
    bool     travelled;     /**< The shaft has turned so far since that its speed is known. */
    num_t    asked;         /**< Speed that the speed or position loop wants. */
    angle_t  stall_from;    /**< Encoder when the shaft seemed to stop. */
    uint16_t stall_samples; /**< Samples at the limit since then. */
    num_t    stall_travel;  /**< Sum of the speed commands in these samples. */
} drive_motion_t;

/** Of stall.c, from the parameters; 0 periods: never judged. */
typedef struct {
    uint32_t slip_periods, pull_periods;
    num_t    pull;       /**< Torque from which the shaft has to turn, as q current. */
    float    travel_rad; /**< That the speed must have left room for. */
} drive_stall_setup_t;

/** Main loop. */
typedef struct {
    angle_t  from;    /**< Encoder when the shaft seemed to stop, or at its last motion, */
    uint32_t since;   /**< and the sample in which all of it began. */
    uint16_t motions; /**< Against the torque since then. */
} drive_stall_t;

#endif
