#include "control/motor/current_error.h"

#define STEADY 0.1f      /* largest change of the length of a turn */
#define FULL_TURN 250.0f /* samples, 50 ms: shorter turns are more frequent, and weigh less */
#define NEAR_LIMIT 0.97f /* of the longest voltage vector */
#define SHARE_LEAST 0.0625f
#define HALF_SQRT3 0.86602540378f

typedef struct {
    float re, im;
} complex_t;

static ctl_diag_t refused(uint16_t field, float value) { return ctl_diag(CTL_ERR_RANGE, field, num_from_float(value)); }

static bool within(float x, float low, float high) { return (x >= low) && (x <= high); } /* false for NaN */

ctl_diag_t ctl_current_error_check(const ctl_current_error_params_t *p)
{
    const struct {
        float    value, low, high;
        uint16_t field;
    } row[] = {{p->gain, 1.0e-6f, 1.0f, CTL_CURRENT_ERROR_GAIN},
               {p->least_current, 1.0e-9f, 1.0e6f, CTL_CURRENT_ERROR_LEAST},
               {p->offset_max, 0.0f, 1.0e6f, CTL_CURRENT_ERROR_OFFSET_MAX},
               {p->gain_max, 0.0f, 0.5f, CTL_CURRENT_ERROR_GAIN_MAX},
               {p->r, 1.0e-9f, 1.0e9f, CTL_CURRENT_ERROR_R},
               {p->w_l, 0.0f, 1.0e9f, CTL_CURRENT_ERROR_L},
               {p->turns_per_sample, 1.0e-12f, 1.0e6f, CTL_CURRENT_ERROR_SPEED},
               {p->advance_turns, -1.0e6f, 1.0e6f, CTL_CURRENT_ERROR_SPEED}};
    for (uint16_t k = 0U; k < (uint16_t)(sizeof row / sizeof row[0]); k++) {
        if (!within(row[k].value, row[k].low, row[k].high)) {
            return refused(row[k].field, row[k].value);
        }
    }
    return (p->pole_pairs > 0U) ? ctl_diag_ok() : ctl_diag_count(CTL_ERR_RANGE, CTL_CURRENT_ERROR_POLE_PAIRS, 0U);
}

ctl_diag_t ctl_current_error_init(ctl_current_error_t *self, const ctl_current_error_params_t *params)
{
    if ((self == NULL) || (params == NULL)) {
        return ctl_diag(CTL_ERR_NULL, 0U, (num_t)0);
    }
    const ctl_diag_t d = ctl_current_error_check(params);
    if (d.status == CTL_OK) {
        self->params = *params;
        self->state.rejected = 0U;
        ctl_current_error_reset(self, NULL, NULL);
    }
    return d;
}

/* @p x cut to @p middle +- @p distance; NaN gives the middle. */
static float cut(float x, float middle, float distance)
{
    if (x != x) {
        return middle;
    }
    return (x > (middle + distance)) ? (middle + distance) : ((x < (middle - distance)) ? (middle - distance) : x);
}

void ctl_current_error_reset(ctl_current_error_t *self, const float *offset, const float *gain)
{
    ctl_current_error_state_t *const s = &self->state;
    for (uint16_t k = 0U; k < 3U; k++) {
        s->offset[k] = (offset != NULL) ? cut(offset[k], 0.0f, self->params.offset_max) : 0.0f;
        s->gain[k] = (gain != NULL) ? cut(gain[k], 1.0f, self->params.gain_max) : 1.0f;
    }
    for (uint16_t k = 0U; k < 4U; k++) {
        s->residual[k] = 0.0f;
    }
    s->share[0] = 1.0f;
    s->share[1] = 1.0f;
    s->end = 0U;
    s->end_m = 0U;
    s->samples = 0U;
    s->verdict = CTL_CURRENT_ERROR_NOTHING;
}

/* ---- a turn ---------------------------------------------------------------------------------------------------------- */

void ctl_turn_clear(ctl_turn_log_t *log)
{
    static const ctl_turn_t EMPTY = {.samples = 0U};
    log->turn[(log->at & 1U) ^ 1U] = EMPTY;
}

/* ---- what it says ------------------------------------------------------------------------------------------------------ */

static complex_t times(complex_t a, complex_t b)
{
    const complex_t c = {(a.re * b.re) - (a.im * b.im), (a.re * b.im) + (a.im * b.re)};
    return c;
}

/* Mean over exactly one turn: the samples cover 1 + @p excess of it, and end with @p last. */
static complex_t mean(ctl_sum_t re, ctl_sum_t im, float samples, float excess, complex_t last)
{
#ifdef EVENSPIN_FIXED
    const float unit = 5.9604644775390625e-8f / samples;
#else
    const float unit = 1.0f / samples;
#endif
    const complex_t m = {(float)re * unit, (float)im * unit};
    const complex_t c = {m.re + (excess * (m.re - last.re)), m.im + (excess * (m.im - last.im))};
    return c;
}

static complex_t direction(angle_t angle)
{
    num_t sine, cosine;
    angle_sincos(angle, &sine, &cosine);
    const complex_t e = {num_to_float(cosine), num_to_float(sine)};
    return e;
}

static complex_t of(ctl_dq_t x)
{
    const complex_t c = {num_to_float(x.d), num_to_float(x.q)};
    return c;
}

static float size(float x) { return (x < 0.0f) ? -x : x; }

typedef struct {
    complex_t offset, negative; /* o, and n conj(I) */
} residual_t;

/* @param speed  of this turn, speed unit. @param excess  by which the samples cover more than it, turns */
static residual_t residual_of(const ctl_current_error_params_t *p, const ctl_turn_t *t, const ctl_turn_now_t *now, float speed,
                              float excess)
{
    const float n = (float)t->samples;
    /* Sample k stands for half a sample before it to half a sample after it. In the middle of what the samples cover too much, current and
     * voltage are those of the end, turned back: it is the fundamental that has to be taken off there. */
    const angle_t   back = angle_step_from_turns(num_from_float((0.5f * excess) + (0.5f / n)));
    const complex_t at = direction((speed < 0.0f) ? (t->end + back) : (t->end - back));
    const complex_t ahead = direction(angle_step_from_turns(num_from_float(cut(p->advance_turns * speed, 0.0f, 0.49f))));
    const complex_t i_end = times(of(now->i), at);
    const complex_t v_end = times(of(now->v), at);

    const complex_t i = mean(t->i_alpha, t->i_beta, n, excess, i_end);
    const complex_t v = times(mean(t->v_alpha, t->v_beta, n, excess, v_end), ahead);
    const complex_t i_back = mean(t->i_re, t->i_im, n, excess, times(i_end, at));
    const complex_t v_back = times(mean(t->v_re, t->v_im, n, excess, times(v_end, at)), times(ahead, ahead));

    residual_t r;
    r.offset.re = i.re - (v.re / p->r); /* (3) */
    r.offset.im = i.im - (v.im / p->r);
    const float     q = p->w_l * speed / p->r; /* 1 / (R - j w L) = (1 + j q) / (R (1 + q^2)) */
    const complex_t turned = {1.0f, q};
    const complex_t driven = times(v_back, turned);
    const float     scale = 1.0f / (p->r * (1.0f + (q * q)));
    r.negative.re = i_back.re - (driven.re * scale);
    r.negative.im = i_back.im - (driven.im * scale);
    return r;
}

static bool usable(const residual_t *r)
{
    return within(r->offset.re, -1.0e6f, 1.0e6f) && within(r->offset.im, -1.0e6f, 1.0e6f) &&
           within(r->negative.re, -1.0e6f, 1.0e6f) && within(r->negative.im, -1.0e6f, 1.0e6f);
}

/* Halved where the residual has turned round, and slowly given back. */
static float adapted(float share, complex_t now, const float *before)
{
    const float next = (((now.re * before[0]) + (now.im * before[1])) < 0.0f) ? (share * 0.5f) : (share * 1.25f);
    return (next > 1.0f) ? 1.0f : ((next < SHARE_LEAST) ? SHARE_LEAST : next);
}

/* @return whether it stands at the bound */
static bool move(float *x, float by, float middle, float distance)
{
    const float wanted = *x + by;
    *x = cut(wanted, middle, distance);
    return *x != wanted;
}

static bool correct(ctl_current_error_t *self, complex_t o, complex_t n, float gain)
{
    ctl_current_error_state_t *const        s = &self->state;
    const ctl_current_error_params_t *const p = &self->params;
    const float offset[3] = {o.re, (HALF_SQRT3 * o.im) - (0.5f * o.re), (-HALF_SQRT3 * o.im) - (0.5f * o.re)};
    float       e[3];
    if (p->three) {
        e[0] = 2.0f * n.re;
        e[1] = (-2.0f * HALF_SQRT3 * n.im) - n.re;
        e[2] = (2.0f * HALF_SQRT3 * n.im) - n.re;
    } else {
        e[0] = (0.75f * n.re) + (0.5f * HALF_SQRT3 * n.im); /* half of sqrt(3) Re(n e^{-j 30 deg}) */
        e[1] = -e[0];
        e[2] = 0.0f;
    }
    bool           bound = false;
    const uint16_t sensors = p->three ? 3U : 2U;
    for (uint16_t k = 0U; k < sensors; k++) {
        bound = move(&s->offset[k], gain * s->share[0] * offset[k] * s->gain[k], 0.0f, p->offset_max) || bound;
        bound = move(&s->gain[k], gain * s->share[1] * e[k], 1.0f, p->gain_max) || bound; /* their sum stays */
    }
    return bound;
}

/* Has the shaft gone on by an electrical turn, in the direction of the speed? With one pole pair its angle cannot tell that from standing at
 * the border, and the speed has to. */
static bool is_one_turn(const ctl_current_error_params_t *p, const ctl_turn_t *t, angle_t begin_m, num_t speed)
{
    const uint32_t turn = UINT32_C(4294967295) / p->pole_pairs;
    const uint32_t travel = t->end_m - begin_m;
    const float    turns = size(num_to_float(speed)) * p->turns_per_sample * (float)t->samples;
    return (angle_size((speed > (num_t)0) ? (travel - turn) : (travel + turn)) < (turn >> 3)) && within(turns, 0.2f, 5.0f);
}

static ctl_current_error_verdict_t learn_from(ctl_current_error_t *self, const ctl_turn_t *t, const ctl_turn_now_t *now,
                                              float over)
{
    ctl_current_error_state_t *const        s = &self->state;
    const ctl_current_error_params_t *const p = &self->params;
    const float                             n = (float)t->samples;
    const float                             forwards = (now->speed > (num_t)0) ? 1.0f : -1.0f;
    const residual_t                        r = residual_of(p, t, now, forwards / (n * p->turns_per_sample), forwards * over);
    if (!usable(&r)) {
        num_count(&s->rejected);
        return CTL_CURRENT_ERROR_UNSTEADY;
    }
    const complex_t current = of(now->i_mean);
    const float     squared = (current.re * current.re) + (current.im * current.im);
    if (!(squared >= (p->least_current * p->least_current))) {
        return CTL_CURRENT_ERROR_SMALL;
    }
    const complex_t turned = times(r.negative, current);
    const complex_t negative = {turned.re / squared, turned.im / squared}; /* (4) */
    s->share[0] = adapted(s->share[0], r.offset, &s->residual[0]);
    s->share[1] = adapted(s->share[1], negative, &s->residual[2]);
    s->residual[0] = r.offset.re;
    s->residual[1] = r.offset.im;
    s->residual[2] = negative.re;
    s->residual[3] = negative.im;
    const float weight = (n < FULL_TURN) ? (n / FULL_TURN) : 1.0f;
    return correct(self, r.offset, negative, p->gain * weight) ? CTL_CURRENT_ERROR_BOUND : CTL_CURRENT_ERROR_LEARNS;
}

static ctl_current_error_verdict_t judge(ctl_current_error_t *self, const ctl_turn_t *t, const ctl_turn_now_t *now)
{
    ctl_current_error_state_t *const        s = &self->state;
    const ctl_current_error_params_t *const p = &self->params;
    const ctl_current_error_state_t         before = *s;
    s->end = t->end;
    s->end_m = t->end_m;
    s->samples = 0U;
    if (!t->whole || (t->samples >= CTL_TURN_LONGEST)) {
        return (t->samples >= CTL_TURN_LONGEST) ? CTL_CURRENT_ERROR_SLOW : CTL_CURRENT_ERROR_NOTHING;
    }
    s->samples = t->samples;
    if (t->samples < CTL_TURN_SHORTEST) {
        return CTL_CURRENT_ERROR_FAST;
    }
    const float n = (float)t->samples;
    const float over = (float)(int32_t)(t->end - before.end) * 2.3283064e-10f;
    const float change = (STEADY * n > 1.5f) ? (STEADY * n) : 1.5f;
    if (!is_one_turn(p, t, before.end_m, now->speed) || !within(over, -0.125f, 0.125f) ||
        (size(n - (float)before.samples) > change)) {
        return CTL_CURRENT_ERROR_UNSTEADY;
    }
    const complex_t v = of(now->v);
    const float     limit = NEAR_LIMIT * num_to_float(now->v_limit);
    if (!(((v.re * v.re) + (v.im * v.im)) < (limit * limit))) {
        return CTL_CURRENT_ERROR_VOLTAGE;
    }
    return learn_from(self, t, now, over);
}

ctl_current_error_verdict_t ctl_current_error_learn(ctl_current_error_t *self, const ctl_turn_t *turn, const ctl_turn_now_t *now)
{
    self->state.verdict = judge(self, turn, now);
    return self->state.verdict;
}
