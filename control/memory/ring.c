#include "control/memory/ring.h"

ctl_diag_t ctl_ring_init(ctl_ring_t *self, num_t *memory, uint16_t capacity)
{
    if (self == NULL) {
        return ctl_diag(CTL_ERR_NULL, 0U, (num_t)0);
    }
    if (memory == NULL) {
        return ctl_diag(CTL_ERR_NULL, CTL_RING_MEMORY, (num_t)0);
    }
    if ((capacity < 2U) || (capacity > 32767U)) {
        return ctl_diag_count(CTL_ERR_MEMORY, CTL_RING_CAPACITY, capacity);
    }
    self->sample = memory;
    self->capacity = capacity;
    self->head = 0U;
    ctl_ring_clear(self);
    return ctl_diag_ok();
}

void ctl_ring_clear(ctl_ring_t *self) { self->filled = 0U; }

void ctl_ring_fill_zero(ctl_ring_t *self)
{
    for (uint16_t i = 0U; i < self->capacity; i++) {
        self->sample[i] = (num_t)0;
    }
    self->filled = self->capacity;
}

void ctl_ring_set(ctl_ring_t *self, uint16_t delay, num_t x)
{
    if (delay >= self->capacity) {
        return;
    }
    while (self->filled <= delay) { /* runs only in the first samples after a clear */
        self->sample[ctl_ring_place(self, self->filled)] = (num_t)0;
        self->filled++;
    }
    self->sample[ctl_ring_place(self, delay)] = x;
}
