/**
 * @file  firmware/app/internal.h
 * @brief What the files of the drive share among themselves.
 */
#ifndef FIRMWARE_APP_INTERNAL_H
#define FIRMWARE_APP_INTERNAL_H

#include "firmware/app/drive.h"

/** configure.c: parameters to block parameters. @return PARAM_COUNT, or the index of the refused parameter. */
uint16_t drive_make_setup(const drive_params_t *params, drive_setup_t *setup);
/** configure.c: build all blocks from d->setup, everything at rest. @return PARAM_COUNT or the culprit. */
uint16_t drive_build(drive_t *d);
/** configure.c: take over d->next between two samples. Current interrupt. */
void drive_take_over(drive_t *d);
/* Each configure_*.c: make computes block parameters, judge lets the block refuse them (PARAM_COUNT, or the culprit), build
 * starts the block, take_over changes it between two samples. */
void     drive_make_repetitive(const drive_params_t *params, drive_setup_t *setup, uint16_t *culprit);
uint16_t drive_judge_repetitive(const drive_setup_t *setup);
void     drive_build_repetitive(drive_t *d);
void     drive_take_over_repetitive(drive_t *d, const drive_setup_t *before, const drive_setup_t *setup);
uint16_t drive_make_observer(const drive_params_t *params, drive_setup_t *setup);
uint16_t drive_judge_observer(const drive_setup_t *setup);
void     drive_build_observer(drive_t *d);
void     drive_take_over_observer(drive_t *d, const drive_setup_t *before, const drive_setup_t *setup);
void     drive_make_deadbeat(const drive_params_t *params, drive_setup_t *setup);
uint16_t drive_judge_deadbeat(const drive_setup_t *setup);
/** A scaled number. When it is beyond the numeric, 128 per unit in the fixed build, its parameter is noted as the
 *  culprit: cutting it would give another drive than the one asked for. */
num_t drive_fitted(float x, uint16_t param, uint16_t *culprit);
#define DRIVE_TWO_PI 6.28318530718f
/** Limit of each axis of a current controller, far outside of what the vector limit lets through. */
#ifdef EVENSPIN_FIXED
#define DRIVE_AXIS_BOUND 120.0f
#else
#define DRIVE_AXIS_BOUND 1.0e6f
#endif

/** state_machine.c: the first parameter that would change and must not now, or PARAM_COUNT. */
uint16_t drive_held_param(const drive_t *d, const drive_params_t *params);
/** current_isr.c: controllers at rest, for a start. */
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
/** protection.c: judge the newest sample. @return false when it must not be used. Current interrupt. */
bool drive_check_sample(drive_t *d, hal_status_t status, uint32_t previous_seq);
/** protection.c: at the current limit without motion, in speed mode. Speed interrupt. */
void drive_check_stall(drive_t *d);
/** protection.c: what to do about a motion that is not usual: encoder against its tracking filter, speed. Current interrupt. */
void drive_judge_motion(drive_t *d, float speed_rad_s, float apart_rad);

/** position.c: the position loop: configuration, start, one sample. */
uint16_t drive_make_position(const drive_params_t *params, drive_setup_t *setup);
void     drive_build_position(drive_t *d);
void     drive_rest_position(drive_t *d);
void     drive_take_over_position(drive_t *d, const drive_setup_t *before, const drive_setup_t *setup);
void     drive_position_measure(drive_t *d); /* in every mode: turns must not be lost */
void     drive_position_step(drive_t *d, const drive_command_t *command);

/** speed_isr.c: one sample of the speed loop. */
void drive_speed_step(drive_t *d);

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

static inline const drive_command_t *drive_active_command(const drive_t *d) { return &d->command[d->command_at & 1U]; }
static inline bool drive_is_armed(const drive_t *d) { return (d->state == DRIVE_RUN) || (d->state == DRIVE_ALIGN); }

#endif
