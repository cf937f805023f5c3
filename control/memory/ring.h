/**
 * @file  control/memory/ring.h
 * @brief Ring of the newest samples in the caller's memory. Delay 0 is the newest.
 *
 * What was never written reads as zero, also after ctl_ring_clear, which costs the same for every length.
 * Total    a delay beyond the capacity reads as zero; a delay beyond the capacity is not written.
 * Cost     O(1), no division.
 */
#ifndef CONTROL_MEMORY_RING_H
#define CONTROL_MEMORY_RING_H

#include "control/numeric/diag.h"

typedef struct {
    num_t   *sample;   /**< `capacity` samples, owned by the caller. */
    uint16_t capacity; /**< [2, 32767]. */
    uint16_t head;     /**< Where the newest sample is. */
    uint16_t filled;   /**< Samples that are valid, [0, capacity]. */
} ctl_ring_t;

enum { CTL_RING_MEMORY = 1, CTL_RING_CAPACITY };

/** Take over @p memory of @p capacity samples, all zero. On error @p self stays as it was. */
ctl_diag_t ctl_ring_init(ctl_ring_t *self, num_t *memory, uint16_t capacity);
/** Forget everything. */
void ctl_ring_clear(ctl_ring_t *self);
/** Put a new sample in front; the oldest leaves. */
void ctl_ring_push(ctl_ring_t *self, num_t x);
/** Sample of @p delay pushes ago. */
num_t ctl_ring_get(const ctl_ring_t *self, uint16_t delay);
/** Change a sample that is in the ring already; one that was cleared counts as zero and becomes valid, as all younger ones. */
void ctl_ring_set(ctl_ring_t *self, uint16_t delay, num_t x);

#endif
