/**
 * @file  control/memory/window.h
 * @brief The newest 16 samples, lying one after the other: no index wraps while they are read.
 *
 * Every sample is kept twice, 16 cells apart, so that 16 cells from the newest one on are always the newest 16 samples.
 * Before the newest lie CTL_WINDOW_MARGIN places that may be read, too, and mean nothing but are finite: so a sum of fixed
 * length can run over its end with coefficients of zero.
 * ctl_long_window_t is the same for 32 samples.
 * Cost  a push is two stores; a read is one load at a fixed offset.
 */
#ifndef CONTROL_MEMORY_WINDOW_H
#define CONTROL_MEMORY_WINDOW_H

#include "control/numeric/num.h"

/* For every length; lengths are constants where these are called. */
static inline void ctl_places_fill(num_t *places, uint16_t count, num_t x)
{
    for (uint16_t i = 0U; i < count; i++) {
        places[i] = x;
    }
}

/* @p first: the places behind the margin, 2 @p size of them. */
static inline const num_t *ctl_places_push(num_t *first, uint16_t *head, uint16_t size, num_t x)
{
    *head = (uint16_t)((*head - 1U) & (size - 1U));
    num_t *const at = &first[*head];
    at[0] = x;
    at[size] = x;
    return at;
}

#define CTL_WINDOW_SIZE 16U
#define CTL_WINDOW_MARGIN 6U

typedef struct {
    num_t    x[CTL_WINDOW_MARGIN + (2U * CTL_WINDOW_SIZE)];
    uint16_t head; /**< Place of the newest sample, [0, CTL_WINDOW_SIZE - 1]; falls with every push. */
} ctl_window_t;

/** All samples are @p x. */
static inline void ctl_window_fill(ctl_window_t *self, num_t x)
{
    ctl_places_fill(self->x, CTL_WINDOW_MARGIN + (2U * CTL_WINDOW_SIZE), x);
    self->head = 0U;
}

/** The newest sample; [1] is the one before it, up to [CTL_WINDOW_SIZE - 1]. */
static inline const num_t *ctl_window_newest(const ctl_window_t *self) { return &self->x[CTL_WINDOW_MARGIN + self->head]; }

/** Put @p x in front; the oldest leaves. @return ctl_window_newest. */
static inline const num_t *ctl_window_push(ctl_window_t *self, num_t x)
{
    return ctl_places_push(&self->x[CTL_WINDOW_MARGIN], &self->head, CTL_WINDOW_SIZE, x);
}

#define CTL_LONG_WINDOW_SIZE 32U
#define CTL_LONG_WINDOW_MARGIN 10U

typedef struct {
    num_t    x[CTL_LONG_WINDOW_MARGIN + (2U * CTL_LONG_WINDOW_SIZE)];
    uint16_t head; /**< Cell of the newest sample, [0, CTL_LONG_WINDOW_SIZE - 1]. */
} ctl_long_window_t;

static inline void ctl_long_window_fill(ctl_long_window_t *self, num_t x)
{
    ctl_places_fill(self->x, CTL_LONG_WINDOW_MARGIN + (2U * CTL_LONG_WINDOW_SIZE), x);
    self->head = 0U;
}

static inline const num_t *ctl_long_window_newest(const ctl_long_window_t *self)
{
    return &self->x[CTL_LONG_WINDOW_MARGIN + self->head];
}

static inline const num_t *ctl_long_window_push(ctl_long_window_t *self, num_t x)
{
    return ctl_places_push(&self->x[CTL_LONG_WINDOW_MARGIN], &self->head, CTL_LONG_WINDOW_SIZE, x);
}

#endif
