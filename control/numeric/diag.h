/**
 * @file  control/numeric/diag.h
 * @brief How every *_init says what it did not accept.
 */
#ifndef CONTROL_NUMERIC_DIAG_H
#define CONTROL_NUMERIC_DIAG_H

#include <stddef.h>

#include "control/numeric/num.h"

typedef enum {
    CTL_OK = 0,
    CTL_ERR_NULL,     /**< A pointer is missing. */
    CTL_ERR_RANGE,    /**< A value is outside its range or not finite. */
    CTL_ERR_RELATION, /**< Two values do not fit together. */
    CTL_ERR_MEMORY    /**< The memory handed over is too small. */
} ctl_status_t;

/** Status, the field of the block's own enumeration (0: none), and what was given. */
typedef struct {
    ctl_status_t status;
    uint16_t     field;
    num_t        given;
} ctl_diag_t;

static inline ctl_diag_t ctl_diag_ok(void)
{
    const ctl_diag_t d = {CTL_OK, 0U, (num_t)0};
    return d;
}
static inline ctl_diag_t ctl_diag(ctl_status_t status, uint16_t field, num_t given)
{
    const ctl_diag_t d = {status, field, given};
    return d;
}
/** ctl_diag of a whole number; the fixed build shows at most 127. */
static inline ctl_diag_t ctl_diag_count(ctl_status_t status, uint16_t field, uint16_t given)
{
    return ctl_diag(status, field, num_from_int((int16_t)((given < 32767U) ? given : 32767U)));
}
/** CTL_OK when lo <= x <= hi, else CTL_ERR_RANGE; NaN is outside of every range. */
static inline ctl_diag_t ctl_diag_range(num_t x, num_t lo, num_t hi, uint16_t field)
{
    return ((x >= lo) && (x <= hi)) ? ctl_diag_ok() : ctl_diag(CTL_ERR_RANGE, field, x);
}

#endif
