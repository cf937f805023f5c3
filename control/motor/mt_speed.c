#include "control/motor/mt_speed.h"

ctl_diag_t ctl_mt_init(ctl_mt_t *self, const ctl_mt_params_t *params)
{
    if ((self == NULL) || (params == NULL)) {
        return ctl_diag(CTL_ERR_NULL, 0U, (num_t)0);
    }
    if (params->sample_cyc == 0U) {
        return ctl_diag(CTL_ERR_RANGE, CTL_MT_SAMPLE, (num_t)0);
    }
    ctl_diag_t d = ctl_diag_range(params->speed_1_count, NUM_EPS, NUM_MAX, CTL_MT_SPEED_1_COUNT);
    ctl_diag_also(&d, params->speed_max, NUM_EPS, NUM_MAX, CTL_MT_SPEED_MAX);
    if ((d.status == CTL_OK) && (params->stop_samples == 0U)) {
        d = ctl_diag(CTL_ERR_RANGE, CTL_MT_STOP, (num_t)0);
    }
    if (d.status != CTL_OK) {
        return d;
    }
    self->params = *params;
    ctl_mt_reset(self);
    return d;
}

void ctl_mt_reset(ctl_mt_t *self)
{
    const ctl_mt_state_t rest = {0, 0U, 0U, false, (num_t)0};
    self->state = rest;
}

/* counts over time, in speed units; any counts: what no motor does ends at speed_max. */
static num_t speed_of(const ctl_mt_params_t *p, int32_t counts, uint32_t cycles)
{
#ifdef EVENSPIN_FIXED
    const num_t travel = num_sat64((int64_t)counts * p->speed_1_count); /* speed unit, if it took one sample time */
    const num_t samples = num_sat64((int64_t)(((uint64_t)cycles << 24) / p->sample_cyc));
    const num_t value = (travel != 0) ? num_div(travel, samples) : 0;
#else
    const num_t value = num_div((num_t)counts * p->speed_1_count * (num_t)p->sample_cyc, (num_t)cycles);
#endif
    return num_clamp(value, num_neg(p->speed_max), p->speed_max);
}

num_t ctl_mt_step(ctl_mt_t *self, int32_t edge_count, uint32_t edge_cyc, uint32_t now_cyc)
{
    const ctl_mt_params_t *const p = &self->params;
    ctl_mt_state_t *const        s = &self->state;

    const bool new_edge = edge_cyc != s->edge_cyc;
    if (!s->primed || new_edge) {
        /* After a standstill the clock may have wrapped since the last edge: the new one only starts the next interval. */
        if (s->primed && (s->idle_samples < p->stop_samples)) {
            /* after a reversal the same edge is passed again: no travel in between, mean speed 0 */
            s->speed = speed_of(p, (int32_t)((uint32_t)edge_count - (uint32_t)s->edge_count), edge_cyc - s->edge_cyc);
        }
        s->primed = true;
        s->edge_count = edge_count;
        s->edge_cyc = edge_cyc;
        s->idle_samples = 0U;
        return s->speed;
    }
    if (s->idle_samples < p->stop_samples) {
        s->idle_samples++;
        const num_t ceiling = speed_of(p, 1, now_cyc - s->edge_cyc);
        s->speed = num_clamp(s->speed, num_neg(ceiling), ceiling);
    } else {
        s->speed = (num_t)0;
    }
    return s->speed;
}
