#include "control/position/src.h"

#define SQRT2 NUM_C(1.41421356f)

ctl_diag_t ctl_src_init(ctl_src_t *self, const ctl_src_params_t *params, num_t *memory, uint16_t cells)
{
    if ((self == NULL) || (params == NULL)) {
        return ctl_diag(CTL_ERR_NULL, 0U, (num_t)0);
    }
    ctl_diag_t d = ctl_diag_range(params->omega_half_ts, NUM_EPS, NUM_MAX, CTL_SRC_OMEGA);
    if ((d.status == CTL_OK) && (params->lambda == 0U)) {
        d = ctl_diag(CTL_ERR_RANGE, CTL_SRC_LAMBDA, (num_t)0);
    }
    ctl_diag_also(&d, params->limit, NUM_EPS, NUM_MAX, CTL_SRC_LIMIT);
    if (d.status != CTL_OK) {
        return d;
    }
    ctl_src_state_t made = {0};
    d = ctl_grid_init(&made.grid, memory, cells);
    if (d.status != CTL_OK) {
        d.field = CTL_SRC_CELLS;
        return d;
    }
    self->params = *params;
    self->state = made;
    return d;
}

void ctl_src_reset(ctl_src_t *self)
{
    const ctl_grid_t grid = self->state.grid;
    const uint32_t   rejected = self->state.rejected;
    ctl_src_state_t  rest = {0};
    rest.grid = grid;
    rest.rejected = rejected;
    self->state = rest;
    ctl_grid_clear(&self->state.grid);
}

static num_t cut(num_t k) { return (k > (num_t)0) ? num_min(k, NUM_C(1.0f)) : (num_t)0; }

ctl_src_filter_t ctl_src_filter(num_t k)
{
    const num_t            k1 = cut(k);
    const num_t            k2 = num_mul(k1, k1);
    const num_t            root = num_mul(SQRT2, k1);
    const num_t            inverse = num_div(NUM_C(1.0f), num_add(num_add(NUM_C(1.0f), root), k2));
    const num_t            two = num_mul(num_sub(k2, NUM_C(1.0f)), inverse);
    const ctl_src_filter_t f = {num_mul(k2, inverse), num_add(two, two),
                                num_mul(num_add(num_sub(NUM_C(1.0f), root), k2), inverse)};
    return f;
}

/* (3) from the last sample to this one: both equations with the means of their right sides, solved for the new u. */
static num_t low_pass(ctl_src_state_t *s, num_t k, num_t x, num_t limit)
{
    const num_t drag = num_mul(k, num_add(SQRT2, k));
    const num_t push = num_mul(k, num_sub(num_add(s->x, x), num_add(s->y, s->y)));
    const num_t u = num_div(num_mac(push, num_sub(NUM_C(1.0f), drag), s->u), num_add(NUM_C(1.0f), drag));
    s->y = num_clamp(num_mac(s->y, k, num_add(s->u, u)), num_neg(limit), limit);
    s->u = u;
    s->x = x;
    return s->y;
}

static void store(ctl_src_t *self, angle_t theta, num_t w)
{
    ctl_src_state_t *const s = &self->state;
    if (s->primed && (((theta - s->at) + ANGLE_QUARTER) < (2U * ANGLE_QUARTER))) {
        ctl_grid_walk_t walk = ctl_grid_walk(&s->grid, s->at, s->written, theta, w);
        uint16_t        i = 0U;
        num_t           v = (num_t)0;
        while (ctl_grid_walk_next(&walk, &i, &v)) {
            s->grid.cell[i] = v;
        }
    }
    s->at = theta;
    s->written = w;
    s->primed = true;
}

num_t ctl_src_step(ctl_src_t *self, angle_t theta, num_t speed, num_t err)
{
    ctl_src_state_t *const s = &self->state;
    const num_t            limit = self->params.limit;
    const num_t            e = num_guard(err, (num_t)0, &s->rejected);
    const num_t            w = num_guard(speed, (num_t)0, &s->rejected);
    const angle_t          then = (w < (num_t)0) ? (theta + self->params.lambda) : (theta - self->params.lambda);
    const num_t            k = cut(num_mul(self->params.omega_half_ts, num_abs(w)));

    const num_t x = ctl_grid_read_linear(&s->grid, then);
    const num_t y = low_pass(s, k, x, limit);
    if (self->params.hold) {
        s->primed = false;
        return y;
    }
    store(self, theta, num_clamp(num_add(y, e), num_neg(num_add(limit, limit)), num_add(limit, limit)));
    return y;
}
