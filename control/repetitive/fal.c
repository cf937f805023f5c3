#include "control/repetitive/fal.h"

#include "control/numeric/num_math.h"

#ifdef EVENSPIN_FIXED

static void prepare(ctl_fal_t *self) { (void)self; }

#else

#define EXPONENT_BIAS 127

/* 2^(n alpha) for |n| < 64: n alpha is up to 40, and a float would keep only 18 bits of its fraction. So alpha is split
 * into a part of 12 bits, whose products are exact, and the remainder. */
static float power_of_two(float alpha, int16_t n)
{
    const float   coarse = (float)(int32_t)(alpha * 4096.0f) * (1.0f / 4096.0f);
    const float   product = coarse * (float)n;
    const int32_t whole = num_floor(product);
    num_bits_t    scale;
    scale.bits = (uint32_t)(whole + EXPONENT_BIAS) << 23;
    return num_exp2((product - (float)whole) + ((alpha - coarse) * (float)n)) * scale.value;
}

static void prepare(ctl_fal_t *self)
{
    const float alpha = self->params.alpha;
    for (uint16_t a = 0U; a < CTL_FAL_EIGHTS; a++) {
        self->eight[a] = power_of_two(alpha, (int16_t)((8 * (CTL_FAL_FIRST_EIGHT + (int16_t)a)) - EXPONENT_BIAS));
    }
    for (uint16_t b = 0U; b < 8U; b++) {
        const float octave = power_of_two(alpha, (int16_t)b);
        for (uint16_t j = 0U; j < CTL_FAL_PARTS; j++) {
            const float    middle = 1.125f + (0.25f * (float)j);
            const uint16_t i = (uint16_t)((CTL_FAL_PARTS * b) + j);
            self->part[i].inverse = 1.0f / middle;
            self->part[i].power = octave * ((b == 0U) ? num_pow(middle, alpha) : self->part[j].power);
        }
    }
    float factor = 1.0f;
    for (uint16_t n = 0U; n < 4U; n++) {
        factor *= (alpha - (float)n) / ((float)n + 1.0f);
        self->series[n] = factor;
    }
}

#endif

static ctl_diag_t check(const ctl_fal_params_t *params, num_t *slope)
{
    ctl_diag_t d = ctl_diag_range(params->alpha, NUM_EPS, NUM_C(1.0f), CTL_FAL_ALPHA);
    ctl_diag_also(&d, params->delta, NUM_EPS, NUM_MAX, CTL_FAL_DELTA);
    if (d.status != CTL_OK) {
        return d;
    }
    *slope = num_pow(params->delta, num_sub(params->alpha, NUM_C(1.0f)));
    if (*slope >= NUM_MAX) { /* saturated: fal would jump at the knee */
        return ctl_diag(CTL_ERR_RELATION, CTL_FAL_DELTA, params->delta);
    }
    return d;
}

ctl_diag_t ctl_fal_check(const ctl_fal_params_t *params)
{
    num_t slope = (num_t)0;
    return (params != NULL) ? check(params, &slope) : ctl_diag(CTL_ERR_NULL, 0U, (num_t)0);
}

ctl_diag_t ctl_fal_init(ctl_fal_t *self, const ctl_fal_params_t *params)
{
    if ((self == NULL) || (params == NULL)) {
        return ctl_diag(CTL_ERR_NULL, 0U, (num_t)0);
    }
    num_t            slope = (num_t)0;
    const ctl_diag_t d = check(params, &slope);
    if (d.status == CTL_OK) {
        self->params = *params;
        self->slope = slope;
        prepare(self);
    }
    return d;
}

num_t ctl_fal(const ctl_fal_t *self, num_t e)
{
    return (num_abs(e) <= NUM_MAX)
               ? ctl_fal_unchecked(self, e)
               : ((e > (num_t)0) ? ctl_fal_unchecked(self, NUM_MAX)
                                 : ((e < (num_t)0) ? ctl_fal_unchecked(self, -NUM_MAX) : (num_t)0)); /* NaN: neither */
}

num_t ctl_fal_lambda(const ctl_fal_t *self, num_t e)
{
    const num_t size = num_abs(e);
    if (size > self->params.delta) {
#ifdef EVENSPIN_FIXED
        return num_min(num_pow(size, num_sub(self->params.alpha, NUM_C(1.0f))), self->slope);
#else
        const num_t cut = num_min(size, NUM_MAX);
        return num_min(ctl_fal_power(self, cut) / cut, self->slope);
#endif
    }
    return self->slope;
}
