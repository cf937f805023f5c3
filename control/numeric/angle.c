#include "control/numeric/angle.h"

angle_t angle_from_rad(num_t rad)
{
    return ((rad <= ANGLE_RAD_MAX) && (rad >= -ANGLE_RAD_MAX)) ? angle_from_rad_unchecked(rad) : 0U;
}

/* t: angle in quarter turns, within +-1/2. Minimax fits, errors 3.3e-9 (relative, sine) and 5.4e-11 (cosine). */
static num_t sine_reduced(num_t t)
{
    const num_t t2 = num_mul(t, t);
    num_t       p = NUM_C(-0.004601657886f);
    p = num_mac(NUM_C(0.079680032768f), p, t2);
    p = num_mac(NUM_C(-0.645963460233f), p, t2);
    p = num_mac(NUM_C(1.570796321708f), p, t2);
    return num_mul(p, t);
}

static num_t cosine_reduced(num_t t)
{
    const num_t t2 = num_mul(t, t);
    num_t       p = NUM_C(9.040216696e-4f);
    p = num_mac(NUM_C(-0.02086028851f), p, t2);
    p = num_mac(NUM_C(0.2536692440f), p, t2);
    p = num_mac(NUM_C(-1.233700543f), p, t2);
    return num_mac(NUM_C(1.0f), p, t2);
}

void angle_sincos_portable(angle_t angle, num_t *sine, num_t *cosine)
{
    const uint16_t quadrant = (uint16_t)((angle + (ANGLE_QUARTER / 2U)) >> 30);
    const int32_t  remainder = (int32_t)(angle - ((angle_t)quadrant << 30));
#ifdef EVENSPIN_FIXED
    const num_t t = remainder >> 6;
#else
    const num_t t = (num_t)remainder * 9.31322574615478515625e-10f; /* 2^-30 */
#endif
    const num_t s = sine_reduced(t);
    const num_t c = cosine_reduced(t);

    const num_t sin_abs = ((quadrant & 1U) != 0U) ? c : s;
    const num_t cos_abs = ((quadrant & 1U) != 0U) ? s : c;
    *sine = ((quadrant & 2U) != 0U) ? num_neg(sin_abs) : sin_abs;
    *cosine = (((quadrant + 1U) & 2U) != 0U) ? num_neg(cos_abs) : cos_abs;
}
