#include "control/repetitive/repetitive.h"

/* A period this little below a whole number is that number: 60 / (p n T_s) is rounded, too (in fixed point at N = 100
 * to 1e-4), and cutting 99.9999 to 99 would be wrong by a whole sample. */
#define ALMOST_ONE NUM_C(0.9995f)
#define CLEAR_STEP NUM_C(0.0625f)

/* Samples that Q reads beyond its three taps, on either side. */
static inline uint16_t taps_beyond(const ctl_rc_params_t *p) { return (p->q.side2 != (num_t)0) ? 1U : 0U; }

/* ---- configuration ---------------------------------------------------------------------------------------------- */

ctl_diag_t ctl_rc_check(const ctl_rc_params_t *p, uint16_t capacity)
{
    if (p == NULL) {
        return ctl_diag(CTL_ERR_NULL, 0U, (num_t)0);
    }
    ctl_diag_t d = ctl_diag_range(p->gain, (num_t)0, NUM_C(100.0f), CTL_RC_GAIN);
    if ((d.status == CTL_OK) && ((p->lead > CTL_RC_LEAD_MAX) || ((p->memory == CTL_RC_ANGLE) && (p->lead < 2U)))) {
        d = ctl_diag_count(CTL_ERR_RANGE, CTL_RC_LEAD, p->lead);
    }
    if ((d.status == CTL_OK) && !ctl_q_is_bounded(&p->q)) {
        d = ctl_diag(CTL_ERR_RANGE, CTL_RC_Q, p->q.centre);
    }
    if ((d.status == CTL_OK) && (p->order >= CTL_LAGRANGE_TAPS)) {
        d = ctl_diag_count(CTL_ERR_RANGE, CTL_RC_ORDER, p->order);
    }
    if ((d.status == CTL_OK) && ((uint16_t)p->fal_at > (uint16_t)CTL_RC_FAL_OUTPUT)) {
        d = ctl_diag_count(CTL_ERR_RANGE, CTL_RC_FAL_AT, (uint16_t)p->fal_at);
    }
    if ((d.status == CTL_OK) && (p->fal_at != CTL_RC_FAL_NONE)) {
        d = ctl_fal_check(&p->fal);
        if (d.status != CTL_OK) {
            d.field = (d.field == (uint16_t)CTL_FAL_ALPHA) ? (uint16_t)CTL_RC_FAL_ALPHA : (uint16_t)CTL_RC_FAL_DELTA;
        }
    }
    if ((d.status == CTL_OK) && ((uint16_t)p->memory > (uint16_t)CTL_RC_ANGLE)) {
        d = ctl_diag_count(CTL_ERR_RANGE, CTL_RC_MEMORY, (uint16_t)p->memory);
    }
    ctl_diag_also(&d, p->limit, NUM_EPS, NUM_MAX, CTL_RC_LIMIT);
    ctl_diag_also(&d, p->freeze_above, (num_t)0, NUM_MAX, CTL_RC_FREEZE);
    if ((d.status == CTL_OK) && ((uint32_t)capacity < ((uint32_t)p->lead + p->order + 5U + (2U * taps_beyond(p))))) {
        d = ctl_diag_count(CTL_ERR_MEMORY, CTL_RC_CAPACITY, capacity);
    }
    return d;
}

static bool is_fast(const ctl_rc_params_t *p)
{
    return (p->order == 2U) & (p->memory == CTL_RC_KEEP) & (p->lead > 0U) & (p->fal_at != CTL_RC_FAL_OUTPUT) &
           !(p->freeze_above > (num_t)0) & (taps_beyond(p) == 0U);
}

/* Without fal: a linear part without an end. */
static void design(ctl_fal_t *fal, const ctl_rc_params_t *params)
{
    if (params->fal_at != CTL_RC_FAL_NONE) {
        (void)ctl_fal_init(fal, &params->fal);
    } else {
        fal->params.alpha = NUM_C(1.0f);
        fal->params.delta = NUM_MAX;
        fal->slope = NUM_C(1.0f);
    }
}

ctl_diag_t ctl_rc_init(ctl_rc_t *self, const ctl_rc_params_t *params, num_t *memory, uint16_t capacity)
{
    if ((self == NULL) || (params == NULL)) {
        return ctl_diag(CTL_ERR_NULL, 0U, (num_t)0);
    }
    static const ctl_rc_state_t REST = {0}; /* not on the stack of the chip */
    ctl_grid_t                  turn = {0};
    ctl_ring_t                  time = {0};
    ctl_diag_t                  d = ctl_rc_check(params, capacity);
    if (d.status == CTL_OK) {
        d = (params->memory == CTL_RC_ANGLE) ? ctl_grid_init(&turn, memory, capacity) : ctl_ring_init(&time, memory, capacity);
        if (d.status != CTL_OK) {
            d.field = CTL_RC_CAPACITY;
        }
    }
    if (d.status == CTL_OK) {
        self->state = REST;
        self->state.turn = turn;
        self->state.time = time;
        if (params->memory != CTL_RC_ANGLE) {
            ctl_ring_fill_zero(&self->state.time);
        }
        self->ahead = ((params->order > 2U) && (params->memory != CTL_RC_ANGLE)) ? 1U : 0U;
        self->shortest = (uint16_t)(params->lead + 2U + self->ahead + taps_beyond(params));
        self->longest =
            (params->memory == CTL_RC_ANGLE) ? (uint16_t)65534U : (uint16_t)(capacity - params->order - 1U - taps_beyond(params));
#ifndef EVENSPIN_FIXED
        self->too_long = (float)self->longest + 1.0f;
#endif
        self->whole_only = (params->order == 0U) && (params->memory != CTL_RC_ANGLE);
        self->params = *params;
        self->fast = is_fast(params);
        self->fal = &self->table[0];
        self->prepared = false;
        design(&self->table[0], params);
    }
    return d;
}

static ctl_fal_t *idle_table(ctl_rc_t *self) { return (self->fal == &self->table[0]) ? &self->table[1] : &self->table[0]; }

void ctl_rc_prepare(ctl_rc_t *self, const ctl_rc_params_t *params)
{
    design(idle_table(self), params);
    if (self->fast) { /* where no step reads or writes it: a pause from before the fast path is over */
        self->state.frozen = 0U;
    }
    self->prepared = true;
}

void ctl_rc_take_prepared(ctl_rc_t *self, const ctl_rc_params_t *params)
{
    if (self->prepared) {
        self->fal = idle_table(self);
        self->prepared = false;
    }
    self->params = *params;
    if (self->fast) { /* the fast path does not keep them; its order is 2 */
        ctl_lagrange_2_unchecked(self->state.period.fraction, self->state.a);
    }
    self->fast = is_fast(params);
}

void ctl_rc_tune(ctl_rc_t *self, const ctl_rc_params_t *params)
{
    ctl_rc_prepare(self, params);
    ctl_rc_take_prepared(self, params);
}

void ctl_rc_reset(ctl_rc_t *self, bool keep)
{
    ctl_rc_state_t *const s = &self->state;
    if (self->params.memory == CTL_RC_ANGLE) {
        if (!keep) {
            ctl_grid_clear(&s->turn);
        }
    } else {
        ctl_ring_fill_zero(&s->time);
    }
    s->known = 0U;
    s->writing = false;
    s->frozen = 0U;
}

/* ---- one sample --------------------------------------------------------------------------------------------------- */

/* state.period as the delay cannot use it: whole samples only, almost whole, or outside of what the memory holds. */
static void correct_period(ctl_rc_t *self)
{
    const num_t         rounding = (self->whole_only && !self->params.truncate) ? NUM_C(0.5f) : ALMOST_ONE;
    ctl_period_t *const n = &self->state.period;

    if (!((n->fraction >= (num_t)0) && (n->fraction < NUM_C(1.0f)))) {
        n->fraction = (num_t)0;
    }
    if ((n->fraction >= rounding) && (n->whole < UINT16_MAX)) {
        n->whole++;
        n->fraction = (num_t)0;
    }
    if (self->whole_only) {
        n->fraction = (num_t)0;
    }
    if ((n->whole < self->shortest) || (n->whole > self->longest)) {
        n->whole = (n->whole < self->shortest) ? self->shortest : self->longest;
        n->fraction = (num_t)0;
        num_count(&self->state.cut_periods);
    }
}

static inline void set_period(ctl_rc_t *self, uint16_t whole, num_t fraction)
{
    self->state.period.whole = whole;
    self->state.period.fraction = fraction;
    if (!((fraction >= (num_t)0) & (fraction < ALMOST_ONE) & (whole >= self->shortest) & (whole <= self->longest) &
          (!self->whole_only))) {
        correct_period(self);
    }
}

/* a - b in samples, where they are close; else just more than that */
static num_t period_step(ctl_period_t a, ctl_period_t b)
{
    const int32_t whole = (int32_t)a.whole - (int32_t)b.whole;
    return num_add(num_from_int((int16_t)((whole > 2) ? 2 : ((whole < -2) ? -2 : whole))), num_sub(a.fraction, b.fraction));
}

static inline void take_period(ctl_rc_t *self, uint16_t whole, num_t fraction)
{
    ctl_rc_state_t *const s = &self->state;
    const ctl_period_t    before = s->period;
    set_period(self, whole, fraction);
    if ((before.whole == s->period.whole) && (before.fraction == s->period.fraction)) {
        return;
    }
    if ((self->params.memory == CTL_RC_CLEAR) && (num_abs(period_step(s->period, before)) > CLEAR_STEP)) {
        ctl_ring_clear(&s->time);
    }
    ctl_lagrange(self->params.order, num_add(s->period.fraction, num_from_int((int16_t)self->ahead)), s->a);
}

/* Whether learning pauses in this sample. */
static bool rests(ctl_rc_t *self, num_t e)
{
    const ctl_rc_params_t *const p = &self->params;
    ctl_rc_state_t *const        s = &self->state;

    if ((p->freeze_above > (num_t)0) && (num_abs(e) > p->freeze_above)) {
        s->frozen = p->freeze_samples;
        return true;
    }
    if (s->frozen > 0U) {
        s->frozen--;
        return true;
    }
    return false;
}

/* What is learned from this sample: k_rc f(e), or nothing while learning pauses. Inline: every sample; one branch for what can pause. */
static inline num_t learned_now(ctl_rc_t *self, num_t e)
{
    const ctl_rc_params_t *const p = &self->params;

    if (((p->freeze_above > (num_t)0) | (self->state.frozen > 0U)) && rests(self, e)) {
        return (num_t)0;
    }
    return num_mul(p->gain, (p->fal_at == CTL_RC_FAL_INPUT) ? ctl_fal_unchecked(self->fal, e) : e);
}

/* Q(z) of the Lagrange sum: the sum of the middle, and of its neighbours on both sides, of x[0..4], newest first. */
static inline num_t filtered(const ctl_q_t *q, const num_t a[CTL_LAGRANGE_TAPS], const num_t x[CTL_LAGRANGE_TAPS + 1U])
{
    const num_t here = num_mac(num_mac(num_mul(a[0], x[1]), a[1], x[2]), a[2], x[3]);
    const num_t beside =
        num_mac(num_mac(num_mul(a[0], num_add(x[0], x[2])), a[1], num_add(x[1], x[3])), a[2], num_add(x[2], x[4]));
    return num_mac(num_mul(q->centre, here), q->side, beside);
}

/* D of (1) from ring delay d on. */
static num_t delayed(const ctl_rc_t *self, uint16_t d)
{
    const ctl_rc_state_t *const s = &self->state;
    num_t                       sum = (num_t)0;
    for (uint16_t j = 0U; j <= self->params.order; j++) {
        sum = num_mac(sum, s->a[j], ctl_ring_get(&s->time, (uint16_t)(d + j)));
    }
    return sum;
}

/* Q D, the newest sample of three taps at ring delay d. */
static num_t read_period(const ctl_rc_t *self, uint16_t d)
{
    const ctl_q_t *const q = &self->params.q;
    const num_t y = ctl_q_apply(q, delayed(self, d), delayed(self, (uint16_t)(d + 1U)), delayed(self, (uint16_t)(d + 2U)));
    if (q->side2 == (num_t)0) {
        return y;
    }
    return num_mac(y, q->side2, num_add(delayed(self, (uint16_t)(d - 1U)), delayed(self, (uint16_t)(d + 3U))));
}

static num_t step_in_time(ctl_rc_t *self, num_t learned)
{
    const ctl_rc_params_t *const p = &self->params;
    ctl_rc_state_t *const        s = &self->state;
    const num_t                  limit = p->limit;

    /* This call is sample k, not yet pushed: delay d in (1) is ring delay d - 1. */
    if (p->lead > 0U) {
        const uint16_t at = (uint16_t)(p->lead - 1U);
        const num_t    w = num_add(ctl_ring_get(&s->time, at), learned);
        ctl_ring_set(&s->time, at, num_clamp(w, num_neg(limit), limit));
    }
    const uint16_t from = (uint16_t)(s->period.whole - 2U - self->ahead); /* k - Ni + 1 */
    const num_t    y = num_clamp(read_period(self, from), num_neg(limit), limit);
    ctl_ring_push(&s->time, (p->lead > 0U) ? y : num_clamp(num_add(y, learned), num_neg(limit), limit));
    return y;
}

/* The same where `fast` says that there is nothing to decide but fal, and the memory has no gaps (ctl_ring_fill_zero). The
 * samples to read lie one after the other but for one jump at the end of the memory, hence two pointers and no branch. */
static inline num_t step_fast(ctl_rc_t *self, num_t e)
{
    const ctl_rc_params_t *const p = &self->params;
    const ctl_ring_t *const      ring = &self->state.time;
    const num_t                  learned = num_mul(p->gain, ctl_fal_unchecked(self->fal, e));
    num_t                        a[CTL_LAGRANGE_TAPS];
    ctl_lagrange_2_unchecked(self->state.period.fraction, a);

    num_t *const w = &ring->sample[ctl_ring_place(ring, (uint16_t)(p->lead - 1U))];
    *w = num_clamp(num_add(*w, learned), num_neg(p->limit), p->limit);

    const uint16_t     at = ctl_ring_place(ring, (uint16_t)(self->state.period.whole - 2U)); /* k - Ni + 1 */
    const num_t *const here = &ring->sample[at];
    const num_t *const there = &ring->sample[(ring->capacity - 4U) + ((at < 3U) ? at : 3U)] + 4; /* read for at < 4 */
    const num_t        x[CTL_LAGRANGE_TAPS + 1U] = {here[0], ((at >= 1U) ? here : there)[-1], ((at >= 2U) ? here : there)[-2],
                                                    ((at >= 3U) ? here : there)[-3], ((at >= 4U) ? here : there)[-4]};
    const num_t        y = num_clamp(filtered(&p->q, a, x), num_neg(p->limit), p->limit);
    ctl_ring_push_full(&self->state.time, y);
    return y;
}

/* Q of what the turn holds around @p angle, its neighbours a sample away. */
static inline num_t read_turn(const ctl_rc_t *self, angle_t angle, angle_t sample)
{
    const ctl_grid_t *const turn = &self->state.turn;
    const ctl_q_t *const    q = &self->params.q;
    const uint16_t          beyond = taps_beyond(&self->params);
    const uint16_t          taps = (uint16_t)(3U + (2U * beyond));
    angle_t                 at = angle - sample - (beyond * sample);
    num_t                   x[5];
    if (self->params.order < 2U) {
        for (uint16_t k = 0U; k < taps; k++) {
            x[k] = ctl_grid_read_linear(turn, at);
            at += sample;
        }
    } else {
        for (uint16_t k = 0U; k < taps; k++) {
            x[k] = ctl_grid_read_cubic_raw(turn, at);
            at += sample;
        }
    }
    const num_t y = ctl_q_apply(q, x[beyond], x[beyond + 1U], x[beyond + 2U]);
    return (beyond != 0U) ? num_mac(y, q->side2, num_add(x[0], x[4])) : y;
}

/* Sample k - m is complete now: walk the memory from the last complete sample to it. */
static inline void write_turn(ctl_rc_t *self, num_t learned)
{
    ctl_rc_state_t *const s = &self->state;
    const num_t           limit = self->params.limit;
    const uint16_t        lead = self->params.lead;
    /* ring of CTL_RC_LEAD_MAX + 1 = 16: the newest entry is sample k - 1, so k - m is m - 1 before it */
    const uint16_t at = (uint16_t)((s->past + (CTL_RC_LEAD_MAX + 1U) - (lead - 1U)) & CTL_RC_LEAD_MAX);
    const angle_t  angle = s->at_past[at];
    const num_t    value = num_clamp(num_add(s->y_past[at], learned), num_neg(limit), limit);

    if (s->writing & ((angle - s->written_at) + ANGLE_QUARTER < (2U * ANGLE_QUARTER))) {
        ctl_grid_write(&s->turn, s->written_at, s->written, angle, value);
    }
    s->written_at = angle;
    s->written = value;
    s->writing = true;
}

static inline num_t step_in_angle(ctl_rc_t *self, num_t learned, angle_t theta_e)
{
    const ctl_rc_params_t *const p = &self->params;
    ctl_rc_state_t *const        s = &self->state;

    if ((s->known >= p->lead) & !p->hold) {
        write_turn(self, learned);
    }
    /* one sample in angle: a turn over N */
#ifdef EVENSPIN_FIXED
    const angle_t step = (angle_t)((INT64_C(0x100000000) * INT64_C(0x1000000)) /
                                   (((int64_t)s->period.whole * INT64_C(0x1000000)) + s->period.fraction));
#else
    const angle_t step = (angle_t)(4294967296.0f / ((num_t)s->period.whole + s->period.fraction));
#endif
    const num_t y = num_clamp(read_turn(self, theta_e, step), num_neg(p->limit), p->limit);

    s->past = (uint16_t)((s->past + 1U) & CTL_RC_LEAD_MAX);
    s->y_past[s->past] = y;
    s->at_past[s->past] = theta_e;
    s->known = (uint16_t)(s->known + ((s->known <= CTL_RC_LEAD_MAX) ? 1U : 0U));
    return y;
}

static inline num_t output(const ctl_rc_t *self, num_t e, num_t y)
{
    return (self->params.fal_at == CTL_RC_FAL_OUTPUT) ? num_mul(ctl_fal_lambda(self->fal, e), y) : y;
}

static num_t step_general_in_time(ctl_rc_t *self, num_t e, uint16_t whole, num_t fraction)
{
    take_period(self, whole, fraction);
    return output(self, e, step_in_time(self, learned_now(self, e)));
}

/* A period that is not too long: set_period for a caller that has checked it. */
static inline void use_period(ctl_rc_t *self, uint16_t whole, num_t fraction)
{
    self->state.period.whole = whole;
    self->state.period.fraction = fraction;
    if ((whole < self->shortest) | (fraction >= ALMOST_ONE)) {
        correct_period(self);
    }
}

static inline num_t step_over_angle(ctl_rc_t *self, num_t e, uint16_t whole, num_t fraction, angle_t theta_e)
{
    use_period(self, whole, fraction);
    return output(self, e, step_in_angle(self, learned_now(self, e), theta_e));
}

num_t ctl_rc_step_unchecked(ctl_rc_t *self, num_t err, uint16_t whole, num_t fraction, angle_t theta_e)
{
    if (!self->fast) {
        return (self->params.memory == CTL_RC_ANGLE) ? step_over_angle(self, err, whole, fraction, theta_e)
                                                     : step_general_in_time(self, err, whole, fraction);
    }
    use_period(self, whole, fraction);
    return step_fast(self, err);
}

num_t ctl_rc_step(ctl_rc_t *self, num_t err, ctl_period_t period, angle_t theta_e)
{
    const num_t e = num_guard(err, (num_t)0, &self->state.rejected); /* fal(0) = 0: learns nothing */
    if (!(self->fast | (self->params.memory == CTL_RC_ANGLE))) {
        return step_general_in_time(self, e, period.whole, period.fraction);
    }
    set_period(self, period.whole, period.fraction);
    return ctl_rc_step_unchecked(self, e, self->state.period.whole, self->state.period.fraction, theta_e);
}
