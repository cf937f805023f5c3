#include "control/observer/angle_memory.h"

#define HAT_MIN_WEIGHT NUM_C(0.25f) /* less nearness than this is not an average: the straight line is better */
#define HAT_MAX_WEIGHT NUM_C(64.0f)
#define HAT_MAX_SUM (NUM_MAX / 2)
#define CHANGE_GAIN NUM_C(0.01f)    /* the quality figure looks back over some hundred points */

static const ctl_hat_t NO_HAT = {(num_t)0, (num_t)0, false};

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
    self->state.primed = false;
    self->state.below = NO_HAT;
    self->state.above = NO_HAT;
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

static void gather_one(ctl_hat_t *hat, num_t nearness, num_t v)
{
    hat->sum = num_mac(hat->sum, nearness, v);
    hat->weight = num_add(hat->weight, nearness);
    if ((hat->weight > HAT_MAX_WEIGHT) || (num_abs(hat->sum) > HAT_MAX_SUM)) { /* standing still: keep sums in range */
        hat->sum = num_mul(hat->sum, NUM_C(0.5f));
        hat->weight = num_mul(hat->weight, NUM_C(0.5f));
    }
}

/* Add a sample to the hats of its two neighbours. */
static void gather(ctl_angle_memory_state_t *s, num_t part, num_t v)
{
    gather_one(&s->below, num_sub(NUM_C(1.0f), part), v);
    gather_one(&s->above, part, v);
}

/* The motion passes the point of @p hat. Where hardly a sample came near, the line between two of them stands for it. */
static void pass(ctl_hat_t *hat, num_t line)
{
    if (hat->weight < HAT_MIN_WEIGHT) {
        hat->sum = num_mac(hat->sum, HAT_MIN_WEIGHT, line);
        hat->weight = num_add(hat->weight, HAT_MIN_WEIGHT);
    }
    hat->passed = true;
}

static uint16_t next_point(const ctl_grid_t *grid, uint16_t i) { return (uint16_t)(((i + 1U) < grid->cells) ? (i + 1U) : 0U); }

/* From cell `before` to cell `now`: what is left behind is complete, what was passed on the way, too, but for the last
 * point. A point beside the way that was not passed (a reversal, a start) is forgotten. */
static void change_cell(ctl_angle_memory_t *self, uint16_t before, uint16_t now, ctl_grid_walk_t walk, num_t gain)
{
    ctl_angle_memory_state_t *const s = &self->state;
    const ctl_grid_t *const         grid = &s->grid;
    const bool                      up = walk.up;
    const ctl_hat_t *const          behind = up ? &s->below : &s->above;
    ctl_hat_t                       hat = up ? s->above : s->below;
    uint16_t                        i = up ? next_point(grid, before) : before;
    num_t                           line = s->value;

    if (behind->passed) {
        learn(self, up ? before : next_point(grid, before), num_div(behind->sum, behind->weight), gain);
    }
    /* Downwards from exactly on a point the walk begins at the next one: the first is passed with the last value. Landing
     * exactly on a point from above, the walk ends there, but the cell does not: that point is passed by the next step. */
    const uint16_t first = i;
    uint16_t       left = (uint16_t)(up ? ((now >= before) ? (now - before) : (now + (grid->cells - before)))
                                        : ((before >= now) ? (before - now) : (before + (grid->cells - now))));
    if (walk.index == first) {
        (void)ctl_grid_walk_next(&walk, &i, &line);
    }
    for (pass(&hat, line); left > 1U; left--) {
        learn(self, i, num_div(hat.sum, hat.weight), gain);
        hat = NO_HAT;
        (void)ctl_grid_walk_next(&walk, &i, &line);
        pass(&hat, line);
    }
    s->below = up ? hat : NO_HAT;
    s->above = up ? NO_HAT : hat;
}

static void write_hat(ctl_angle_memory_t *self, angle_t angle, num_t v, num_t gain)
{
    ctl_angle_memory_state_t *const s = &self->state;
    const uint64_t                  position = (uint64_t)angle * s->grid.cells;
    const uint16_t                  now = (uint16_t)(position >> 32);
    const uint16_t                  before = (uint16_t)(((uint64_t)s->at * s->grid.cells) >> 32);

    if (now != before) {
        change_cell(self, before, now, ctl_grid_walk(&s->grid, s->at, s->value, angle, v), gain);
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
    if (s->primed && (((angle - s->at) + (ANGLE_QUARTER - 1U)) > (2U * (ANGLE_QUARTER - 1U)))) {
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
