#include "control/observer/observer.h"

#define SLOW_GAIN NUM_C(0.01f)    /* low-pass of the speed: 100 samples */
#define QUALITY_GAIN NUM_C(0.01f) /* low-pass of the quality figure: 100 calls */

/* ---- configuration ------------------------------------------------------------------------------------------------ */

ctl_diag_t ctl_observer_check(const ctl_observer_params_t *p)
{
    const ctl_angle_memory_params_t *const m = &p->memory;
    ctl_diag_t                             d = ctl_diag_ok();
    if ((uint16_t)p->kind > (uint16_t)CTL_OBSERVER_ARO) {
        d = ctl_diag_count(CTL_ERR_RANGE, CTL_OBSERVER_KIND, (uint16_t)p->kind);
    }
    ctl_diag_also(&d, m->gain, NUM_EPS, NUM_C(1.0f), CTL_OBSERVER_GAIN);
    ctl_diag_also(&d, m->forgetting, (num_t)0, NUM_C(1.0f), CTL_OBSERVER_FORGETTING);
    ctl_diag_also(&d, m->limit, NUM_EPS, NUM_MAX, CTL_OBSERVER_LIMIT);
    if ((d.status == CTL_OK) && (p->age_half > (2U * CTL_ARO_AGE_MAX))) {
        d = ctl_diag_count(CTL_ERR_RANGE, CTL_OBSERVER_AGE, p->age_half);
    }
    ctl_diag_also(&d, p->ahead, (num_t)0, NUM_C(12.0f), CTL_OBSERVER_AHEAD);
    ctl_diag_also(&d, p->rad_per_64, NUM_EPS, NUM_MAX, CTL_OBSERVER_RAD);
    ctl_diag_also(&d, p->fast_gain, NUM_EPS, NUM_C(1.0f), CTL_OBSERVER_FAST_GAIN);
    ctl_diag_also(&d, p->rest_torque, (num_t)0, NUM_MAX, CTL_OBSERVER_REST);
    ctl_diag_also(&d, p->rest_turns, (num_t)0, NUM_C(100.0f), CTL_OBSERVER_REST);
    ctl_diag_also(&d, p->rest_step, (num_t)0, NUM_MAX, CTL_OBSERVER_REST);
    ctl_diag_also(&d, p->sync_band, (num_t)0, NUM_C(0.5f), CTL_OBSERVER_SYNC);
    if ((d.status == CTL_OK) && (p->kind == CTL_OBSERVER_ARO)) {
        d = ctl_angle_memory_check(m);
        d.field = (d.status == CTL_OK) ? 0U : (uint16_t)CTL_OBSERVER_MEMORY;
    }
    return d;
}

ctl_diag_t ctl_observer_init(ctl_observer_t *self, const ctl_observer_params_t *params, num_t *memory, uint16_t capacity)
{
    if ((self == NULL) || (params == NULL)) {
        return ctl_diag(CTL_ERR_NULL, 0U, (num_t)0);
    }
    static const ctl_observer_state_t REST = {0}; /* not on the stack of the chip */
    ctl_grid_t                        grid = {0};
    ctl_ring_t                        time = {0};
    ctl_diag_t                        d = ctl_observer_check(params);
    if ((d.status == CTL_OK) && (params->kind == CTL_OBSERVER_ARO)) {
        d = ctl_grid_init(&grid, memory, capacity);
        d.field = (d.status == CTL_OK) ? 0U : (uint16_t)CTL_OBSERVER_MEMORY;
    }
    if ((d.status == CTL_OK) && (params->kind == CTL_OBSERVER_RO)) {
        d = (capacity < (CTL_ARO_AGE_MAX + 33U)) ? ctl_diag_count(CTL_ERR_MEMORY, CTL_OBSERVER_MEMORY, capacity)
                                                 : ctl_ring_init(&time, memory, capacity);
        d.field = (d.status == CTL_OK) ? 0U : (uint16_t)CTL_OBSERVER_MEMORY;
    }
    if (d.status == CTL_OK) {
        self->state = REST;
        self->state.memory.state.grid = grid;
        self->state.time = time;
        self->state.turn_samples = UINT16_MAX;
        self->state.wait = CTL_OBSERVER_WAIT;
        ctl_observer_tune(self, params);
    }
    return d;
}

void ctl_observer_prepare(ctl_observer_t *self, const ctl_observer_params_t *params)
{
    ctl_observer_derived_t *const made = &self->prepared;
    made->watches = params->remove_mean || (params->rest_torque > (num_t)0) || (params->rest_step > (num_t)0);
    made->plain = (params->kind == CTL_OBSERVER_ARO) && (params->memory.write == CTL_WRITE_ONE) &&
                  (params->memory.read == CTL_READ_LINEAR) && !made->watches && !params->feeds;
    made->ahead_per_speed = num_mul(num_mul(params->rad_per_64, NUM_C(0.015625f)), params->ahead);
    made->age = (uint16_t)(params->age_half >> 1);
    made->half = ((params->age_half & 1U) != 0U) ? UINT32_MAX : 0U;
}

void ctl_observer_tune(ctl_observer_t *self, const ctl_observer_params_t *params)
{
    ctl_observer_prepare(self, params);
    ctl_observer_take_prepared(self, params);
}

void ctl_observer_reset(ctl_observer_t *self, bool keep)
{
    ctl_observer_state_t *const s = &self->state;
    if (self->params.kind == CTL_OBSERVER_ARO) {
        if (keep) {
            ctl_angle_memory_pause(&s->memory);
        } else {
            ctl_angle_memory_clear(&s->memory);
        }
    } else if (self->params.kind == CTL_OBSERVER_RO) {
        ctl_ring_clear(&s->time); /* time goes on: what was learned does not survive a pause */
    } else {
        s->estimate = (num_t)0;
    }
    s->wait = CTL_OBSERVER_WAIT;
    s->ready = false;
    s->samples = keep ? s->samples : 0U;
    s->seen = (num_t)0;
    s->turn_sum = (num_t)0;
    s->turn_travel = (num_t)0;
    s->mean_known = false;
    s->mean_turns = 0U;
    s->rest_travel = (num_t)0;
    s->rest_left = 0U;
    s->speed_known = (num_t)0;
    s->speed_slow = (num_t)0;
    s->step_slow = (num_t)0;
    s->turn_samples = UINT16_MAX;
    s->rounding = 0U;
    s->kept_rounding = 0U;
    s->synchronous = false;
    s->drifting = false;
    ctl_kept_order_clear(&s->kept);
}

void ctl_observer_update_quality(ctl_observer_t *self)
{
    ctl_observer_state_t *const s = &self->state;
    if (s->memory.state.primed && (s->wait == 0U) && !s->held && !s->synchronous) { /* else nothing is learned */
        s->seen = num_mac(s->seen, QUALITY_GAIN, num_sub(num_abs(s->memory.state.value), s->seen));
        ctl_angle_memory_update_quality(&s->memory);
    }
}

num_t ctl_observer_innovation_ratio(const ctl_observer_t *self)
{
    const ctl_observer_state_t *const s = &self->state;
    if ((self->params.kind != CTL_OBSERVER_ARO) || !(s->seen > (num_t)0)) {
        return NUM_C(1.0f);
    }
    return num_min(num_div(s->memory.state.change, s->seen), NUM_C(1.0f));
}

/* ---- one sample ------------------------------------------------------------------------------------------------------ */

/* Speed and its change, low-passed. */
static void watch_speed(ctl_observer_state_t *s, num_t speed)
{
    const num_t change = num_mul(SLOW_GAIN, num_sub(speed, s->speed_slow));
    s->speed_slow = num_add(s->speed_slow, change);
    s->step_slow = num_mac(s->step_slow, SLOW_GAIN, num_sub(change, s->step_slow));
}

/* The mean over one turn of angle, from turn to turn, of the last turns. */
static void watch_mean(ctl_observer_state_t *s, num_t torque, num_t travel)
{
    s->turn_sum = num_mac(s->turn_sum, torque, travel);
    s->turn_travel = num_add(s->turn_travel, travel);
    if (s->turn_travel >= NUM_C(1.0f)) {
        const num_t mean = num_quotient(s->turn_sum, s->turn_travel);
        if (!s->drifts) { /* no rounding to be averaged out: the last turn alone, which follows a load at once */
            s->mean_turns = 0U;
        }
        s->mean_turns = (uint16_t)(s->mean_turns + ((s->mean_turns < CTL_OBSERVER_MEAN_TURNS) ? 1U : 0U));
        s->mean = (s->mean_turns > 1U)
                      ? num_add(s->mean, num_quotient(num_sub(mean, s->mean), num_from_int((int16_t)s->mean_turns)))
                      : mean;
        s->mean_known = true;
        s->turn_sum = (num_t)0;
        s->turn_travel = (num_t)0;
    }
}

/* Whether learning pauses in this sample; counts the pause down. */
static bool rests(ctl_observer_t *self, num_t torque, num_t travel)
{
    const ctl_observer_params_t *const p = &self->params;
    ctl_observer_state_t *const        s = &self->state;

    if ((p->rest_torque > (num_t)0) && s->mean_known && (s->rest_travel <= (num_t)0) &&
        (num_abs(num_sub(torque, s->mean)) > p->rest_torque)) {
        s->rest_travel = p->rest_turns;
        s->turn_sum = (num_t)0; /* the old mean is void: begin a new turn here, which replaces it */
        s->turn_travel = (num_t)0;
        s->mean_turns = 0U;
    }
    bool rest = s->rest_travel > (num_t)0;
    if (rest) {
        s->rest_travel = num_sub(s->rest_travel, travel);
    }
    if ((p->rest_step > (num_t)0) && (num_abs(s->step_slow) > p->rest_step)) {
        s->rest_left = p->rest_samples;
    }
    if (s->rest_left > 0U) {
        s->rest_left--;
        rest = true;
    }
    return rest;
}

/* Monitors that the options need. @return whether the options let this sample be learned. */
static bool watch(ctl_observer_t *self, num_t torque, num_t speed, num_t travel)
{
    const ctl_observer_state_t *const s = &self->state;
    watch_speed(&self->state, speed);
    const bool can = (!rests(self, torque, travel)) & ((!self->params.remove_mean) | s->mean_known);
    watch_mean(&self->state, torque, travel);
    return can;
}

static num_t read_time(const ctl_observer_t *self)
{
    const ctl_observer_params_t *const p = &self->params;
    const ctl_observer_state_t *const  s = &self->state;
    /* newest entry: k - age; wanted: k + ahead - N; so N - age - ahead entries before the newest, in half samples */
    const num_t    lag = num_mac(p->ahead, NUM_C(0.5f), num_from_int((int16_t)p->age_half));
    const uint16_t lag_up = (uint16_t)(num_floor(lag) + 1);
    const num_t    part = num_sub(num_from_int((int16_t)lag_up), lag); /* (0, 1] */
    if ((s->turn_samples < lag_up) || (s->turn_samples >= (s->time.capacity - 2U))) {
        return (num_t)0; /* a turn shorter than the delay, or longer than the memory */
    }
    const uint16_t at = (uint16_t)(s->turn_samples - lag_up);
    const num_t    newer = ctl_ring_get(&s->time, at);
    return num_mac(newer, part, num_sub(ctl_ring_get(&s->time, (uint16_t)(at + 1U)), newer));
}

/* What is not learned stays as it was a turn ago. */
static void learn_time(ctl_observer_t *self, num_t torque, num_t gain, bool learn)
{
    const ctl_angle_memory_params_t *const m = &self->params.memory;
    ctl_observer_state_t *const            s = &self->state;
    /* one turn before the entry that is pushed now */
    const num_t old = (s->turn_samples <= s->time.capacity) ? ctl_ring_get(&s->time, (uint16_t)(s->turn_samples - 1U)) : (num_t)0;
    const num_t x = learn ? num_mac(num_mul(m->forgetting, old), gain, num_sub(torque, old)) : old;
    ctl_ring_push(&s->time, num_clamp(x, num_neg(m->limit), m->limit));
}

num_t ctl_observer_step_unchecked(ctl_observer_t *self, angle_t theta, num_t w, num_t t)
{
    const ctl_observer_params_t *const p = &self->params;
    ctl_observer_state_t *const        s = &self->state;
    const num_t                        limit = p->memory.limit;
    uint32_t                           turned = (s->wait < CTL_OBSERVER_WAIT) ? angle_size(theta - s->theta) : 0U;

    if (turned >= ANGLE_QUARTER) { /* a jump: halfway between two ages it would appear as two motions */
        num_count(&s->rejected);
        s->wait = CTL_OBSERVER_WAIT;
        turned = 0U;
    }
    const angle_t then = ctl_observer_note_angle(self, theta);
    bool          learn = ctl_observer_may_learn(self);
    num_t         learned = t;
    if (self->derived.watches) {
        learn = watch(self, t, w, angle_to_turns(turned)) & learn;
        learned = p->remove_mean ? num_sub(t, s->mean) : t;
    }
    const num_t gain = (s->samples < p->fast_samples) ? p->fast_gain : p->memory.gain;
    num_count(&s->samples);
    s->ready = self->derived.plain & (s->samples > p->fast_samples);

    num_t out;
    if (p->kind == CTL_OBSERVER_ARO) {
        if (learn) {
            ctl_angle_memory_write_unchecked(&s->memory, then, learned, gain);
        } else {
            ctl_angle_memory_skip(&s->memory, then, learned);
        }
        out = ctl_angle_memory_read(&s->memory, ctl_observer_ahead(self, theta, w));
    } else if (p->kind == CTL_OBSERVER_RO) {
        learn_time(self, learned, gain, learn);
        out = read_time(self);
    } else {
        if (learn) {
            s->estimate = num_clamp(num_mac(num_mul(p->memory.forgetting, s->estimate), gain, num_sub(learned, s->estimate)),
                                    num_neg(limit), limit);
        }
        out = s->estimate;
    }
    return num_clamp(out, num_neg(limit), limit);
}

num_t ctl_observer_step(ctl_observer_t *self, angle_t theta, num_t speed, num_t torque)
{
    ctl_observer_state_t *const s = &self->state;
    const bool                  held = s->held;
    s->held = held || !num_is_finite(speed) || !num_is_finite(torque); /* such a sample is not learned */
    const num_t w = num_guard(speed, s->speed_known, &s->rejected);
    s->speed_known = w;
    const num_t out = ctl_observer_step_unchecked(self, theta, w, num_guard(torque, s->mean, &s->rejected));
    s->held = held;
    return out;
}
