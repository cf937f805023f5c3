/* What follows from the parameters: main loop. */
#include "control/motor/current_reference.h"
#include "control/numeric/num_math.h"

#define ONE NUM_C(1.0f)
#define HALF NUM_C(0.5f)

/* Range of each field. */
static const num_t LEAST[] = {(num_t)0, -NUM_MAX, NUM_EPS, NUM_EPS, NUM_EPS, (num_t)0, NUM_EPS, NUM_EPS, (num_t)0, HALF, NUM_EPS};
static const num_t MOST[] = {(num_t)0, NUM_MAX, NUM_MAX, NUM_MAX, NUM_MAX, NUM_MAX, NUM_MAX, NUM_MAX, NUM_MAX, ONE, ONE};

/* What a circle of radius r leaves beside x; 0 <= x. */
static num_t beside(num_t r, num_t x) { return (x < r) ? num_sqrt(num_mul(num_sub(r, x), num_add(r, x))) : (num_t)0; }

/* The largest torque current along (2), up to the first limit that it meets: the circle, iq_max, id_max. */
static void plan_torque(ctl_reference_plan_t *plan)
{
    const ctl_reference_params_t *const p = &plan->params;
    const num_t                         k = num_abs(p->saliency);
    plan->torque_max = p->iq_max;
    plan->id_at_max = (num_t)0;
    if (!p->mtpa || (k == (num_t)0)) {
        return;
    }
    /* along (2) iq grows with the torque, which is at most i_max (1 + |k| i_max): halve the interval */
    num_t low = (num_t)0;
    num_t step = num_mac(p->i_max, num_mul(k, p->i_max), p->i_max);
    for (uint16_t n = 0U; n < 24U; n++) {
        step = num_mul(HALF, step);
        const num_t torque = num_add(low, step);
        const num_t id = num_min(num_abs(ctl_mtpa_id(p->saliency, torque)), p->id_max);
        const num_t iq = num_quotient(torque, num_mac(ONE, k, id));
        if (iq <= num_min(p->iq_max, beside(p->i_max, id))) {
            low = torque;
            plan->id_at_max = (p->saliency < (num_t)0) ? num_neg(id) : id;
        }
    }
    plan->torque_max = low;
}

ctl_diag_t ctl_reference_plan(ctl_reference_plan_t *plan, const ctl_reference_params_t *params)
{
    if ((plan == NULL) || (params == NULL)) {
        return ctl_diag(CTL_ERR_NULL, 0U, (num_t)0);
    }
    const num_t value[] = {params->saliency, params->d_full, params->q_full, params->emf,  params->ohm,    params->i_max,
                           params->iq_max,   params->id_max, params->share,  params->fall, params->smooth, params->rise};
    for (uint16_t i = 0U; i < (uint16_t)(sizeof value / sizeof value[0]); i++) {
        const uint16_t   field = (i < (uint16_t)CTL_REFERENCE_GAIN) ? (uint16_t)(i + 1U) : (uint16_t)CTL_REFERENCE_GAIN;
        const ctl_diag_t d = ctl_diag_range(value[i], LEAST[field], MOST[field], field);
        if (d.status != CTL_OK) {
            return d;
        }
    }
    if ((params->iq_max > params->i_max) || (params->id_max > params->i_max)) {
        return ctl_diag(CTL_ERR_RELATION, (params->id_max > params->i_max) ? CTL_REFERENCE_ID_MAX : CTL_REFERENCE_IQ_MAX,
                        params->i_max);
    }
    plan->params = *params;
    plan_torque(plan);
    /* Lq^2 / (2 psi Ld) and Ld^2 / (2 psi Ld) */
    const num_t by_q = num_mul(HALF, num_quotient(num_quotient(params->d_full, params->q_full), params->q_full));
    const num_t by_d = num_mul(HALF, num_quotient(ONE, params->d_full));
    plan->per_d_full = num_quotient(ONE, params->d_full);
    plan->surely = (params->saliency > (num_t)0) ? (num_t)0 : num_neg(params->d_full);
    plan->share_full = num_mul(params->saliency, params->d_full);
    plan->volt_gain = num_quotient(plan->share_full, num_max(num_sub(ONE, plan->share_full), NUM_EPS));
    plan->half_square = num_mul(num_mul(params->i_max, by_q), params->i_max);
    plan->curvature = num_sub(by_q, by_d);
    return ctl_diag_ok();
}
