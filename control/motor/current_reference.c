#include "control/motor/current_reference.h"

#include "control/numeric/num_math.h"

#define ONE NUM_C(1.0f)
#define HALF NUM_C(0.5f)
#define T_MOST NUM_C(60.0f)
#define N_MOST NUM_C(11.0f)      /* beyond it no machine is at its voltage limit; its square is within the fixed numeric */
#define GAIN_LEAST NUM_C(0.125f) /* of 1 + k id, where field weakening takes reluctance torque away: Ld > Lq */
#define TRIM_LEAST NUM_C(0.25f)
#define TRIM_MOST NUM_C(1.5f)
#define DROP_MOST NUM_C(0.75f) /* of the square of the voltage */
#define USED_MOST NUM_C(2.0f)
#define FLUX_LEAST NUM_C(0.125f) /* of the d axis, over that of the magnets: where the slope is bounded */
#define NEARLY NUM_C(0.98f)
#define V_LEAST NUM_C(0.0009765625f)

static num_t square(num_t x) { return num_mul(x, x); }

/* u of (2). */
static num_t mtpa_gain(num_t saliency, num_t torque)
{
    const num_t t = num_min(num_abs(num_mul(saliency, torque)), T_MOST);
    /* both are upper bounds, u^4 - u^3 is convex: every step comes down to the root and none passes it */
    num_t u = num_add(NUM_C(0.25f), num_sqrt(num_add(NUM_C(0.5625f), t)));
    if (t < ONE) {
        u = num_min(u, num_add(ONE, square(t)));
    }
    for (uint16_t k = 0U; k < 3U; k++) {
        const num_t w = num_quotient(t, u);
        const num_t excess = num_sub(num_sub(square(u), u), square(w));
        u = num_max(num_sub(u, num_quotient(excess, num_sub(num_mul(NUM_C(4.0f), u), NUM_C(3.0f)))), ONE);
    }
    return u;
}

num_t ctl_mtpa_id(num_t saliency, num_t torque)
{
    if (!num_is_finite(saliency) || !num_is_finite(torque)) {
        return (num_t)0;
    }
    const num_t u = mtpa_gain(saliency, torque);
    const num_t iq = num_quotient(torque, u);
    return num_quotient(num_mul(num_mul(saliency, iq), iq), u);
}

/* 1 + k id: torque current per q current. */
static num_t gain_of(const ctl_reference_params_t *p, num_t id) { return num_max(num_mac(ONE, p->saliency, id), GAIN_LEAST); }

/* What a circle of radius r leaves beside x. */
static num_t beside(num_t r, num_t x)
{
    const num_t size = num_min(num_abs(x), r);
    return num_sqrt(num_mul(num_sub(r, size), num_add(r, size)));
}

void ctl_reference_reset(const ctl_reference_plan_t *plan, ctl_reference_state_t *s)
{
    s->id = (num_t)0;
    s->iq_max = plan->params.iq_max;
    s->q_share = ONE;
    s->gain = ONE;
    s->room = plan->torque_max;
    s->trim = ONE;
    s->used = (num_t)0;
    s->drop = (num_t)0;
    s->limited = false;
}

/* Of the voltage that may be used: it falls where the measured one is above it, and where that is the limit it rises. */
static void follow_voltage(const ctl_reference_params_t *p, ctl_reference_state_t *s, num_t v, ctl_dq_t volt)
{
    const num_t size = num_quotient(num_sqrt(num_mac(square(volt.d), volt.q, volt.q)), v);
    s->used = num_mac(s->used, p->smooth, num_sub(num_min(size, USED_MOST), s->used));
    const num_t off = num_sub(ONE, s->used);
    num_t       step = num_mul(p->rise, s->limited ? off : num_sub(ONE, s->trim));
    if (off < (num_t)0) {
        step = num_mul(p->fall, off);
    }
    s->trim = num_clamp(num_add(s->trim, step), TRIM_LEAST, TRIM_MOST);
}

/* n for the voltage v at the speed voltage e. */
static num_t ratio(num_t v, num_t e) { return (v >= num_mul(N_MOST, e)) ? N_MOST : num_quotient(num_max(v, (num_t)0), e); }

/* d current of (3) for a torque current, from that of the last sample: two Newton steps of id = F (sqrt(n^2 - m^2) - 1), in which more d
 * current leaves less q current m to the same torque. Exact at once without reluctance. */
static num_t weakened(const ctl_reference_plan_t *plan, num_t n, num_t torque, num_t id)
{
    const ctl_reference_params_t *const p = &plan->params;
    const num_t                         of_q = num_quotient(torque, p->q_full);
    const num_t                         reluctance = num_neg(num_mul(p->saliency, p->d_full));
    for (uint16_t k = 0U; k < 2U; k++) {
        const num_t gain = gain_of(p, id);
        const num_t m = num_quotient(of_q, gain);
        const num_t flux = beside(n, m);
        const num_t slope = num_quotient(num_mul(num_mul(reluctance, m), m), num_mul(num_max(flux, FLUX_LEAST), gain));
        const num_t off = num_sub(num_mul(p->d_full, num_sub(flux, ONE)), id);
        id = num_clamp(num_add(id, num_quotient(off, num_max(num_add(ONE, slope), HALF))), plan->id_deepest, p->id_max);
    }
    return id;
}

/* Largest torque current: where (3) meets the circle, a id^2 - id - h = 0 with h = I^2 Lq^2 / (2 psi Ld) + F (1 - n^2) / 2. */
static void make_room(const ctl_reference_plan_t *plan, ctl_reference_state_t *s, num_t n, num_t torque)
{
    const ctl_reference_params_t *const p = &plan->params;
    const num_t h = num_mac(plan->half_square, num_mul(HALF, p->d_full), num_mul(num_sub(ONE, n), num_add(ONE, n)));
    s->room = plan->torque_max;
    if (h <= (num_t)0) {
        return;
    }
    const num_t root = num_sqrt(num_max(num_mac(ONE, num_mul(NUM_C(4.0f), plan->curvature), h), (num_t)0));
    const num_t meets = num_neg(num_quotient(num_mul(NUM_C(2.0f), h), num_add(ONE, root)));
    if (meets >= num_min(plan->id_at_max, (num_t)0)) {
        return;
    }
    const num_t id = num_max(meets, plan->id_deepest);
    const num_t flux = num_max(num_add(ONE, num_quotient(id, p->d_full)), (num_t)0);
    const num_t iq = (flux < n) ? num_min(beside(p->i_max, id), num_mul(p->q_full, beside(n, flux))) : (num_t)0;
    s->iq_max = num_min(s->iq_max, iq);
    s->room = num_min(plan->torque_max, num_mul(s->iq_max, gain_of(p, id)));
    s->limited = num_abs(torque) > num_mul(NEARLY, s->room); /* with less the voltage may be none */
}

static void weaken(const ctl_reference_plan_t *plan, ctl_reference_state_t *s, const ctl_reference_in_t *in, num_t id_last)
{
    const ctl_reference_params_t *const p = &plan->params;
    const num_t                         v = num_max(num_mul(p->share, in->v_limit), V_LEAST);
    follow_voltage(p, s, v, in->volt);

    const num_t e = num_mul(p->emf, in->speed);
    const num_t have = square(num_mul(s->trim, v));
    const num_t most = num_mul(DROP_MOST, have);
    const num_t resistive_d = num_mul(p->ohm, id_last);
    const num_t resistive_q = num_mul(p->ohm, num_quotient(in->torque, gain_of(p, id_last)));
    const num_t resistive = num_mac(square(resistive_d), resistive_q, resistive_q);
    const num_t drop = num_clamp(num_mac(resistive, num_mul(NUM_C(2.0f), num_mul(p->ohm, in->torque)), e), num_neg(most), most);
    s->drop = num_mac(s->drop, HALF, num_sub(drop, s->drop));

    s->limited = false;
    make_room(plan, s, ratio(num_sqrt(num_sub(have, s->drop)), num_abs(e)), in->torque);
    const num_t id = weakened(plan, ratio(num_sqrt(num_sub(have, drop)), num_abs(e)), in->torque, id_last);
    if (id < s->id) {
        s->id = id;
        s->limited = true;
    }
}

void ctl_reference_step(const ctl_reference_plan_t *plan, ctl_reference_state_t *s, const ctl_reference_in_t *in)
{
    const ctl_reference_params_t *const p = &plan->params;
    const num_t                         id_last = s->id;
    if (!(num_is_finite(in->torque) && num_is_finite(in->speed) && num_is_finite(in->v_limit) && num_is_finite(in->volt.d) &&
          num_is_finite(in->volt.q))) {
        num_count(&s->rejected);
        return;
    }
    const num_t id = p->mtpa ? ctl_mtpa_id(p->saliency, in->torque) : (num_t)0;
    s->id = num_clamp(id, num_neg(p->id_max), p->id_max);
    s->iq_max = p->iq_max;
    s->room = plan->torque_max;
    if (p->weakens) {
        weaken(plan, s, in, id_last);
    }
    s->iq_max = num_min(s->iq_max, beside(p->i_max, s->id));
    s->gain = gain_of(p, s->id);
    s->q_share = num_quotient(ONE, s->gain);
}
