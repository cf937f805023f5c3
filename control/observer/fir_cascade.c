#include "control/observer/fir_cascade.h"

/* Tap i of the convolution. */
static num_t convolved(const ctl_fir_params_t *first, const ctl_fir_params_t *second, num_t gain, uint16_t i)
{
    num_t h = (num_t)0;
    for (uint16_t k = (i > second->order) ? (uint16_t)(i - second->order) : 0U; (k <= i) && (k <= first->order); k++) {
        h = num_mac(h, first->tap[k], num_mul(gain, second->tap[i - k]));
    }
    return h;
}

void ctl_fir_cascade_tune(ctl_fir_cascade_t *self, const ctl_fir_params_t *first, const ctl_fir_params_t *second, num_t gain)
{
    self->order = (uint16_t)(first->order + second->order);
    for (uint16_t i = 0U; i < CTL_FIR_CASCADE_PAIRS; i++) {
        const uint16_t twice = (uint16_t)(2U * i);
        const num_t    h = (twice <= self->order) ? convolved(first, second, gain, i) : (num_t)0;
        self->fold[i] = (twice == self->order) ? num_mul(h, NUM_C(0.5f)) : h;
    }
}

num_t ctl_fir_cascade_step_unchecked(ctl_fir_cascade_t *self, num_t x)
{
    num_t y = ctl_fir_cascade_ten_pairs(self, x);
    if (self->order > CTL_FIR_CASCADE_SHORT) {
        const num_t *const newest = ctl_long_window_newest(&self->past);
        const num_t *const oldest = &newest[self->order];
        for (uint16_t i = (CTL_FIR_CASCADE_SHORT + 1U) / 2U; i < CTL_FIR_CASCADE_PAIRS; i++) {
            y = num_mac(y, self->fold[i], num_add(newest[i], oldest[-(int16_t)i]));
        }
    }
    return y;
}
