#include "control/motor/current_reference.h"

#include "control/numeric/num_math.h"

#define ONE NUM_C(1.0f)
#define HALF NUM_C(0.5f)
#define T_MOST NUM_C(60.0f)
#define N_MOST NUM_C(11.0f) /* beyond it no machine is at its voltage limit; its square is within the fixed numeric */
#define N_DEEP NUM_C(3.0f)  /* beyond it no d current as deep as (4) is needed; its square times 8 is within the fixed numeric */
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

/* Least id: (4), and what the magnets bear. */
static num_t deepest(const ctl_reference_plan_t *plan, num_t n)
{
    const num_t c = num_mul(plan->volt_gain, num_min(n, N_DEEP));
    const num_t root = num_sqrt(num_mac(ONE, num_mul(NUM_C(8.0f), c), c));
    const num_t x = num_quotient(num_mul(num_mul(NUM_C(2.0f), c), num_min(n, N_DEEP)), num_add(ONE, root));
    return num_max(num_mul(plan->params.d_full, num_sub(x, ONE)), num_neg(plan->params.id_max));
}

/* d current of (3) for a torque current, from that of the last sample: two Newton steps of id = F (sqrt(n^2 - m^2) - 1), in which more d
 * current leaves less q current m to the same torque. Exact at once without reluctance. Where the flux of the d axis is
 * nearly gone, of the torque along (3) over that flux, x: it is concave, so no step passes the solution. */
static num_t weakened(const ctl_reference_plan_t *plan, num_t n, num_t torque, num_t id, num_t least)
{
    const ctl_reference_params_t *const p = &plan->params;
    const num_t                         of_q = num_abs(num_quotient(torque, p->q_full));
    const bool                          reluctance = p->saliency < (num_t)0;
    for (uint16_t k = 0U; k < 2U; k++) {
        const num_t gain = gain_of(p, id);
        const num_t m = num_quotient(of_q, gain);
        const num_t flux = beside(n, m);
        const num_t x = num_mac(ONE, id, plan->per_d_full);
        if (reluctance && (num_min(flux, x) < num_mul(NUM_C(0.25f), n))) {
            const num_t y = num_max(beside(n, x), num_mul(HALF, n));
            const num_t fall = num_sub(num_quotient(num_mul(x, gain), y), num_mul(plan->share_full, y));
            const num_t least_fall = num_mul(num_mul(NUM_C(-0.25f), plan->share_full), n);
            const num_t step = num_quotient(num_sub(num_mul(y, gain), of_q), num_max(num_max(fall, least_fall), NUM_EPS));
            id = num_mac(id, p->d_full, num_clamp(step, num_neg(n), n));
        } else {
            const num_t slope = num_quotient(num_mul(num_mul(plan->share_full, m), m), num_mul(num_max(flux, FLUX_LEAST), gain));
            const num_t off = num_sub(num_mul(p->d_full, num_sub(flux, ONE)), id);
            id = num_add(id, num_quotient(off, num_max(num_sub(ONE, slope), HALF)));
        }
        id = num_clamp(id, least, p->id_max);
    }
    return id;
}

/* Largest torque current: where (3) meets the circle, a id^2 - id - h = 0 with h = I^2 Lq^2 / (2 psi Ld) + F (1 - n^2) / 2, or (4).
 * @return its id: no torque needs more. */
static num_t make_room(const ctl_reference_plan_t *plan, ctl_reference_state_t *s, num_t n, num_t torque)
{
    const ctl_reference_params_t *const p = &plan->params;
    const num_t h = num_mac(plan->half_square, num_mul(HALF, p->d_full), num_mul(num_sub(ONE, n), num_add(ONE, n)));
    s->room = plan->torque_max;
    if (h <= (num_t)0) {
        return num_neg(p->id_max);
    }
    const num_t root = num_sqrt(num_max(num_mac(NUM_C(0.25f), plan->curvature, h), (num_t)0)); /* halves: 4 a h has no room */
    const num_t meets = num_neg(num_quotient(h, num_add(HALF, root)));
    if (meets >= num_min(plan->id_at_max, (num_t)0)) {
        return num_neg(p->id_max);
    }
    const num_t id = (meets >= plan->surely) ? num_max(meets, num_neg(p->id_max)) : num_max(meets, deepest(plan, n));
    const num_t flux = num_add(ONE, num_quotient(id, p->d_full));
    const bool  inside = num_abs(flux) < n;
    const num_t circle = num_min(p->iq_max, beside(p->i_max, id));
    const num_t iq = inside ? num_min(circle, num_mul(p->q_full, beside(n, flux))) : (num_t)0;
    /* beyond id = -F the q current comes down again: less torque has more of it */
    const num_t iq_most = (inside && (flux < (num_t)0)) ? num_min(p->iq_max, num_mul(p->q_full, n)) : iq;
    s->iq_max = num_min(s->iq_max, iq_most);
    s->room = num_min(plan->torque_max, num_mul(iq, gain_of(p, id)));
    s->limited = num_abs(torque) > num_mul(NEARLY, s->room); /* with less the voltage may be none */
    return id;
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
    const num_t least = make_room(plan, s, ratio(num_sqrt(num_sub(have, s->drop)), num_abs(e)), in->torque);
    const num_t id = weakened(plan, ratio(num_sqrt(num_sub(have, drop)), num_abs(e)), in->torque, id_last, least);
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
