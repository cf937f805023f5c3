/**
 * @file  firmware/app/internal.h
 * @brief What the files of the drive share among themselves.
 */
#ifndef FIRMWARE_APP_INTERNAL_H
#define FIRMWARE_APP_INTERNAL_H

#include "firmware/app/status.h"
#include "hal/hal_order.h"

/** configure.c: parameters to block parameters. @return PARAM_COUNT, or the index of the refused parameter. */
uint16_t drive_make_setup(const drive_params_t *params, drive_setup_t *setup);
/** configure.c: build all blocks from the set in force, the first; everything at rest. @return PARAM_COUNT or the culprit. */
uint16_t drive_build(drive_t *d);
/** take_over.c: put d->next in force, between two samples. Current interrupt. */
void drive_take_over(drive_t *d);
/* The parts of the drive: current_loop.c, tracking.c, speed_loop.c with speed_repetitive.c, disturbance_observer.c, position_setup.c.
 * Main loop. The same verbs each, on their own share of the setup and their own state:
 *
 *     make     parameters to numbers. @return PARAM_COUNT, or the parameter that is beyond the numeric
 *     judge    let the blocks refuse these numbers, on copies. @return PARAM_COUNT, or the culprit
 *     build    start the blocks from them; `differs`: whether a change needs that
 *     rest     controllers at rest, for a start
 *
 * What the current interrupt changes in a part that runs (retune) is in take_over.c. */
uint16_t drive_make_current(const drive_params_t *params, const drive_scale_t *scale, drive_current_setup_t *setup);
uint16_t drive_judge_current(const drive_current_setup_t *setup);
void     drive_build_current(drive_current_t *current, const drive_current_setup_t *setup);
void     drive_rest_current(drive_current_t *current, const drive_current_setup_t *setup);

/** reference_setup.c: MTPA and field weakening. The culprit, or PARAM_COUNT. */
uint16_t drive_make_reference(const drive_params_t *params, const drive_scale_t *scale, drive_reference_setup_t *setup);
void     drive_rest_reference(ctl_reference_state_t *state, const drive_reference_setup_t *setup);
/** reference_setup.c: bound of the torque that is asked for, as q current. */
float drive_torque_limit_a(const drive_params_t *params);
/** reference_step.c: one sample; speed interrupt, after the loop. Only where it is used. */
void drive_refer_currents(drive_t *d);

uint16_t drive_make_tracking(const drive_params_t *params, const drive_scale_t *scale, drive_tracking_setup_t *setup);
uint16_t drive_judge_tracking(const drive_tracking_setup_t *setup);
void     drive_build_tracking(drive_tracking_t *tracking, const drive_tracking_setup_t *setup);

uint16_t drive_make_speed(const drive_params_t *params, const drive_scale_t *scale, drive_speed_setup_t *setup);
uint16_t drive_judge_speed(const drive_speed_setup_t *setup);
void     drive_build_speed(drive_speed_t *speed, const drive_speed_setup_t *setup, num_t *memory);
void     drive_rest_speed(drive_speed_t *speed, const drive_speed_setup_t *setup);
uint16_t drive_make_repetitive(const drive_params_t *params, const drive_scale_t *scale, drive_speed_setup_t *setup);
uint16_t drive_judge_repetitive(const drive_speed_setup_t *setup);
void     drive_build_repetitive(drive_speed_t *speed, const drive_speed_setup_t *setup, num_t *memory);
bool     drive_repetitive_differs(const drive_speed_setup_t *before, const drive_speed_setup_t *setup);

/** Which observer the set asks for, by method or by disturbance_observer. */
drive_observer_word_t drive_observer_asked(const drive_params_t *params);
uint16_t drive_make_observer(const drive_params_t *params, const drive_scale_t *scale, drive_observer_setup_t *setup);
uint16_t drive_judge_observer(const drive_observer_setup_t *setup);
void     drive_build_meter(drive_observer_t *observer, const drive_observer_setup_t *setup);
bool     drive_meter_differs(const drive_observer_setup_t *before, const drive_observer_setup_t *setup);
void     drive_build_observer(drive_observer_t *observer, const drive_observer_setup_t *setup, num_t *memory);
bool     drive_observer_differs(const drive_observer_setup_t *before, const drive_observer_setup_t *setup);
void     drive_rest_observer(drive_observer_t *observer, const drive_observer_setup_t *setup);

uint16_t drive_make_position(const drive_params_t *params, const drive_scale_t *scale, drive_position_setup_t *setup);
uint16_t drive_judge_position(const drive_position_setup_t *setup);
void     drive_build_position(drive_position_t *position, const drive_position_setup_t *setup);
void     drive_build_position_memory(drive_position_t *position, const drive_setup_t *setup, num_t *memory, uint16_t room);
bool     drive_position_differs(const drive_setup_t *before, const drive_setup_t *setup);
void     drive_rest_position(drive_position_t *position);

/** current_correction.c: whether harmonics of the magnet flux are compensated. */
bool     drive_smooths(const drive_params_t *params);
void     drive_make_correction(const drive_params_t *params, const drive_scale_t *scale, drive_sensors_setup_t *setup);
uint16_t drive_judge_correction(const drive_sensors_setup_t *setup);
void     drive_build_correction(drive_sensors_t *correction, const drive_sensors_setup_t *setup, const drive_scale_t *scale);
bool     drive_correction_differs(const drive_sensors_setup_t *before, const drive_sensors_setup_t *setup);
/** current_correction.c: learn from the turn that the interrupt has completed, if any. Once per pass of the main loop. */
void drive_attend_correction(drive_t *d);

/** handover.c: bits of the blocks that a change needs to build again. */
#define DRIVE_SHAPE_REPETITIVE 1U
#define DRIVE_SHAPE_METER 2U
#define DRIVE_SHAPE_OBSERVER 4U
#define DRIVE_SHAPE_POSITION 8U
uint16_t drive_shape_changes(const drive_setup_t *before, const drive_setup_t *setup);
/** handover.c: keep the interrupts away from these blocks until they have taken the change over. Main loop, bridge off. */
void drive_withdraw(drive_t *d, uint16_t what);

/** start_check.c: q current that the motor's own voltage drives between the release of the gates and the first voltage of the
 *  current loop, ampere; the most that a start bears. Main loop. */
float drive_start_surge_a(const drive_t *d);
float drive_start_surge_max_a(const drive_t *d);
/** start_check.c: give the current loop the voltage of the turning motor to begin with. Main loop, bridge off. */
void drive_preset_voltage(drive_t *d);

/** limits.c: the first parameter that is beyond the board's maximum, or that does not fit the others, or PARAM_COUNT. */
uint16_t drive_board_refuses(const drive_params_t *params);
uint16_t drive_relation_refuses(const drive_params_t *params);
/** combinations.c: the first parameter of the first rule of combinations.def that the set breaks, or PARAM_COUNT. */
uint16_t drive_combination_refuses(const drive_params_t *params);
/** limits.c: no more than this flows when the phases are shorted at over_speed_rad_s, ampere. */
float drive_short_a(const drive_params_t *params);
/** limits.c: longest current vector and largest d current; the motor's own voltage at over_speed_rad_s, between two phases. */
float drive_longest_a(const drive_params_t *params);
float drive_id_max_a(const drive_params_t *params);
float drive_emf_v(const drive_params_t *params);
/** command.c: hand the newest command over again, under the limits in force. */
void drive_command_again(drive_t *d);
/** excite.c: its share of an order; drops an excitation that the set in force refuses. Main loop. */
void drive_order_excitation(drive_t *d, drive_order_t *order);
/** excite.c: no excitation any more; acts with the next order. Main loop. */
static inline void drive_forget_excitation(drive_t *d) { d->excitation.where = DRIVE_EXCITE_NONE; }
/** command.c: hand over a command that has been judged. */
void drive_hand_over(drive_t *d, const drive_command_t *command);

/** state_machine.c: change the state, unless a fault has come. Main loop. */
void drive_enter(drive_t *d, drive_state_t state);
/** stop.c: one pass of a run. @return false: the bridge is to go off. Main loop. */
bool drive_stop_goes_on(drive_t *d);
/** stop.c: no stop is under way any more. Main loop. */
void drive_stop_forget(drive_t *d);

/** restart.c: a fault has been cleared; whether a start is allowed, which it counts, or trips; drop what is too old. Main loop. */
void drive_note_clear(drive_t *d);
bool drive_may_restart(drive_t *d);
void drive_attend_restarts(drive_t *d);

/** thermal.c: its share of the setup; one sample, speed interrupt, where it is used; what the heat leaves of the current, main loop. */
void drive_make_thermal(const drive_params_t *params, const drive_scale_t *scale, drive_thermal_setup_t *setup);
void drive_heat(drive_t *d);
void drive_attend_thermal(drive_t *d);

/** braking.c: its share of the setup; what of a torque the dc link leaves, speed interrupt, once a sample, where it is limited. */
void  drive_make_braking(const drive_params_t *params, const drive_scale_t *scale, drive_braking_setup_t *setup);
num_t drive_limit_braking(drive_t *d, num_t torque);
/** braking.c: the brake resistor, for one sample; speed interrupt, in every state, where it is used. */
void drive_chop(drive_t *d);

/** sto.c: the diagnosis of the input for safe torque off, once per pass of the main loop. */
void drive_attend_sto(drive_t *d);

/** A scaled number. When it is beyond the numeric, 128 per unit in the fixed build, its parameter is noted as the
 *  culprit: cutting it would give another drive than the one asked for. */
num_t drive_fitted(float x, uint16_t param, uint16_t *culprit);
/** configure.c: num_from_float, once: a copy of it takes 20 words. */
num_t drive_number(float x);
/** configure.c: a PI controller with limits of +-@p limit. */
ctl_pi_params_t drive_pi(num_t kp, num_t ki_ts, float limit, ctl_pi_anti_windup_t anti_windup);
#define DRIVE_TWO_PI 6.28318530718f
/** Limit of each axis of a current controller, far outside of what the vector limit lets through. */
#ifdef EVENSPIN_FIXED
#define DRIVE_AXIS_BOUND 120.0f
#else
#define DRIVE_AXIS_BOUND 1.0e6f
#endif

/** current_isr.c: what is commanded is 0, and shows as such. Only while the bridge is off: then no interrupt writes these. */
void drive_command_nothing(drive_t *d);
/** configure.c: all parts at rest, and nothing commanded: for a start. */
void drive_rest(drive_t *d);

/** alignment.c: the first parameter that makes an alignment impossible, or PARAM_COUNT. */
uint16_t drive_judge_alignment(const drive_params_t *params);
/** alignment.c: begin to wait for the shaft; bridge off. Main loop. */
void drive_align_begin(drive_t *d);
/** alignment.c: begin with current; the bridge has been armed. Main loop. */
void drive_align_pull(drive_t *d);
/** alignment.c: one period. @return whether current flows: `align.current_now` at `align.at`. Current interrupt. */
bool drive_align_step(drive_t *d);
/** alignment.c: what the motion of a finished alignment says. Main loop. */
drive_align_result_t drive_align_judge(const drive_t *d);
/** alignment.c: whether the electrical zero may be wrong after this fault. */
bool drive_fault_voids_zero(drive_fault_t fault);

/** protection.c: enter a fault unless there is one; the bridge goes off at once. Any context. */
void drive_trip(drive_t *d, drive_fault_t fault);
/** protection.c: enter the fault that the hardware has found, if any, and name a gate driver's fault once it is known. Any context. */
void drive_check_hardware(drive_t *d);
/** protection.c: judge the newest sample. @return false when it must not be used. Current interrupt. */
bool drive_check_sample(drive_t *d, hal_status_t status, uint32_t previous_seq);
/** winding_check.c: its share of the setup. */
void drive_make_plausibility(const drive_params_t *params, drive_setup_t *setup);
/** motion_check.c: its share of the setup. */
void drive_make_motion(const drive_params_t *params, drive_setup_t *setup);
/** motion_check.c: the first samples of an angle, or of one after a gap; then the encoder is known. Current interrupt. */
void drive_find_angle(drive_t *d, angle_t theta);
/** motion_check.c: what the encoder shows, in the direction of the motor and without the error of the encoder. Interrupts. */
angle_t drive_true_angle(const drive_t *d, angle_t shown);
/** motion_check.c: over-speed, or an angle that cannot be. @return the angle to go on with. Current interrupt. */
angle_t drive_judge_motion(drive_t *d, float speed_abs_rad_s);
/** motion_check.c: torque and voltage against motion. Speed interrupt, after the speed has been measured. */
void drive_check_motion(drive_t *d);

/** stall.c: its share of the setup; a shaft that does not turn, or slips. Once per pass of the main loop. */
void drive_make_stall(const drive_params_t *params, drive_setup_t *setup);
void drive_attend_stall(drive_t *d);

/** index_check.c: its share of the setup; the newest index pulse, once per pass of the main loop; begin again with the next one. */
void drive_make_index(const drive_params_t *params, drive_setup_t *setup);
void drive_attend_index(drive_t *d);
void drive_forget_index(drive_t *d);

/** position.c: one sample of the position loop. */
void drive_position_measure(drive_t *d); /* in every mode: turns must not be lost */
void drive_position_step(drive_t *d, const drive_command_t *command);

/** A table over the angle: `limit` bounds its values, one of which is `base` in SI units. No grid: there is none. */
typedef struct {
    const ctl_grid_t *grid;
    num_t             limit;
    float             base;
} drive_learned_t;
#define DRIVE_LEARNED_PARTS 3U
/** memory.c: the learned table of the observer (0), of repetitive control (1), of position control (2). Main loop. */
drive_learned_t drive_learned(const drive_t *d, uint16_t part);
/** memory.c: the table in which value @p cell of all of them is, and its place there; no grid beyond the last. Main loop. */
drive_learned_t drive_learned_cell(const drive_t *d, uint16_t *cell);

/** speed_isr.c: one sample of the speed loop. */
void drive_speed_step(drive_t *d);

/** Steps of 2^-32 turns that stay exact: through 16 whole bits of float at a time. */
static inline int64_t drive_turns_q32(float turns)
{
    const float   cut = (turns < 2.0e6f) ? ((turns > -2.0e6f) ? turns : -2.0e6f) : 2.0e6f;
    const float   scaled = cut * 1024.0f;
    const int32_t high = (int32_t)scaled;
    return ((int64_t)high * INT64_C(0x400000)) + (int32_t)((scaled - (float)high) * 4194304.0f);
}

/** Steps of the ramp of the speed reference; any number, cut to what none of these drives reaches. */
static inline int64_t drive_ramp_steps(float rad_s)
{
    const float   cut = (rad_s < 32000.0f) ? ((rad_s > -32000.0f) ? rad_s : -32000.0f) : 32000.0f;
    const float   scaled = cut * 65536.0f;
    const int32_t high = (int32_t)scaled;
    return ((int64_t)high * INT64_C(64)) + (int32_t)((scaled - (float)high) * 64.0f);
}

/** A finite number in SI units over its base; the bases of the float build are 1. */
static inline num_t drive_per_base(float x, float inverse_base)
{
#ifdef EVENSPIN_FIXED
    return num_from_float(x * inverse_base);
#else
    (void)inverse_base;
    return x;
#endif
}

/** The other way round. */
static inline float drive_si(num_t x, float base)
{
#ifdef EVENSPIN_FIXED
    return num_to_float(x) * base;
#else
    (void)base;
    return x;
#endif
}

/** The newest set that was accepted: in force, or waiting for the interrupt. Main loop. */
static inline const drive_set_t *drive_newest(const drive_t *d)
{
    return (d->next_ready != 0U) ? d->next : ((d->setup == &d->set[0].setup) ? &d->set[0] : &d->set[1]);
}

/** Something that learns or takes away what is not as the speed loop wants it: not in torque mode. Main loop. */
static inline bool drive_learns_load(const drive_t *d)
{
    const drive_setup_t *const s = &drive_newest(d)->setup;
    return s->speed.rc_used || s->observer.used;
}

static inline const drive_command_t *drive_active_command(const drive_t *d) { return &d->command[d->command_at & 1U]; }
static inline const drive_order_t   *drive_active_order(const drive_t *d) { return &d->order[d->command_at & 1U]; }

/** Bound of the torque, as q current that makes it without d current, and of the q current. */
static inline num_t drive_torque_room(const drive_t *d)
{
    /* the observer's part comes on top, within what the current interrupt makes of the sum */
    const drive_order_t *const order = drive_active_order(d);
    return d->setup->reference.used ? num_add(num_min(d->reference.room, order->room), num_abs(d->observer.estimate))
                                    : order->iq_max;
}
/** A torque within its room, and within what the dc link leaves for braking. Speed interrupt. */
static inline num_t drive_within_room(drive_t *d, num_t torque)
{
    const num_t room = drive_torque_room(d);
    const num_t cut = num_clamp(torque, num_neg(room), room);
    return d->setup->braking.limited ? drive_limit_braking(d, cut) : cut;
}
static inline num_t drive_iq_room(const drive_t *d) { return num_min(d->reference.iq_max, drive_active_order(d)->iq_max); }
/** The q current is at its limit, by as much as noise may hide. */
static inline bool drive_is_at_limit(const drive_t *d)
{
    return num_abs(d->current.ref.q) > num_mul(NUM_C(0.9f), drive_iq_room(d));
}

#endif
