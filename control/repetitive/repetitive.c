#include "control/repetitive/repetitive.h"

/* A period this little below a whole number is that number: 60 / (p n T_s) is rounded, too (in fixed point at N = 100
 * to 1e-4), and cutting 99.9999 to 99 would be wrong by a whole sample. */
#define ALMOST_ONE NUM_C(0.9995f)
#define CLEAR_STEP NUM_C(0.0625f)

/* ---- configuration ---------------------------------------------------------------------------------------------- */

static ctl_diag_t check(const ctl_rc_params_t *p, uint16_t capacity, ctl_fal_t *fal)
{
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
        d = ctl_fal_init(fal, &p->fal);
        if (d.status != CTL_OK) {
            d.field = (d.field == (uint16_t)CTL_FAL_ALPHA) ? (uint16_t)CTL_RC_FAL_ALPHA : (uint16_t)CTL_RC_FAL_DELTA;
        }
    }
    if ((d.status == CTL_OK) && ((uint16_t)p->memory > (uint16_t)CTL_RC_ANGLE)) {
        d = ctl_diag_count(CTL_ERR_RANGE, CTL_RC_MEMORY, (uint16_t)p->memory);
    }
    if (d.status == CTL_OK) {
        d = ctl_diag_range(p->limit, NUM_EPS, NUM_MAX, CTL_RC_LIMIT);
    }
    if (d.status == CTL_OK) {
        d = ctl_diag_range(p->freeze_above, (num_t)0, NUM_MAX, CTL_RC_FREEZE);
    }
    if ((d.status == CTL_OK) && ((uint32_t)capacity < ((uint32_t)p->lead + p->order + 5U))) {
        d = ctl_diag_count(CTL_ERR_MEMORY, CTL_RC_CAPACITY, capacity);
    }
    return d;
}

ctl_diag_t ctl_rc_init(ctl_rc_t *self, const ctl_rc_params_t *params, num_t *memory, uint16_t capacity)
{
    if ((self == NULL) || (params == NULL)) {
        return ctl_diag(CTL_ERR_NULL, 0U, (num_t)0);
    }
    ctl_rc_t made = {0};
    ctl_diag_t d = check(params, capacity, &made.fal);
    if (d.status == CTL_OK) {
        made.params = *params;
        d = (params->memory == CTL_RC_ANGLE) ? ctl_grid_init(&made.state.turn, memory, capacity)
                                             : ctl_ring_init(&made.state.time, memory, capacity);
        if (d.status != CTL_OK) {
            d.field = CTL_RC_CAPACITY;
        }
    }
    if (d.status == CTL_OK) {
        *self = made; /* the coefficients come with the first period: no period is 0 */
    }
    return d;
}

void ctl_rc_reset(ctl_rc_t *self)
{
    ctl_rc_state_t *const s = &self->state;
    if (self->params.memory == CTL_RC_ANGLE) {
        ctl_grid_clear(&s->turn);
    } else {
        ctl_ring_clear(&s->time);
    }
    s->known = 0U;
    s->writing = false;
    s->frozen = 0U;
}

uint16_t ctl_rc_period_max(const ctl_rc_t *self)
{
    return (self->params.memory == CTL_RC_ANGLE) ? (uint16_t)65534U
                                                 : (uint16_t)(self->state.time.capacity - self->params.order - 1U);
}

ctl_period_t ctl_period_ratio(num_t numerator, num_t denominator)
{
    ctl_period_t n = {65534U, (num_t)0};
    if ((denominator > (num_t)0) && (numerator > (num_t)0)) {
#ifdef EVENSPIN_FIXED
        const int64_t samples = ((int64_t)numerator * INT64_C(0x1000000)) / denominator;
        if (samples < (INT64_C(65534) * INT64_C(0x1000000))) {
            n.whole = (uint16_t)(samples >> 24);
            n.fraction = (num_t)(samples & INT64_C(0xFFFFFF));
        }
#else
        const num_t samples = num_div(numerator, denominator);
        if (samples < 65534.0f) {
            n.whole = (uint16_t)samples;
            n.fraction = samples - (num_t)n.whole;
        }
#endif
    }
    return n;
}

/* ---- one sample --------------------------------------------------------------------------------------------------- */

/* The period as the delay will use it: whole samples only for order 0, inside of what the memory holds. */
static ctl_period_t usable_period(ctl_rc_t *self, ctl_period_t wanted)
{
    const ctl_rc_params_t *const p = &self->params;
    const uint16_t               shortest = (uint16_t)(p->lead + 2U);
    const uint16_t               longest = ctl_rc_period_max(self);
    const bool                   in_whole = (p->order == 0U) && (p->memory != CTL_RC_ANGLE);
    const num_t                  rounding = (in_whole && !p->truncate) ? NUM_C(0.5f) : ALMOST_ONE;
    ctl_period_t                 n = wanted;

    if (!((n.fraction >= (num_t)0) && (n.fraction < NUM_C(1.0f)))) {
        n.fraction = (num_t)0;
    }
    if ((n.fraction >= rounding) && (n.whole < UINT16_MAX)) {
        n.whole++;
        n.fraction = (num_t)0;
    }
    if (in_whole) {
        n.fraction = (num_t)0;
    }
    if ((n.whole < shortest) || (n.whole > longest)) {
        n.whole = (n.whole < shortest) ? shortest : longest;
        n.fraction = (num_t)0;
        num_count(&self->state.cut_periods);
    }
    return n;
}

/* a - b in samples, where they are close; else just more than that */
static num_t period_step(ctl_period_t a, ctl_period_t b)
{
    const int32_t whole = (int32_t)a.whole - (int32_t)b.whole;
    return num_add(num_from_int((int16_t)((whole > 2) ? 2 : ((whole < -2) ? -2 : whole))), num_sub(a.fraction, b.fraction));
}

static void take_period(ctl_rc_t *self, ctl_period_t wanted)
{
    ctl_rc_state_t *const s = &self->state;
    const ctl_period_t    n = usable_period(self, wanted);

    if ((n.whole == s->period.whole) && (n.fraction == s->period.fraction)) {
        return;
    }
    if ((self->params.memory == CTL_RC_CLEAR) && (num_abs(period_step(n, s->period)) > CLEAR_STEP)) {
        ctl_ring_clear(&s->time);
    }
    s->period = n;
    ctl_lagrange(self->params.order, n.fraction, s->a);
}

/* What this sample teaches: k_rc f(e), or nothing while learning rests. */
static num_t lesson(ctl_rc_t *self, num_t e)
{
    const ctl_rc_params_t *const p = &self->params;
    ctl_rc_state_t *const        s = &self->state;

    if ((p->freeze_above > (num_t)0) && (num_abs(e) > p->freeze_above)) {
        s->frozen = p->freeze_samples;
    } else if (s->frozen > 0U) {
        s->frozen--;
    } else {
        return num_mul(p->gain, (p->fal_at == CTL_RC_FAL_INPUT) ? ctl_fal(&self->fal, e) : e);
    }
    return (num_t)0;
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
    uint16_t d = (uint16_t)(s->period.whole - 2U); /* k - Ni + 1 */
    num_t    after = ctl_ring_get(&s->time, d);
    num_t    here = ctl_ring_get(&s->time, (uint16_t)(d + 1U));
    num_t    y = (num_t)0;
    for (uint16_t j = 0U; j <= p->order; j++) {
        const num_t before = ctl_ring_get(&s->time, (uint16_t)(d + 2U));
        y = num_mac(y, s->a[j], ctl_q_apply(&p->q, before, here, after));
        after = here;
        here = before;
        d++;
    }
    y = num_clamp(y, num_neg(limit), limit);
    ctl_ring_push(&s->time, (p->lead > 0U) ? y : num_clamp(num_add(y, learned), num_neg(limit), limit));
    return y;
}

static num_t read_turn(const ctl_rc_t *self, angle_t angle)
{
    return (self->params.order < 2U) ? ctl_grid_read_linear(&self->state.turn, angle)
                                     : ctl_grid_read_cubic(&self->state.turn, angle);
}

/* Sample k - m is complete now: walk the memory from the last complete sample to it. */
static void write_turn(ctl_rc_t *self, num_t learned)
{
    ctl_rc_state_t *const s = &self->state;
    const num_t           limit = self->params.limit;
    const uint16_t        lead = self->params.lead;
    /* ring of CTL_RC_LEAD_MAX + 1 = 16: the newest entry is sample k - 1, so k - m is m - 1 before it */
    const uint16_t at = (uint16_t)((s->past + (CTL_RC_LEAD_MAX + 1U) - (lead - 1U)) & CTL_RC_LEAD_MAX);
    const angle_t  angle = s->at_past[at];
    const num_t    value = num_clamp(num_add(s->y_past[at], learned), num_neg(limit), limit);

    if (s->writing && ((angle - s->written_at) + ANGLE_QUARTER < (2U * ANGLE_QUARTER))) {
        ctl_grid_walk_t walk = ctl_grid_walk(&s->turn, s->written_at, s->written, angle, value);
        uint16_t        i = 0U;
        num_t           v = (num_t)0;
        while (ctl_grid_walk_next(&walk, &i, &v)) {
            s->turn.cell[i] = v;
        }
    }
    s->written_at = angle;
    s->written = value;
    s->writing = true;
}

static num_t step_in_angle(ctl_rc_t *self, num_t learned, angle_t theta_e)
{
    const ctl_rc_params_t *const p = &self->params;
    ctl_rc_state_t *const        s = &self->state;

    if (s->known >= p->lead) {
        write_turn(self, learned);
    }
    /* one sample in angle: a turn over N */
#ifdef EVENSPIN_FIXED
    const angle_t step = (angle_t)((INT64_C(0x100000000) * INT64_C(0x1000000)) /
                                   (((int64_t)s->period.whole * INT64_C(0x1000000)) + s->period.fraction));
#else
    const angle_t step = (angle_t)(4294967296.0f / ((num_t)s->period.whole + s->period.fraction));
#endif
    num_t y = ctl_q_apply(&p->q, read_turn(self, theta_e - step), read_turn(self, theta_e), read_turn(self, theta_e + step));
    y = num_clamp(y, num_neg(p->limit), p->limit);

    s->past = (uint16_t)((s->past + 1U) & CTL_RC_LEAD_MAX);
    s->y_past[s->past] = y;
    s->at_past[s->past] = theta_e;
    if (s->known <= CTL_RC_LEAD_MAX) {
        s->known++;
    }
    return y;
}

num_t ctl_rc_step(ctl_rc_t *self, num_t err, ctl_period_t period, angle_t theta_e)
{
    const num_t e = num_guard(err, (num_t)0, &self->state.rejected); /* fal(0) = 0: teaches nothing */

    take_period(self, period);
    const num_t learned = lesson(self, e);
    const num_t y = (self->params.memory == CTL_RC_ANGLE) ? step_in_angle(self, learned, theta_e)
                                                          : step_in_time(self, learned);
    return (self->params.fal_at == CTL_RC_FAL_OUTPUT) ? num_mul(ctl_fal_lambda(&self->fal, e), y) : y;
}
