/**
 * @file  firmware/app/drive.h
 * @brief The drive: one object, two interrupts, one main loop.
 *
 *     current interrupt, 10 kHz   sample -> tracking filter -> [speed loop] -> current control -> duties
 *     speed interrupt, 1 kHz      M/T speed -> error -> repetitive control -> PI -> q-current reference
 *     main loop                   state machine, commands, parameters
 *
 * Who writes what: the current interrupt everything in `sample`, `current`, `tracking`; the speed interrupt everything in
 * `speed` and `position`; the main loop `state`, `zero`, `command` and the set that is not in force. A fault is the exception: the
 * current interrupt may set it and switches the bridge off there and then. Commands and parameters cross as whole structs
 * (see drive_command, drive_tune), in the order that hal/hal_order.h keeps.
 *
 * Numerics: in the float build signals inside are in SI units; in the fixed build per unit of `scale`.
 */
#ifndef FIRMWARE_APP_DRIVE_H
#define FIRMWARE_APP_DRIVE_H

#include "control/motor/current_error.h"
#include "control/motor/current_reference.h"
#include "control/motor/dead_time.h"
#include "control/motor/deadbeat.h"
#include "control/motor/fourier.h"
#include "control/motor/frames.h"
#include "control/motor/mt_speed.h"
#include "control/motor/notch.h"
#include "control/motor/pi.h"
#include "control/motor/plausibility.h"
#include "control/motor/pll.h"
#include "control/motor/saturation.h"
#include "control/motor/speed_bound.h"
#include "control/motor/thermal.h"
#include "control/observer/observer.h"
#include "control/observer/torque_meter.h"
#include "control/position/ilc.h"
#include "control/position/ramp.h"
#include "control/position/rdc.h"
#include "control/position/src.h"
#include "control/repetitive/repetitive.h"
#include "firmware/app/alignment.h"
#include "firmware/app/faults.h"
#include "firmware/app/motion_check.h"
#include "firmware/app/parameters.h"
#include "firmware/app/timing.h"
#include "firmware/storage/store.h"
#include "hal/hal_encoder.h"
#include "hal/hal_sample.h"

#define DRIVE_PWM_HZ 10000U
#define DRIVE_RC_CAPACITY 512U        /**< Longest period in speed samples: 29 r/min with 4 pole pairs. */
#ifndef DRIVE_OBSERVER_CAPACITY       /* cmake/avr.cmake has less: there an object ends at 32767 bytes */
#define DRIVE_OBSERVER_CAPACITY 6144U /**< ro: one turn at 100 r/min and 10 kHz; aro: more cells than it takes. */
#endif

#define DRIVE_RAMP_STEPS 4194304.0f /**< Of a speed reference, per rad/s: 2^22. */

typedef enum {
    DRIVE_INIT = 0,
    DRIVE_OFFSET_CALIBRATION,
    DRIVE_ALIGN,
    DRIVE_READY,
    DRIVE_RUN,
    DRIVE_FAULT,
    DRIVE_SHORT, /**< A stop with the phases shorted by the lower switches. */
    DRIVE_STATES
} drive_state_t;

typedef enum { DRIVE_MODE_CURRENT = 0, DRIVE_MODE_SPEED, DRIVE_MODE_POSITION, DRIVE_MODE_TORQUE } drive_mode_t;
typedef enum { DRIVE_STOP_COAST = 0, DRIVE_STOP_RAMP, DRIVE_STOP_SHORT } drive_stop_word_t;
typedef enum { DRIVE_POSITION_PPI = 0, DRIVE_POSITION_SILC, DRIVE_POSITION_SRC, DRIVE_POSITION_RDC } drive_position_method_t;
typedef enum {
    DRIVE_METHOD_PI = 0,
    DRIVE_METHOD_CRC,
    DRIVE_METHOD_FORC,
    DRIVE_METHOD_FAL_FORC,
    DRIVE_METHOD_DOB,
    DRIVE_METHOD_RO,
    DRIVE_METHOD_ARO
} drive_method_t;
typedef enum { DRIVE_OBSERVER_NONE = 0, DRIVE_OBSERVER_DOB, DRIVE_OBSERVER_RO, DRIVE_OBSERVER_ARO } drive_observer_word_t;
typedef enum { DRIVE_SPEED_PLL = 0, DRIVE_SPEED_MT, DRIVE_SPEED_FIR } drive_speed_source_t;

/** What the user wants, taken over as a whole. */
typedef struct {
    drive_mode_t mode;
    float        speed_ref_rad_s; /**< Mechanical; in torque mode the limit of the speed in both directions, without its sign. */
    float        id_ref_a, iq_ref_a; /**< id in every mode, iq in current mode; in torque mode the torque, as q current. */
    int32_t      target_turns;       /**< Target of position mode: whole turns. */
    float        target_rad;         /**< Target of position mode: added to the whole turns, within +-2 pi. */
} drive_command_t;

enum { DRIVE_RAMP_NONE = 0, DRIVE_RAMP_SET = 1, DRIVE_RAMP_STOP = 2 }; /* at once; as the parameters say; to the rest of a stop */
#define DRIVE_SPEED_EXCITED 4U                                         /* beside them: an excitation on top */

/** Where a sine is added, from which a frequency response is measured. */
typedef enum {
    DRIVE_EXCITE_NONE = 0,
    DRIVE_EXCITE_TORQUE, /**< The q current reference, held from one sample of the speed loop to the next, as what that asks for. */
    DRIVE_EXCITE_CURRENT, /**< The q current reference in every PWM period. */
    DRIVE_EXCITE_SPEED,   /**< The speed reference. */
    DRIVE_EXCITES
} drive_excite_t;

/** An excitation; bounded by drive_excite_refuses. */
typedef struct {
    drive_excite_t where;
    float          amplitude; /**< Ampere of q current (with mtpa of torque current), or rad/s. */
    float          hz;
} drive_excitation_t;

/** What the current interrupt makes of it: within the limits, in the numeric of the build. The d axis comes first, and what
 *  it leaves of the longest vector bounds the q axis, whoever asks for it. */
typedef struct {
    num_t    id, iq, iq_max;
    bool     torque;      /**< Current mode: iq as it is, not as the speed or position loop needs it. */
    bool     plain;       /**< Neither that nor an excitation of the torque: the q current is what the loops need. */
    num_t    excite_held; /**< Amplitude of the excitation of the torque; 0: none. */
    num_t    excite_iq;   /**< Of that of the current; 0: none. */
    float    excite_rad_s;
    angle_t  excite_step; /**< Of its phase, per sample of where it acts. */
    int64_t  speed;       /**< Speed asked for, in steps of the ramp. */
    num_t    room;        /**< Bound of the torque where motor or bridge are too hot for the limits, else NUM_MAX. */
    num_t    speed_limit; /**< Torque mode: size of the speed. */
    uint16_t ramp;        /**< Speed mode: DRIVE_RAMP_SET and DRIVE_RAMP_STOP limit the acceleration; DRIVE_SPEED_EXCITED. */
} drive_order_t;

/** Base values. All 1 in the float build. */
typedef struct {
    float current_a, voltage_v, speed_rad_s;
    float error_unit;                          /**< One inside is this many units of the speed error. */
    float inv_current, inv_voltage, inv_speed; /**< Their inverses: the interrupts do not divide. */
} drive_scale_t;

/** The position loop's share of the setup. */
typedef struct {
    drive_position_method_t method;
    ctl_profile_params_t    profile, homing; /**< Motion to a target, and the search for the index. */
    ctl_pi_params_t         velocity_pi;
    num_t                   kp;            /**< Speed unit per rad. */
    num_t                   speed_per_rad; /**< Speed unit per rad and sample. */
    bool                    feed_speed;    /**< The command speed is fed forward. */
    bool                    learns;        /**< rdc with slow learning. */
    ctl_ilc_params_t        ilc, learn;
    ctl_src_params_t        src;
    ctl_rdc_params_t        rdc;
    uint16_t                cells, torque_delay, error_samples;
    num_t                   error_max;
    ctl_position_t          min, max;
} drive_position_setup_t;

typedef struct {
    ctl_pi_params_t       pi; /**< Of both axes. */
    ctl_deadbeat_params_t deadbeat;
    bool                  deadbeat_used;
    bool                  decouples;     /**< The voltages that the speed induces are fed forward. */
    num_t                 voltage_limit; /**< NUM_MAX: follow the dc link. */
    num_t                 advance;       /**< Voltage angle advance per mechanical speed, turns electrical. */
} drive_current_setup_t;

/** Whether voltages, currents and angle are judged, and by which numbers. */
typedef struct {
    bool                      used;
    ctl_plausibility_params_t run, align; /**< In an alignment nothing is known of where the magnets are. */
} drive_plausibility_setup_t;

typedef struct {
    ctl_pll_params_t pll;
    angle_t          encoder_offset; /**< Electrical. */
    uint16_t         pole_pairs;
    bool             encoder_reversed;
    angle_t       direction; /**< 1, or -1 where encoder_reversed: a factor, which the current interrupt needs no branch for. */
    bool          corrects;  /**< The encoder's angle is off by `error`, rad, over that angle. */
    bool          moves;     /**< The angle jumps when this set takes over: that is no lost encoder. */
    ctl_fourier_t error;
} drive_tracking_setup_t;

typedef struct {
    ctl_pi_params_t      pi;
    ctl_mt_params_t      mt;
    drive_speed_source_t source;
    uint16_t             between;     /**< Current periods between two speed samples: one less than their distance. */
    bool                 inlined;     /**< The speed loop runs inside the current interrupt. */
    num_t                error_scale; /**< Speed error to loop error. */
    num_t                weight;      /**< Share of the reference that acts at once. */
    num_t                follow;      /**< Gain per sample with which the remaining share follows. */
    bool                 weighted;    /**< weight < 1. */
    ctl_rc_params_t      rc;
    uint16_t             rc_capacity;
    bool                 rc_used;
    num_t                rc_period_scale; /**< N = this / |speed reference|. */
    bool                 feeds;           /**< The model of rdc is fed forward. */
    bool                 notched;         /**< The notch filter stands behind the controller. */
    ctl_notch_params_t   notch;
    bool                 ramps;           /**< The reference goes to the speed asked for along `ramp`. */
    ctl_ramp_params_t    ramp, stop_ramp; /**< Steps of 1 / DRIVE_RAMP_STEPS rad/s, per sample. */
    num_t                lead_rad;        /**< Angle that the shaft turns until a torque of now acts, per speed unit. */
} drive_speed_setup_t;

typedef struct {
    ctl_meter_params_t    meter;
    ctl_observer_params_t observer;
    uint16_t              capacity;
    bool                  used, meter_used, hold;
    bool                  speed_asked; /**< The speed loop uses the speed of the meter. */
} drive_observer_setup_t;

typedef enum { DRIVE_CORRECTION_OFF = 0, DRIVE_CORRECTION_FIXED, DRIVE_CORRECTION_LEARNED } drive_correction_word_t;

/** Correction of the current sensors. */
typedef struct {
    drive_state_t plain_state; /**< RUN, or no state at all: in which nothing is corrected, and id is as commanded. */
    bool          used, learns, three, more; /**< `more`: three sensors, a dead time, flux harmonics, saturation, or MTPA. */
    float         offset[3], gain[3];        /**< By parameters; offsets in current units. */
    bool          compensates;               /**< The dead time of the bridge, too. */
    num_t         dead_share, per_soft;      /**< Dead time over PWM period; 1 / current of the soft sign. */
    bool          smooths;                   /**< The harmonics of the flux, too: */
    ctl_fourier_t flux;                      /**< in the q axis over the flux linkage, over six times the electrical angle. */
    bool          saturates; /**< The inductance falls with the current, and the gain of the controllers follows it: */
    ctl_saturation_params_t    saturation;
    ctl_current_error_params_t learning;
} drive_sensors_setup_t;

/** What every sample is judged by, SI. */
typedef struct {
    float over_current_a, over_voltage_v, under_voltage_v, over_speed_rad_s;
} drive_limits_t;

/** MTPA and field weakening. */
typedef struct {
    bool                 used;
    ctl_reference_plan_t plan;
} drive_reference_setup_t;

/** I2t of motor and bridge, SI. */
typedef struct {
    bool                 used;
    ctl_thermal_params_t motor, bridge;
    num_t                fast; /**< Speed from which the legs share the heat. */
} drive_thermal_setup_t;

/** Braking into a dc link that takes no energy back; voltages SI. */
typedef struct {
    bool                 limited;
    float                end_v, per_band; /**< No braking from there on; 1 / width of the line. */
    num_t                heats;           /**< Current, per speed, from which on the winding takes more than the shaft gives. */
    bool                 chops;
    float                chop_v, chop_per_v; /**< The chopper begins there; on-time per volt above. */
    float                per_ohm;
    ctl_thermal_params_t resistor; /**< Of a load in W instead of A^2. */
} drive_braking_setup_t;

/** Index pulse against count, SI. */
typedef struct {
    float tolerance_rad, counts_per_rad; /**< Tolerance 0: never judged. */
} drive_index_setup_t;

/** Everything that follows from the parameters, part by part, in the numeric of the build. */
typedef struct {
    drive_sensors_setup_t      sensors;
    drive_scale_t              scale;
    drive_limits_t             limits;
    drive_current_setup_t      current;
    drive_reference_setup_t    reference;
    drive_tracking_setup_t     tracking;
    drive_speed_setup_t        speed;
    drive_observer_setup_t     observer;
    drive_position_setup_t     position;
    drive_motion_setup_t       motion;
    drive_stall_setup_t        stall;
    drive_index_setup_t        index;
    drive_thermal_setup_t      thermal;
    drive_braking_setup_t      braking;
    drive_plausibility_setup_t plausibility;
    bool     more;       /**< The speed interrupt has more to do than the loop: `reference`, `thermal` or a chopper. */
    uint32_t period_cyc; /**< CPU cycles per PWM period. */
} drive_setup_t;

typedef struct {
    ctl_pll_t     pll;
    angle_t       theta_m, theta_e;
    drive_angle_t known;        /**< The filter has been set on a first angle, and the step to the next has been seen. */
    angle_t       expected;     /**< Where the encoder will be when it goes on as it went. */
    uint16_t      jump_periods; /**< Periods for which it has been somewhere else, up to the sample of this number: */
    uint32_t      jump_seq;
} drive_tracking_t;

/** The electrical zero; written by the main loop alone, while the bridge is off. */
typedef struct {
    angle_t  e;          /**< Electrical angle of the d axis at encoder angle zero: parameter, or found by alignment. */
    bool     found;      /**< By alignment; else it follows the parameter. */
    bool     reversed;   /**< encoder_reversed, with which it was found. */
    uint16_t pole_pairs; /**< pole_pairs, with which it was found. */
} drive_zero_t;

typedef struct {
    ctl_pi_t             d, q;
    ctl_deadbeat_state_t deadbeat;
    ctl_dq_t             ref, meas, volt;
    ctl_dq_t             induced;   /**< By the speed, which the integral parts hold. */
    bool                 decoupled; /**< `induced` is of the last sample. */
    num_t                torque;    /**< Of `ref`, as the q current that makes it with no d current. */
    angle_t              excite_phase;
    num_t                excite_held; /**< Of the torque, until the next sample of the speed loop. */
    num_t                excitation;  /**< Part of `ref.q`, within its limits; not written while the order is plain. */
} drive_current_t;

/** True current = measured current times scale less shift, phase by phase. */
typedef struct {
    float scale[3], shift_a[3];
} drive_sensors_map_t;

typedef struct {
    drive_sensors_map_t map[2]; /**< Main loop; the one at `at` is in force. */
    volatile uint16_t   at;
    ctl_turn_log_t      log; /**< Current interrupt. */
    ctl_dq_t held;           /**< Voltage of dead time and flux harmonics that the current controllers hold; current interrupt. */
    ctl_current_error_t learned;        /**< Main loop, */
    float               seen_d, seen_q; /**< and sums of the currents that it has seen in this turn, */
    uint16_t            seen;           /**< so many. */
} drive_sensors_t;

/** The observer of the disturbance torque, counted in q current; current interrupt. */
typedef struct {
    ctl_meter_t     meter;
    ctl_observer_t  observer;
    ctl_meter_out_t seen;
    num_t           estimate; /**< Disturbance expected when a reference of now acts. */
} drive_observer_t;

typedef struct {
    ctl_pi_t           pi;
    ctl_mt_t           mt;
    ctl_rc_t           rc;
    hal_encoder_edge_t edge;    /**< Newest, read by the speed interrupt. */
    uint32_t           now_cyc; /**< Of the speed tick; the following, too, come from the current interrupt. */
    angle_t            theta_e;
    num_t              meas, error, correction;
    num_t              followed; /**< Low-passed reference, for a set-point weight below 1. */
    num_t              drift;    /**< Added to the error, so that the encoder's rounding drifts; main loop. */
    num_t              iq_ref;   /**< q current reference; read by the current interrupt. */
    num_t              fed;      /**< Part of iq_ref that compensates what the disturbance observer would see; read with it. */
    float              ref_rad_s;
    ctl_notch_state_t  notch;
    ctl_ramp_state_t   ramp;
    bool               ramping; /**< `ramp` has the reference. */
    ctl_speed_bound_t  bound;   /**< Torque mode. */
    bool               bounded; /**< `bound` has the torque. */
    angle_t            excite_phase;
} drive_speed_t;

/** A position for who preempts the speed interrupt or is preempted by it: 64 bits are two accesses. */
typedef struct {
    volatile ctl_position_t value[2];
    volatile uint16_t       at; /**< Which of the two is whole. */
} drive_shown_t;

/** The position loop; written by the speed interrupt. */
typedef struct {
    ctl_position_t      raw;    /**< The encoder over its turns. */
    ctl_position_t      zero;   /**< raw at position 0. */
    ctl_position_t      now;    /**< Position. */
    ctl_position_t      before; /**< Of the last sample. */
    bool                primed, active, homed;
    bool                homing;
    ctl_position_t      home_limit;
    ctl_profile_state_t profile;
    ctl_setpoint_t      setpoint;
    ctl_pi_t            pi;
    ctl_ilc_t           ilc, learn;
    ctl_src_t           src;
    ctl_rdc_state_t     rdc;
    num_t               error, speed;
    num_t               delayed[8], fed_delayed[8];
    uint16_t            delay_head, error_count;
    drive_shown_t       now_shown, ref_shown; /**< `now` and the position of `setpoint`. */
} drive_position_t;

/** A stop that takes its time; main loop. */
typedef struct {
    drive_stop_word_t how;          /**< DRIVE_STOP_COAST: none is under way. */
    uint32_t          since, moved; /**< Numbers of the samples in which it began, and in which the shaft has last turned. */
    drive_command_t   resume;       /**< Command that a start after it finds; set by clients meanwhile. */
} drive_stop_t;

/** How hot motor and bridge are; speed interrupt. */
typedef struct {
    ctl_heat_t motor, leg[3];
    float      share;                     /**< Of the longest current vector that they allow, and the sensors; main loop. */
    float      celsius[HAL_TEMPERATURES]; /**< What the sensors show, */
    uint16_t   bad[HAL_TEMPERATURES];     /**< and for how many passes too much, or nothing; main loop. */
} drive_thermal_t;

/** The input for safe torque off; main loop. */
typedef struct {
    uint16_t channels; /**< That ask for it, bits. */
    uint32_t since;    /**< Number of the sample in which they were the same for the last time. */
    uint16_t stuck;    /**< The channel, 1 or 2, that asked for nothing for too long; 0: both work. */
} drive_sto_t;

/** The dc link while the motor brakes; speed interrupt. */
typedef struct {
    float      before_v; /**< In the sample before. */
    float      brake_w;  /**< Power of the brake resistor until the next sample. */
    ctl_heat_t resistor;
    bool       rests; /**< It was too hot and cools. */
} drive_braking_t;

#define DRIVE_RESTARTS 8U /**< Most of restart_limit. */

/** Starts after a trip; main loop. */
typedef struct {
    uint32_t at[DRIVE_RESTARTS]; /**< Numbers of the samples in which they were, within restart_window_s; the oldest first. */
    uint16_t count;
    bool     tripped; /**< A fault has been cleared since the last start. */
} drive_restarts_t;

/** Where the index pulse comes; main loop. */
typedef struct {
    uint16_t passes; /**< Of the newest that has been seen. */
    bool     known;
    float    first_rad, error_rad; /**< The first since the electrical zero was found, and how far the newest is from it. */
} drive_index_t;

/** A parameter set, and what follows from it. */
typedef struct {
    drive_params_t params;
    drive_setup_t  setup;
} drive_set_t;

/** Sums of what must not change by itself; main loop. memory_check.h */
typedef struct {
    uint32_t set[2], command[2], zero;
    uint16_t command_at;
    bool     bridge; /**< The main loop has armed it. */
    uint16_t of, at; /**< Set whose sum is being made, and how far. */
    uint32_t sum;
} drive_kept_t;

typedef struct {
    const drive_params_t *params; /**< The set in force: one of the two in `set`. Changed by the current interrupt. */
    const drive_setup_t  *setup;
    drive_scale_t         scale;

    drive_set_t        set[2];     /**< Written by the main loop while not in force. */
    const drive_set_t *next;       /**< The set that drive_tune has prepared. */
    volatile uint16_t  next_ready; /**< `next` is offered to the current interrupt. */
    volatile uint16_t  speed_busy; /**< The speed interrupt was requested and has not ended: its blocks may not change. */
    drive_command_t    command[2];
    drive_order_t      order[2];   /**< Of each. */
    volatile uint16_t  command_at; /**< Which of the two the interrupts read. */
    drive_excitation_t excitation; /**< Part of the newest order; main loop. */

    volatile drive_state_t state;
    volatile drive_fault_t fault;
    uint16_t      fault_detail; /**< FAULT_configuration: index of the parameter; FAULT_align_pole_pairs: what the motion shows;
                            *   FAULT_memory_changed: what has changed, memory_check.h; FAULT_restart_lockout: seconds to wait;
                            *   FAULT_encoder_index: counts lost or added; FAULT_temperature_sensor: 1 of the motor, 2 of the
                            *   bridge; FAULT_sto_discrepancy: the channel; FAULT_safe_torque_off: the channels that ask for it now,
                            *   1, 2 or 3 for both, and 4 times the one that did not open. */
    bool          started_up;   /**< The offsets are known. */
    bool          start_wanted, stop_wanted, clear_wanted;
    drive_stop_t  stopping;
    bool          permitted; /**< The bridge may be armed: there was a start, and since then no stop and no fault. */
    volatile bool home_wanted;

    hal_sample_t             sample;
    float                    ia_a, ib_a, ic_a; /**< Less the offsets of calibration, then corrected as `sensors` has it. */
    float                    offset_a_a, offset_b_a, offset_c_a;
    float                    sum_a_a, sum_b_a, sum_c_a; /**< Sums of the currents during calibration. */
    volatile uint16_t        sum_count;                 /**< Samples in these sums. */
    drive_tracking_t         tracking;
    drive_zero_t             zero;
    drive_align_t            align;
    drive_current_t          current;
    drive_speed_t            speed;
    ctl_reference_state_t    reference; /**< Which currents make the torque of `speed`; speed interrupt. */
    drive_observer_t         observer;
    drive_position_t         position;
    drive_sensors_t          sensors;
    store_t                  storage;     /**< Main loop; parameters (services) and table. */
    uint16_t                 saved_cells; /**< Of the table that is being saved. */
    drive_thermal_t          thermal;
    drive_braking_t          braking;
    drive_sto_t              sto;
    drive_motion_t           motion; /**< Whether motion and torque agree; speed interrupt. */
    drive_restarts_t         restarts;
    drive_index_t            index;
    drive_stall_t            stall;                     /**< Main loop. */
    float                    link_mean_v;               /**< Mean of the dc link over the last samples; current interrupt. */
    ctl_plausibility_state_t plausibility;              /**< Whether voltages, currents and angle agree; current interrupt. */
    uint16_t                 speed_count;               /**< Current periods until the next speed tick. */
    uint16_t                 bad_samples, lost_samples; /**< In a row. */
    uint16_t                 low_bus_samples;           /**< Samples in a row with a dc-link voltage below its limit. */
    uint32_t                 low_bus_seq;               /**< Number of the newest of these samples. */
    bool                     seen_sample;
    uint32_t                 rejected;
    timing_t                 timing;
    uint16_t                 stack_used_words; /**< Main loop; 0 where nobody counts. */
    drive_kept_t             kept;

    num_t rc_memory[DRIVE_RC_CAPACITY];
    num_t observer_memory[DRIVE_OBSERVER_CAPACITY];
} drive_t;

/** Start from nothing with @p params; the bridge is disarmed, and only drive_start ever arms it. A refused parameter leads to
 *  FAULT_configuration. auto_run is left to who calls: services.c. */
void drive_init(drive_t *d, const drive_params_t *params);

/** The two interrupts and one pass of the main loop. Each is bounded; none waits. */
void drive_current_isr(drive_t *d);
/** Right after drive_current_isr, in the same interrupt: what is judged beside the control (watch_isr.c). */
void drive_watch_isr(drive_t *d);
void drive_speed_isr(drive_t *d);
void drive_background(drive_t *d);

/**
 * Hand over a command, as a whole. Main loop only.
 * @return false (and nothing changes) when a number is not finite or beyond 1e6, the speed is beyond over_speed_rad_s, or the mode
 * does not go with method.
 * Currents are cut: id to id_limit_a, then iq, whether asked for or needed by the speed or position loop, to what is left of
 * the longest vector, the larger of iq_limit_a and id_limit_a. drive_command_refuses says before whether anything is cut.
 * With mtpa or field_weakening id is commanded in current mode only.
 */
bool drive_command(drive_t *d, const drive_command_t *command);
/** Position of a field in the command; DRIVE_COMMAND_FINE: all of them are within the limits in force; DRIVE_COMMAND_MODE: the first
 *  field, a mode that does not go with method: repetitive control corrects the speed loop, which position and torque mode do not run,
 *  and an observer would take away the load of torque mode. */
enum {
    DRIVE_COMMAND_FINE = 0,
    DRIVE_COMMAND_SPEED = 1,
    DRIVE_COMMAND_ID = 2,
    DRIVE_COMMAND_IQ = 3,
    DRIVE_COMMAND_ANGLE = 5,
    DRIVE_COMMAND_MODE = 6
};
/**
 * Add a sine to the torque or the speed reference of the running drive, from which a frequency response is measured; another one
 * replaces it, and its phase goes on. Ends with DRIVE_EXCITE_NONE, a new command, a stop, a fault, and a parameter set that it is refused
 * with. Main loop only.
 * @param hz  frequency that it has: a whole number of steps of 2^-32 turns per sample.
 * @return as drive_excite_refuses; nothing changes but for DRIVE_EXCITE_FINE. While it is off it costs the current interrupt nothing;
 * `evenspin cycles` has what it costs else (excitation).
 */
uint16_t drive_excite(drive_t *d, const drive_excitation_t *excitation, float *low, float *high, float *hz);
/** The first field that cannot be, and its limits. STATE: the drive does not run, or is being stopped. WHERE: no such place; only speed
 *  mode has a speed reference; repetitive control, ro, aro, silc, src and rdc_learn_gain would learn the sine, unless observer_hold.
 *  AMPLITUDE: above 0, within iq_limit_a; of the speed, with the reference within over_speed_rad_s. HZ: from 0.01 to 0.45 of the sample
 *  rate of where it acts. */
enum { DRIVE_EXCITE_WHERE = 0, DRIVE_EXCITE_AMPLITUDE = 1, DRIVE_EXCITE_HZ = 2, DRIVE_EXCITE_STATE = 3, DRIVE_EXCITE_FINE = 4 };
uint16_t drive_excite_refuses(const drive_t *d, const drive_excitation_t *excitation, float *low, float *high);
/** Excitation of the torque now, ampere. Any context. */
float drive_excitation_a(const drive_t *d);
/** The first field beyond its limit, and that limit: the field has to be within plus and minus it. */
uint16_t drive_command_refuses(const drive_t *d, const drive_command_t *command, float *limit);
/**
 * Requests to the state machine; read in the next pass of the main loop, a stop before a start. A start during
 * start-up waits for its end. Nothing but a start arms the bridge: where the electrical zero is not known it first aligns, then
 * runs. A stop or a fault switches the bridge off in every state, and it stays off until the next start; an alignment that was
 * stopped begins again with it. After a fault that casts doubt on the encoder or the zero the next start aligns again.
 */
void drive_start(drive_t *d);
/** As stop_action says: bridge off, at once or in the next pass; or from RUN down stop_ramp_rad_s2 in speed mode, or with the phases
 *  shorted by the lower switches (state DRIVE_SHORT), and off when the shaft has been at rest for 20 ms or stop_s is over. A start
 *  withdraws it, a second stop switches off. After a ramp the drive has the command from before it, or the newest since. */
void drive_stop(drive_t *d);
void drive_stop_by(drive_t *d, drive_stop_word_t how);
void drive_clear_fault(drive_t *d);
/** Search the index in position mode: turn with homing_speed_rad_s until it is passed, make it position 0, go there. */
void drive_home(drive_t *d);

/**
 * Change parameters while running: checked as a whole, then taken over between two current samples.
 * @param culprit  index of the refused parameter (PARAM_COUNT if none); may not be NULL.
 * @return false when refused, or while an earlier change still waits; nothing changes then.
 * What only acts at start-up (calibration) or in an alignment acts at the next one; the electrical zero that an alignment
 * has found stays. No limit goes beyond the board's maximum (hal_limits).
 *
 * What params_only_at_rest names is refused while the bridge is armed. At rest, memories and filters that get another kind or size
 * are set up in here, which takes about 1 ms at most; the interrupts leave them alone meanwhile, and what was learned in them is gone.
 * pole_pairs or encoder_reversed, changed at rest, make an alignment that was made before void: the next start aligns again.
 */
bool drive_tune(drive_t *d, const drive_params_t *params, uint16_t *culprit);

/** The newest set that was accepted: in force, or still to be taken over. Main loop. */
const drive_params_t *drive_newest_params(const drive_t *d);

/** Largest value that the board and the parameter's own range let it have. */
float drive_board_max(uint16_t param);
/** Between which values a parameter of a set has to be: its range, the board's maximum, and the other parameters. */
void drive_relation(const drive_params_t *params, uint16_t param, float *low, float *high);

/** Whether the electrical zero is known: by an alignment, or because the parameter is trusted. A start else aligns first. */
bool drive_zero_is_known(const drive_t *d);

/** Whether drive_tune refuses this parameter now and would not at rest. */
bool drive_needs_rest(const drive_t *d, uint16_t param);

/**
 * What has been learned over the angle, one table after the other: aro, ampere of q current over a mechanical turn; repetitive control
 * with rc_memory = angle, units of the speed error over an electrical turn; silc and src, rad/s, and rdc with rdc_learn_gain, ampere,
 * over a mechanical turn. Main loop only.
 * @return values written to @p values (at most @p room; 0 where nothing is learned over the angle).
 */
uint16_t drive_memory_read(const drive_t *d, float *values, uint16_t room);
/** The number of values, and one of them; 0 beyond. */
uint16_t drive_memory_cells(const drive_t *d);
float    drive_memory_cell(const drive_t *d, uint16_t cell);
/** Replace it. Refused (false) while running, with another number of cells, or with a value beyond the limit of its method. */
bool drive_memory_write(drive_t *d, const float *values, uint16_t cells);
/** Forget it, memories over time included. Refused while running. */
bool drive_memory_clear(drive_t *d);
/**
 * To and from non-volatile storage. A save cut off by a power failure leaves the older save, and one that does not read back as it
 * was written fails. In steps: begin, then step while `storage.active`; a page or a few blocks each. The table may not change meanwhile.
 * @return HAL_OK, HAL_UNSUPPORTED, HAL_BUSY (running, or another save), HAL_STALE (restore: nothing saved that reads as it was
 * saved; the table stays), or an error of the storage.
 */
hal_status_t drive_memory_save_begin(drive_t *d);
hal_status_t drive_memory_save_step(drive_t *d);
hal_status_t drive_memory_save(drive_t *d); /* all of it, for who may wait */
hal_status_t drive_memory_restore(drive_t *d);

/** Reset the timing statistics of both interrupts; a start does so as well. Main loop only. */
void drive_restart_timing(drive_t *d);

/** I2t: heat of the motor, and of the hottest leg of the bridge; 1: what the continuous current leads to. Any context. */
float drive_motor_heat(const drive_t *d);
float drive_bridge_heat(const drive_t *d);
float drive_chopper_heat(const drive_t *d); /**< Of the brake resistor. */
/** Speed that the loop uses, rad/s mechanical. */
float drive_speed_rad_s(const drive_t *d);
/** Until a start after a trip is allowed again; 0: now. Any context. */
float drive_restart_wait_s(const drive_t *d);
/** How far currents, voltages and angle contradict each other, over what is allowed; 0 while nothing is judged. Any context. */
float drive_contradiction(const drive_t *d);
/** Position and its command in rad, with the precision of a float. Any context. */
float drive_position_rad(const drive_t *d);
float drive_position_ref_rad(const drive_t *d);
/** Correction of a current sensor in force, phase 0 to 2: its offset, and its gain (1: right). Any context. */
float drive_current_offset_a(const drive_t *d, uint16_t phase);
float drive_current_gain(const drive_t *d, uint16_t phase);
/** Inputs that were refused: samples, and by the PI controllers of current and speed and the repetitive controller. */
uint32_t drive_rejected(const drive_t *d);

#endif
