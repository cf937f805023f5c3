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
/** Fill with zeros, which count as samples: from here on every delay below the capacity is valid. Costs O(capacity). */
void ctl_ring_fill_zero(ctl_ring_t *self);
/** A place that may lie up to one capacity before the first. Without a branch: the capacity is read in any case. */
static inline uint16_t ctl_ring_wrap(const ctl_ring_t *self, int32_t place)
{
    const int32_t capacity = (int32_t)self->capacity;
    return (uint16_t)(place + (capacity & ((place < 0) ? -1 : 0)));
}
/** Where the sample of @p delay pushes ago is, for a delay below the capacity. */
static inline uint16_t ctl_ring_place(const ctl_ring_t *self, uint16_t delay)
{
    return ctl_ring_wrap(self, (int32_t)self->head - (int32_t)delay);
}
/** ctl_ring_push for a ring that is full. */
static inline void ctl_ring_push_full(ctl_ring_t *self, num_t x)
{
    self->head = (uint16_t)(((self->head + 1U) < self->capacity) ? (self->head + 1U) : 0U);
    self->sample[self->head] = x;
}
/** Put a new sample in front; the oldest leaves. */
static inline void ctl_ring_push(ctl_ring_t *self, num_t x)
{
    ctl_ring_push_full(self, x);
    self->filled = (uint16_t)(self->filled + ((self->filled < self->capacity) ? 1U : 0U));
}
/** Sample of @p delay pushes ago. */
static inline num_t ctl_ring_get(const ctl_ring_t *self, uint16_t delay)
{
    return (delay < self->filled) ? self->sample[ctl_ring_place(self, delay)] : (num_t)0;
}
/** Change a sample that is in the ring already; one that was cleared counts as zero and becomes valid, as all newer ones. */
void ctl_ring_set(ctl_ring_t *self, uint16_t delay, num_t x);

#endif
