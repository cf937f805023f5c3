#include "control/numeric/num_math.h"

#ifdef EVENSPIN_FIXED

num_t num_log2(num_t x)
{
    uint32_t m = (x > 0) ? (uint32_t)x : UINT32_C(1);
    int16_t  k = 6;                                                      /* the top bit of 2^30 stands for 2^6 */
    for (uint16_t half = 16U; half > 0U; half = (uint16_t)(half / 2U)) { /* normalise to [2^30, 2^31) */
        if (m < (UINT32_C(1) << (31U - half))) {
            m <<= half;
            k = (int16_t)(k - (int16_t)half);
        }
    }
    m >>= 6;                      /* [1, 2) in Q24 */
    if (m > UINT32_C(23726566)) { /* sqrt(2) */
        m >>= 1;
        k++;
    }
    return num_add(num_from_int(k), num_log2_reduced((num_t)m - NUM_C(1.0f)));
}

num_t num_exp2(num_t x)
{
    const int32_t k = num_floor(num_add(x, NUM_C(0.5f)));
    if (k > 7) {
        return NUM_MAX;
    }
    if (k < -26) {
        return 0;
    }
    const num_t m = num_exp2_reduced(num_sub(x, num_from_int((int16_t)k)));
    return (k >= 0) ? num_sat64((int64_t)m * (INT64_C(1) << (uint16_t)k)) : (m >> (uint16_t)-k);
}

num_t num_sqrt_portable(num_t x)
{
    if (x <= 0) {
        return 0;
    }
    uint64_t remainder = (uint64_t)x << 24;
    uint64_t root = 0U;
    for (uint64_t bit = UINT64_C(1) << 54; bit > 0U; bit >>= 2) {
        if (remainder >= (root + bit)) {
            remainder -= root + bit;
            root = (root >> 1) + bit;
        } else {
            root >>= 1;
        }
    }
    return (num_t)((remainder > root) ? (root + 1U) : root);
}

#else /* float */

num_t num_log2(num_t x)
{
    return num_log2_unchecked((x > NUM_SMALLEST_NORMAL) ? ((x > NUM_MAX) ? NUM_MAX : x) : NUM_SMALLEST_NORMAL);
}

num_t num_exp2(num_t x)
{
    if (!(x < 40.0f)) { /* log2(NUM_MAX) = 39.86 */
        return (x >= 40.0f) ? NUM_MAX : 0.0f;
    }
    return (x < -126.0f) ? 0.0f : num_min(num_exp2_unchecked(x), NUM_MAX);
}

num_t num_sqrt_newton(num_t x)
{
    num_bits_t y;
    y.value = x;
    y.bits = UINT32_C(0x5F3759DF) - (y.bits >> 1); /* 1/sqrt(x) within 3.5 %: halved and negated logarithm */
    for (uint16_t i = 0U; i < 4U; i++) {
        y.value *= 1.5f - (0.5f * x * y.value * y.value);
    }
    return x * y.value;
}

num_t num_sqrt_portable(num_t x)
{
    if (!(x > NUM_SMALLEST_NORMAL)) {
        return 0.0f;
    }
    return num_sqrt_newton((x > NUM_MAX) ? NUM_MAX : x);
}

#endif

num_t num_pow(num_t base, num_t exponent)
{
    if (!(base > (num_t)0)) {
        return (num_t)0;
    }
    return num_exp2(num_mul(exponent, num_log2(base)));
}
