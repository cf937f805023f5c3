#include "control/repetitive/q_filter.h"

static bool at_most_one(num_t magnitude) { return num_abs(magnitude) <= NUM_C(1.00001f); }

bool ctl_q_is_bounded(const ctl_q_t *q)
{
    const num_t side = num_add(q->side, q->side);
    const num_t side2 = num_add(q->side2, q->side2);
    const num_t ends = num_add(q->centre, side2);
    const num_t bend = num_add(side2, side2);
    bool        bounded = at_most_one(num_add(ends, side)) && at_most_one(num_sub(ends, side));
    if (bounded && (num_abs(q->side) < num_abs(bend))) { /* the vertex lies between */
        const num_t lower = num_div(num_mul(q->side, q->side), bend);
        bounded = at_most_one(num_sub(num_sub(q->centre, side2), lower));
    }
    return bounded;
}
