/**
 * @file  firmware/app/memory_check.h
 * @brief What must not change by itself: sums and copies of it, held against it in every pass of the main loop.
 *
 *     parameters, and what follows from them    a sum of each set, taken when it is made; a part of it in each pass, all of
 *                                               the set in force in at most 12 passes
 *     their copies in the controllers           against the set, in every pass
 *     command, and what follows from it         a sum, in every pass
 *     electrical zero, offsets of the sensors   a sum taken when the bridge is armed, in every pass while it is
 *     state                                     against what the main loop has done with the bridge
 *
 * What changes in every period (integrals, angles, speeds) is not here: the loops correct it, or what judges motion and currents
 * finds it. Only the main loop writes any of it, so that no interrupt comes in between; a set that waits to be taken over is the
 * exception, and meanwhile the copies are not judged. Cost: main loop, 3000 cycles a pass at most.
 */
#ifndef FIRMWARE_APP_MEMORY_CHECK_H
#define FIRMWARE_APP_MEMORY_CHECK_H

#include "firmware/app/drive.h"

/** Detail of FAULT_memory_changed. */
enum { DRIVE_MEMORY_COMMAND = 1, DRIVE_MEMORY_PARAMETERS, DRIVE_MEMORY_COPIES, DRIVE_MEMORY_ZERO, DRIVE_MEMORY_STATE };

/** A set of parameters, or the command at @p at, has been written as it is to be. */
void drive_keep_set(drive_t *d, const drive_set_t *set);
void drive_keep_command(drive_t *d, uint16_t at);
/** The bridge is about to be armed: zero and offsets stay from now on. */
void drive_keep_zero(drive_t *d);
/** One pass. Trips with FAULT_memory_changed. */
void drive_check_memory(drive_t *d);
/** After that fault: whether the drive may go on. The command is dropped, zero and offsets are measured again; with other
 *  parameters or numbers in the controllers it may not, only drive_init helps. */
bool drive_recover_memory(drive_t *d);

#endif
