#include "control/observer/angle_memory.h"

#define HAT_MIN_WEIGHT NUM_C(0.25f) /* less nearness than this is not an average: the straight line is better */
#define CHANGE_GAIN NUM_C(0.01f)    /* the quality figure looks back over some hundred points */

ctl_diag_t ctl_angle_memory_init(ctl_angle_memory_t *self, const ctl_angle_memory_params_t *params, num_t *memory, uint16_t cells)
{
    if ((self == NULL) || (params == NULL)) {
        return ctl_diag(CTL_ERR_NULL, 0U, (num_t)0);
    }
    ctl_diag_t d = ctl_diag_range(params->gain, NUM_EPS, NUM_C(1.0f), CTL_AM_GAIN);
    if (d.status == CTL_OK) {
        d = ctl_diag_range(params->forgetting, (num_t)0, NUM_C(1.0f), CTL_AM_FORGETTING);
    }
    if ((d.status == CTL_OK) && ((uint16_t)params->write > (uint16_t)CTL_WRITE_HAT)) {
        d = ctl_diag_count(CTL_ERR_RANGE, CTL_AM_WRITE, (uint16_t)params->write);
    }
    if ((d.status == CTL_OK) && ((uint16_t)params->read > (uint16_t)CTL_READ_CUBIC)) {
        d = ctl_diag_count(CTL_ERR_RANGE, CTL_AM_READ, (uint16_t)params->read);
    }
    if (d.status == CTL_OK) {
        d = ctl_diag_range(params->limit, NUM_EPS, NUM_MAX, CTL_AM_LIMIT);
    }
    if (d.status != CTL_OK) {
        return d;
    }
    ctl_grid_t grid;
    d = ctl_grid_init(&grid, memory, cells);
    if (d.status != CTL_OK) {
        d.field = CTL_AM_CELLS;
        return d;
    }
    const ctl_angle_memory_state_t rest = {.grid = grid};
    self->params = *params;
    self->state = rest;
    return d;
}

void ctl_angle_memory_clear(ctl_angle_memory_t *self)
{
    ctl_grid_clear(&self->state.grid);
    ctl_angle_memory_pause(self);
    self->state.written = 0U;
    self->state.change = (num_t)0;
}

void ctl_angle_memory_pause(ctl_angle_memory_t *self)
{
    const ctl_hat_t none = {(num_t)0, (num_t)0};
    self->state.primed = false;
    self->state.below = none;
    self->state.above = none;
}

/* (1) */
static void learn(ctl_angle_memory_t *self, uint16_t i, num_t v, num_t gain)
{
    const ctl_angle_memory_params_t *const p = &self->params;
    ctl_angle_memory_state_t *const        s = &self->state;
    const num_t                            m = s->grid.cell[i];
    const num_t                            news = num_sub(v, m);

    s->grid.cell[i] = num_clamp(num_mac(num_mul(p->forgetting, m), gain, news), num_neg(p->limit), p->limit);
    s->change = num_mac(s->change, CHANGE_GAIN, num_sub(num_abs(news), s->change));
    num_count(&s->written);
}

static num_t within_cell(uint64_t position)
{
#ifdef EVENSPIN_FIXED
    return (num_t)((uint32_t)position >> 8);
#else
    return (num_t)(uint32_t)position * 2.3283064365386963e-10f; /* 2^-32 */
#endif
}

/* Add a sample to the hats of its two neighbours. */
static void gather(ctl_angle_memory_state_t *s, num_t part, num_t v)
{
    const num_t rest = num_sub(NUM_C(1.0f), part);
    s->below.sum = num_mac(s->below.sum, rest, v);
    s->below.weight = num_add(s->below.weight, rest);
    s->above.sum = num_mac(s->above.sum, part, v);
    s->above.weight = num_add(s->above.weight, part);
    if (s->below.weight > NUM_C(64.0f) || s->above.weight > NUM_C(64.0f)) { /* standing still: keep sums in range */
        s->below.sum = num_mul(s->below.sum, NUM_C(0.5f));
        s->below.weight = num_mul(s->below.weight, NUM_C(0.5f));
        s->above.sum = num_mul(s->above.sum, NUM_C(0.5f));
        s->above.weight = num_mul(s->above.weight, NUM_C(0.5f));
    }
}

static num_t average(const ctl_hat_t *hat, num_t otherwise)
{
    return (hat->weight >= HAT_MIN_WEIGHT) ? num_div(hat->sum, hat->weight) : otherwise;
}

/* All samples of this call's cell count for both neighbours: a point is complete when the next cell is left, too. */
static void write_hat(ctl_angle_memory_t *self, angle_t angle, num_t v, num_t gain)
{
    ctl_angle_memory_state_t *const s = &self->state;
    const uint64_t                  position = (uint64_t)angle * s->grid.cells;
    const uint16_t                  now = (uint16_t)(position >> 32);
    const uint16_t                  before = (uint16_t)(((uint64_t)s->at * s->grid.cells) >> 32);
    const ctl_hat_t                 none = {(num_t)0, (num_t)0};

    if (now != before) {
        ctl_grid_walk_t walk = ctl_grid_walk(&s->grid, s->at, s->value, angle, v);
        const bool      up = (int32_t)(angle - s->at) >= 0;
        const uint16_t  passed = walk.left;
        uint16_t        i = 0U;
        num_t           line = (num_t)0;
        /* the point behind is complete: no later sample lies beside it */
        const uint16_t behind = up ? before : (uint16_t)(((before + 1U) < s->grid.cells) ? (before + 1U) : 0U);
        const ctl_hat_t *const done = up ? &s->below : &s->above;
        if (done->weight >= HAT_MIN_WEIGHT) {
            learn(self, behind, num_div(done->sum, done->weight), gain);
        }
        /* the first point passed keeps its hat: this cell's samples lie on its other side */
        ctl_hat_t carried = up ? s->above : s->below;
        if (passed > 1U) { /* more than a cell in one sample: complete, all but the last */
            (void)ctl_grid_walk_next(&walk, &i, &line);
            learn(self, i, average(&carried, line), gain);
            for (uint16_t n = 2U; (n < passed) && ctl_grid_walk_next(&walk, &i, &line); n++) {
                learn(self, i, line, gain);
            }
            (void)ctl_grid_walk_next(&walk, &i, &line);
            carried.sum = num_mul(line, HAT_MIN_WEIGHT); /* the line stands for samples that there are not */
            carried.weight = HAT_MIN_WEIGHT;
        }
        s->below = up ? carried : none;
        s->above = up ? none : carried;
    }
    gather(s, within_cell(position), v);
}

static void write_line(ctl_angle_memory_t *self, angle_t angle, num_t v, num_t gain)
{
    ctl_grid_walk_t walk = ctl_grid_walk(&self->state.grid, self->state.at, self->state.value, angle, v);
    uint16_t        i = 0U;
    num_t           line = (num_t)0;
    while (ctl_grid_walk_next(&walk, &i, &line)) {
        if ((self->params.write == CTL_WRITE_ALL) || (walk.left == 0U)) {
            learn(self, i, line, gain);
        }
    }
}

void ctl_angle_memory_write(ctl_angle_memory_t *self, angle_t angle, num_t v, num_t gain)
{
    ctl_angle_memory_state_t *const s = &self->state;
    if (!num_is_finite(v) || !num_is_finite(gain)) {
        num_count(&s->rejected);
        return;
    }
    const num_t g = num_clamp(gain, (num_t)0, NUM_C(1.0f));
    if (s->primed && (((angle - s->at) + ANGLE_QUARTER) >= (2U * ANGLE_QUARTER))) {
        num_count(&s->rejected); /* a jump: nobody knows which way */
        ctl_angle_memory_pause(self);
    }
    if (!s->primed) {
        s->primed = true;
        s->at = angle;
        s->value = v;
        if (self->params.write == CTL_WRITE_HAT) {
            gather(s, within_cell((uint64_t)angle * s->grid.cells), v);
        }
        return;
    }
    if (self->params.write == CTL_WRITE_HAT) {
        write_hat(self, angle, v, g);
    } else {
        write_line(self, angle, v, g);
    }
    s->at = angle;
    s->value = v;
}

num_t ctl_angle_memory_read(const ctl_angle_memory_t *self, angle_t angle)
{
    return (self->params.read == CTL_READ_CUBIC) ? ctl_grid_read_cubic(&self->state.grid, angle)
                                                 : ctl_grid_read_linear(&self->state.grid, angle);
}
