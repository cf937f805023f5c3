#include "control/observer/torque_meter.h"

ctl_diag_t ctl_meter_check(const ctl_meter_params_t *params)
{
    ctl_diag_t d = ctl_diag_range(params->speed_per_rad, NUM_EPS, NUM_MAX, CTL_METER_SPEED);
    ctl_diag_also(&d, params->torque_per_16, NUM_EPS, NUM_MAX, CTL_METER_TORQUE);
    ctl_diag_also(&d, params->a22, (num_t)0, NUM_C(1.0f), CTL_METER_A22);
    ctl_diag_also(&d, params->actuation, NUM_C(0.5f), NUM_C(12.0f), CTL_METER_ACTUATION);
    ctl_diag_also(&d, params->step_max_rad, NUM_EPS, NUM_C(3.1416f), CTL_METER_STEP);
    if (d.status == CTL_OK) {
        d = ctl_fir_check(&params->fir1);
        d.field = (d.status == CTL_OK) ? 0U : (uint16_t)CTL_METER_FIR1;
    }
    if (d.status == CTL_OK) {
        d = ctl_fir_check(&params->fir2);
        d.field = (d.status == CTL_OK) ? 0U : (uint16_t)CTL_METER_FIR2;
    }
    return d;
}

ctl_diag_t ctl_meter_init(ctl_meter_t *self, const ctl_meter_params_t *params)
{
    if ((self == NULL) || (params == NULL)) {
        return ctl_diag(CTL_ERR_NULL, 0U, (num_t)0);
    }
    const ctl_diag_t d = ctl_meter_check(params);
    if (d.status == CTL_OK) {
        (void)ctl_fir_init(&self->state.speed_fir, &params->fir1);
        self->state.rejected = 0U;
        ctl_meter_tune(self, params);
        ctl_meter_reset(self);
    }
    return d;
}

void ctl_meter_prepare(ctl_meter_t *self, const ctl_meter_params_t *params)
{
    self->prepared.whole = (uint16_t)num_floor(params->actuation);
    self->prepared.part = num_sub(params->actuation, num_from_int((int16_t)self->prepared.whole));
    self->prepared.is_short =
        ((params->fir1.order + params->fir2.order) <= CTL_FIR_CASCADE_SHORT) && (params->step_max_rad < NUM_C(1.57f));
}

void ctl_meter_tune(ctl_meter_t *self, const ctl_meter_params_t *params)
{
    ctl_meter_prepare(self, params);
    ctl_meter_take_prepared(self, params);
    self->params.fir1 = params->fir1;
    self->params.fir2 = params->fir2;
    ctl_fir_tune(&self->state.speed_fir, &params->fir1);
    ctl_fir_cascade_tune(&self->state.torque_fir, &params->fir1, &params->fir2, NUM_C(16.0f));
}

void ctl_meter_reset(ctl_meter_t *self)
{
    ctl_meter_state_t *const s = &self->state;
    ctl_fir_reset(&s->speed_fir, (num_t)0);
    ctl_fir_cascade_reset(&s->torque_fir, (num_t)0);
    ctl_window_fill(&s->ref, (num_t)0);
    s->primed = false;
    s->speed = (num_t)0;
    s->below = 0U;
}

num_t ctl_meter_speed_unchecked(ctl_meter_t *self) { return ctl_fir_step_unchecked(&self->state.speed_fir, self->state.speed); }

void ctl_meter_resume_speed(ctl_meter_t *self) { ctl_fir_reset(&self->state.speed_fir, self->state.speed); }

num_t ctl_meter_torque_unchecked(ctl_meter_t *self, angle_t theta, num_t ref_last)
{
    ctl_meter_state_t *const s = &self->state;
    const num_t              travel = ctl_meter_travel(self, theta);
    num_t                    speed = num_mul(travel, self->params.speed_per_rad);
    if (!s->primed) {
        s->primed = true;
        s->theta = theta; /* no step */
        speed = (num_t)0;
    } else if (num_abs(travel) > self->params.step_max_rad) {
        num_count(&s->rejected);
        speed = s->speed;
    } else {
        /* as it should be */
    }
    return ctl_fir_cascade_step_unchecked(&s->torque_fir, ctl_meter_gather(self, theta, speed, ref_last)); /* (4) */
}

uint16_t ctl_meter_age_half(const ctl_meter_params_t *params)
{
    return (uint16_t)(2U + ctl_fir_delay_half(&params->fir1) + ctl_fir_delay_half(&params->fir2));
}

ctl_meter_out_t ctl_meter_step(ctl_meter_t *self, angle_t theta, num_t ref_last)
{
    ctl_meter_state_t *const s = &self->state;
    const num_t              before = num_mul(ctl_window_newest(&s->ref)[0], NUM_C(16.0f));
    const num_t              torque = ctl_meter_torque_unchecked(self, theta, num_guard(ref_last, before, &s->rejected));
    const ctl_meter_out_t    out = {ctl_meter_speed_unchecked(self), torque};
    return out;
}
