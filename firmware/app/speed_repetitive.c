/* The repetitive controller of the speed loop. Main loop. */
#include "control/numeric/num_math.h"
#include "firmware/app/internal.h"

/* What fal's gain becomes when its argument is per unit; 1 in the float build. */
static float fal_gain_scale(float unit, float alpha)
{
#ifdef EVENSPIN_FIXED
    /* fal(x u) = u^alpha fal'(x) with u = error_unit; inside, everything is divided by u again: u^(alpha - 1). So it is for
     * lambda(x u), too, which multiplies the output.
     * unit^(alpha-1) = 2^((alpha-1) log2 unit), with unit = m 2^k so that both parts are in range */
    float   m = unit;
    int16_t k = 0;
    while (m >= 2.0f) {
        m *= 0.5f;
        k++;
    }
    while (m < 1.0f) {
        m *= 2.0f;
        k--;
    }
    const float log2_unit = (float)k + num_to_float(num_log2(num_from_float(m)));
    return num_to_float(num_exp2(num_from_float((alpha - 1.0f) * log2_unit)));
#else
    (void)unit;
    (void)alpha;
    return 1.0f;
#endif
}

uint16_t drive_make_repetitive(const drive_params_t *p, const drive_scale_t *scale, drive_speed_setup_t *s)
{
    const float ts_s = (float)p->speed_divider / (float)DRIVE_PWM_HZ;
    uint16_t    culprit = PARAM_COUNT;
    const bool  fal = p->method == (uint16_t)DRIVE_METHOD_FAL_FORC;
    const float fal_scale = fal ? fal_gain_scale(scale->error_unit, p->rc_fal_alpha) : 1.0f;

    s->rc_used = (p->method >= (uint16_t)DRIVE_METHOD_CRC) && (p->method <= (uint16_t)DRIVE_METHOD_FAL_FORC);
    s->rc.gain = num_from_float(p->rc_gain * fal_scale);
    s->rc.lead = p->rc_lead;
    s->rc.q.side = num_from_float(p->rc_q_side);
    s->rc.q.centre = num_from_float(p->rc_q_centre);
    s->rc.q.side2 = num_from_float(p->rc_q_side2);
    s->rc.order = (p->method == (uint16_t)DRIVE_METHOD_CRC) ? 0U : p->rc_order;
    s->rc.truncate = p->rc_truncate != 0U;
    s->rc.fal_at = fal ? ((p->rc_fal_at == 0U) ? CTL_RC_FAL_INPUT : CTL_RC_FAL_OUTPUT) : CTL_RC_FAL_NONE;
    s->rc.fal.alpha = num_from_float(p->rc_fal_alpha);
    s->rc.fal.delta = num_from_float(p->rc_fal_delta / scale->error_unit);
    s->rc.memory = (ctl_rc_memory_t)p->rc_memory;
    /* fal at the output: what it will multiply is smaller by this than what leaves the controller */
    s->rc.limit = num_from_float(p->rc_limit_unit / scale->error_unit * ((s->rc.fal_at == CTL_RC_FAL_OUTPUT) ? fal_scale : 1.0f));
    s->rc.freeze_above = num_from_float(p->rc_freeze_above_unit / scale->error_unit);
    s->rc.freeze_samples = p->rc_freeze_samples;
    s->rc.hold = p->observer_hold != 0U;
    s->rc_capacity = (p->rc_memory == (uint16_t)CTL_RC_ANGLE) ? p->rc_cells : (uint16_t)DRIVE_RC_CAPACITY;
    if (s->rc_used) {
        s->rc_period_scale =
            drive_fitted(DRIVE_TWO_PI / ((float)p->pole_pairs * ts_s * scale->speed_rad_s), PARAM_over_speed_rad_s, &culprit);
    }
    return culprit;
}

/* Which parameter a block meant. */
static uint16_t rc_culprit(uint16_t field)
{
    static const uint16_t PARAM_OF[] = {[0] = PARAM_COUNT,
                                        [CTL_RC_GAIN] = PARAM_rc_gain,
                                        [CTL_RC_LEAD] = PARAM_rc_lead,
                                        [CTL_RC_Q] = PARAM_rc_q_centre,
                                        [CTL_RC_ORDER] = PARAM_rc_order,
                                        [CTL_RC_FAL_AT] = PARAM_rc_fal_at,
                                        [CTL_RC_FAL_ALPHA] = PARAM_rc_fal_alpha,
                                        [CTL_RC_FAL_DELTA] = PARAM_rc_fal_delta,
                                        [CTL_RC_MEMORY] = PARAM_rc_memory,
                                        [CTL_RC_LIMIT] = PARAM_rc_limit_unit,
                                        [CTL_RC_FREEZE] = PARAM_rc_freeze_above_unit,
                                        [CTL_RC_CAPACITY] = PARAM_rc_cells};
    return (field < (sizeof PARAM_OF / sizeof PARAM_OF[0])) ? PARAM_OF[field] : (uint16_t)PARAM_rc_gain;
}

uint16_t drive_judge_repetitive(const drive_speed_setup_t *s)
{
    if (!s->rc_used) {
        return PARAM_COUNT;
    }
    const ctl_diag_t r = ctl_rc_check(&s->rc, s->rc_capacity);
    return (r.status == CTL_OK) ? (uint16_t)PARAM_COUNT : rc_culprit(r.field);
}

void drive_build_repetitive(drive_speed_t *v, const drive_speed_setup_t *s, num_t *memory)
{
    if (s->rc_used) {
        (void)ctl_rc_init(&v->rc, &s->rc, memory, s->rc_capacity);
    }
}

bool drive_repetitive_differs(const drive_speed_setup_t *before, const drive_speed_setup_t *s)
{
    const bool same = before->rc_used && (before->rc.memory == s->rc.memory) && (before->rc_capacity == s->rc_capacity) &&
                      (before->rc.order == s->rc.order) && (before->rc.lead == s->rc.lead) &&
                      (before->rc.q.side2 == s->rc.q.side2);
    return s->rc_used && !same;
}
