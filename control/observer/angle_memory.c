#include "control/observer/angle_memory.h"

#define HAT_MIN_WEIGHT NUM_C(0.25f) /* less nearness than this is not an average: the straight line is better */
#define HAT_MAX_WEIGHT NUM_C(64.0f)
#define HAT_MAX_SUM (NUM_MAX / 2)

static const ctl_hat_t NO_HAT = {(num_t)0, (num_t)0, false};

ctl_diag_t ctl_angle_memory_check(const ctl_angle_memory_params_t *params)
{
    ctl_diag_t d = ctl_diag_range(params->gain, NUM_EPS, NUM_C(1.0f), CTL_AM_GAIN);
    ctl_diag_also(&d, params->forgetting, (num_t)0, NUM_C(1.0f), CTL_AM_FORGETTING);
    if ((d.status == CTL_OK) && ((uint16_t)params->write > (uint16_t)CTL_WRITE_HAT)) {
        d = ctl_diag_count(CTL_ERR_RANGE, CTL_AM_WRITE, (uint16_t)params->write);
    }
    if ((d.status == CTL_OK) && ((uint16_t)params->read > (uint16_t)CTL_READ_CUBIC)) {
        d = ctl_diag_count(CTL_ERR_RANGE, CTL_AM_READ, (uint16_t)params->read);
    }
    ctl_diag_also(&d, params->limit, NUM_EPS, NUM_MAX, CTL_AM_LIMIT);
    return d;
}

ctl_diag_t ctl_angle_memory_init(ctl_angle_memory_t *self, const ctl_angle_memory_params_t *params, num_t *memory, uint16_t cells)
{
    if ((self == NULL) || (params == NULL)) {
        return ctl_diag(CTL_ERR_NULL, 0U, (num_t)0);
    }
    ctl_diag_t d = ctl_angle_memory_check(params);
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
    self->state.innovation = (num_t)0;
    self->state.change = (num_t)0;
}

void ctl_angle_memory_skip(ctl_angle_memory_t *self, angle_t angle, num_t v)
{
    ctl_angle_memory_state_t *const s = &self->state;
    ctl_angle_memory_pause(self);
    if (self->params.write == CTL_WRITE_ONE) {
        s->primed = true;
        s->at = angle;
        s->position = ctl_grid_position(&s->grid, angle);
        s->value = v;
    }
}

void ctl_angle_memory_update_quality(ctl_angle_memory_t *self)
{
    ctl_angle_memory_state_t *const s = &self->state;
    s->change = num_mac(s->change, NUM_C(0.01f), num_sub(num_abs(s->innovation), s->change));
}

void ctl_angle_memory_pause(ctl_angle_memory_t *self)
{
    self->state.primed = false;
    self->state.below = NO_HAT;
    self->state.above = NO_HAT;
}

/* Inline, as the three below: the current interrupt, once a sample or once a point. */
static inline void gather_one(ctl_hat_t *hat, num_t nearness, num_t v)
{
    hat->sum = num_mac(hat->sum, nearness, v);
    hat->weight = num_add(hat->weight, nearness);
    if ((hat->weight > HAT_MAX_WEIGHT) || (num_abs(hat->sum) > HAT_MAX_SUM)) { /* standing still: keep sums in range */
        hat->sum = num_mul(hat->sum, NUM_C(0.5f));
        hat->weight = num_mul(hat->weight, NUM_C(0.5f));
    }
}

/* Add a sample to the hats of its two neighbours. */
static inline void gather(ctl_angle_memory_state_t *s, num_t part, num_t v)
{
    gather_one(&s->below, num_sub(NUM_C(1.0f), part), v);
    gather_one(&s->above, part, v);
}

/* The motion passes the point of @p hat. Where hardly a sample came near, the line between two of them stands for it. */
static inline void pass(ctl_hat_t *hat, num_t line)
{
    if (hat->weight < HAT_MIN_WEIGHT) {
        hat->sum = num_mac(hat->sum, HAT_MIN_WEIGHT, line);
        hat->weight = num_add(hat->weight, HAT_MIN_WEIGHT);
    }
    hat->passed = true;
}

/* From cell `before` to cell `now`: what is left behind is complete, what was passed in between, too, but for the last
 * point. A point beside the travel that was not passed (a reversal, a start) is forgotten. */
static void change_cell(ctl_angle_memory_t *self, uint16_t before, uint16_t now, ctl_grid_walk_t walk, num_t gain)
{
    ctl_angle_memory_state_t *const s = &self->state;
    const ctl_grid_t *const         grid = &s->grid;
    const bool                      up = walk.up;
    const ctl_hat_t *const          behind = up ? &s->below : &s->above;
    ctl_hat_t                       hat = up ? s->above : s->below;
    uint16_t                        i = up ? ctl_grid_next(grid, before) : before;
    num_t                           line = s->value;

    if (behind->passed) {
        ctl_angle_memory_learn(self, up ? before : ctl_grid_next(grid, before), num_div(behind->sum, behind->weight), gain);
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
        ctl_angle_memory_learn(self, i, num_div(hat.sum, hat.weight), gain);
        hat = NO_HAT;
        (void)ctl_grid_walk_next(&walk, &i, &line);
        pass(&hat, line);
    }
    s->below = up ? hat : NO_HAT;
    s->above = up ? NO_HAT : hat;
}

static inline void write_hat(ctl_angle_memory_t *self, angle_t angle, ctl_grid_position_t now, num_t v, num_t gain)
{
    ctl_angle_memory_state_t *const s = &self->state;
    if (now.below != s->position.below) {
        change_cell(self, s->position.below, now.below, ctl_grid_walk(&s->grid, s->at, s->value, angle, v), gain);
    }
    gather(s, angle_to_turns(now.inside), v);
}

static void write_all(ctl_angle_memory_t *self, angle_t angle, num_t v, num_t gain)
{
    ctl_grid_walk_t walk = ctl_grid_walk(&self->state.grid, self->state.at, self->state.value, angle, v);
    uint16_t        i = 0U;
    num_t           line = (num_t)0;
    while (ctl_grid_walk_next(&walk, &i, &line)) {
        ctl_angle_memory_learn(self, i, line, gain);
    }
}

void ctl_angle_memory_write_general(ctl_angle_memory_t *self, angle_t angle, ctl_grid_position_t now, num_t v, num_t gain)
{
    ctl_angle_memory_state_t *const s = &self->state;
    if (!s->primed) {
        s->primed = true;
        if (self->params.write == CTL_WRITE_HAT) {
            gather(s, angle_to_turns(now.inside), v);
        }
    } else if (self->params.write == CTL_WRITE_ALL) {
        write_all(self, angle, v, gain);
    } else {
        write_hat(self, angle, now, v, gain);
    }
}

void ctl_angle_memory_write(ctl_angle_memory_t *self, angle_t angle, num_t v, num_t gain)
{
    ctl_angle_memory_state_t *const s = &self->state;
    if (!num_is_finite(v) || !num_is_finite(gain)) {
        num_count(&s->rejected);
        return;
    }
    if (s->primed && (angle_size(angle - s->at) >= ANGLE_QUARTER)) {
        num_count(&s->rejected); /* a jump: its direction is not known */
        ctl_angle_memory_pause(self);
    }
    ctl_angle_memory_write_unchecked(self, angle, v, num_clamp(gain, (num_t)0, NUM_C(1.0f)));
}
