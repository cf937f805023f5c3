#include "control/position/ilc.h"

ctl_diag_t ctl_ilc_init(ctl_ilc_t *self, const ctl_ilc_params_t *params, num_t *memory, uint16_t cells)
{
    if ((self == NULL) || (params == NULL)) {
        return ctl_diag(CTL_ERR_NULL, 0U, (num_t)0);
    }
    ctl_diag_t d = ctl_diag_range(params->gain, (num_t)0, NUM_C(100.0f), CTL_ILC_GAIN);
    if ((d.status == CTL_OK) && (params->lead > CTL_ILC_LEAD_MAX)) {
        d = ctl_diag_count(CTL_ERR_RANGE, CTL_ILC_LEAD, params->lead);
    }
    ctl_diag_also(&d, params->limit, NUM_EPS, NUM_MAX, CTL_ILC_LIMIT);
    if (d.status != CTL_OK) {
        return d;
    }
    ctl_ilc_state_t made = {0};
    d = ctl_grid_init(&made.grid, memory, cells);
    if (d.status != CTL_OK) {
        d.field = CTL_ILC_CELLS;
        return d;
    }
    self->params = *params;
    self->state = made;
    return d;
}

void ctl_ilc_reset(ctl_ilc_t *self, bool keep)
{
    if (!keep) {
        ctl_grid_clear(&self->state.grid);
    }
    self->state.known = 0U;
    self->state.primed = false;
}

static void learn(ctl_ilc_t *self, angle_t angle, num_t err)
{
    ctl_ilc_state_t *const s = &self->state;
    const num_t            limit = self->params.limit;
    if (s->primed && (((angle - s->at) + ANGLE_QUARTER) < (2U * ANGLE_QUARTER))) {
        ctl_grid_walk_t walk = ctl_grid_walk(&s->grid, s->at, s->err, angle, err);
        uint16_t        i = 0U;
        num_t           e = (num_t)0;
        while (ctl_grid_walk_next(&walk, &i, &e)) {
            s->grid.cell[i] = num_clamp(num_mac(s->grid.cell[i], self->params.gain, e), num_neg(limit), limit);
        }
    }
    s->at = angle;
    s->err = err;
    s->primed = true;
}

num_t ctl_ilc_step(ctl_ilc_t *self, angle_t theta, num_t err)
{
    ctl_ilc_state_t *const s = &self->state;

    s->head = (uint16_t)((s->head + 1U) & CTL_ILC_LEAD_MAX);
    s->past[s->head] = theta;
    if (s->known <= CTL_ILC_LEAD_MAX) {
        s->known++;
    }
    if (!num_is_finite(err)) {
        num_count(&s->rejected);
        s->primed = false;
    } else if (s->known > self->params.lead) {
        learn(self, s->past[(s->head - self->params.lead) & CTL_ILC_LEAD_MAX], err);
    } else {
        /* too early: the cause of this error lies before the start */
    }
    return ctl_grid_read_linear(&s->grid, theta);
}
