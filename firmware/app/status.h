/**
 * @file  firmware/app/status.h
 * @brief Queries of the drive's state. No file outside of firmware/app reads a member of drive_t: tests/architecture checks it.
 *
 * Any context, unless a function states another: each answer is one word.
 */
#ifndef FIRMWARE_APP_STATUS_H
#define FIRMWARE_APP_STATUS_H

#include "firmware/app/drive.h"

static inline drive_state_t drive_state(const drive_t *d) { return d->state; }
static inline drive_fault_t drive_fault(const drive_t *d) { return d->fault; }
/** FAULT_configuration: index of the parameter; FAULT_align_pole_pairs: what the motion shows; FAULT_restart_lockout: seconds to wait;
 *  FAULT_encoder_index: counts lost or added. */
static inline uint16_t drive_fault_detail(const drive_t *d) { return d->fault_detail; }
/** Whether current may flow in this state. */
static inline bool drive_state_is_armed(drive_state_t state)
{
    return (state == DRIVE_RUN) || (state == DRIVE_ALIGN) || (state == DRIVE_SHORT);
}
static inline bool drive_is_armed(const drive_t *d) { return drive_state_is_armed(d->state); }
/** The bridge is off, and nothing is being measured: what takes long may be done. */
static inline bool drive_is_idle(const drive_t *d)
{
    return (d->state == DRIVE_READY) || (d->state == DRIVE_FAULT) || (d->state == DRIVE_INIT);
}
/** The offsets of the current sensors are known. */
static inline bool drive_has_started_up(const drive_t *d) { return d->started_up; }
/** A stop that has not been carried out yet. */
static inline bool drive_stop_waits(const drive_t *d) { return d->stop_wanted; }
/** A changed parameter set that the current interrupt has not taken over yet. */
static inline bool drive_change_waits(const drive_t *d) { return d->next_ready != 0U; }
static inline bool drive_is_homed(const drive_t *d) { return d->position.homed; }
/** Something is being saved. */
static inline bool drive_is_saving(const drive_t *d) { return d->storage.active; }
/** What is saved through power-off, parameters and table alike. Main loop. */
static inline store_t *drive_storage(drive_t *d) { return &d->storage; }
/** How much of the stack the board has seen in use, for telemetry. Main loop. */
static inline void drive_note_stack(drive_t *d, uint16_t words) { d->stack_used_words = words; }
/** The newest command that was accepted. Main loop. */
static inline const drive_command_t *drive_newest_command(const drive_t *d) { return &d->command[d->command_at & 1U]; }
/** CPU cycles of a PWM period, and how long current interrupts take. */
static inline uint32_t            drive_period_cyc(const drive_t *d) { return d->setup->period_cyc; }
static inline const timing_one_t *drive_current_timing(const drive_t *d) { return &d->timing.current; }

#endif
