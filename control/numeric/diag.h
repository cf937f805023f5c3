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
/* What follows is for configuration, and not inline: a copy for each of some seventy calls takes more room than it saves time. */

/** ctl_diag of a whole number; the fixed build shows at most 127. */
ctl_diag_t ctl_diag_count(ctl_status_t status, uint16_t field, uint16_t given);
/** CTL_OK when lo <= x <= hi, else CTL_ERR_RANGE; NaN is outside of every range. */
ctl_diag_t ctl_diag_range(num_t x, num_t lo, num_t hi, uint16_t field);
/** *d becomes ctl_diag_range of x, unless something has been refused before. */
void ctl_diag_also(ctl_diag_t *d, num_t x, num_t lo, num_t hi, uint16_t field);

#endif
