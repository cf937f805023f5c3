/* The contracts of contracts.h, held against the code of num.h for every float: NaN, infinities and denormals included. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "control/numeric/num.h"

static float of_bits(uint32_t bits)
{
    float x;
    memcpy(&x, &bits, sizeof x);
    return x;
}

static bool is_good(num_t x) { return (x >= -NUM_MAX) && (x <= NUM_MAX); }

static const char *broken_by(float x)
{
    if (!is_good(num_from_float(x))) {
        return "num_from_float";
    }
#ifndef EVENSPIN_FIXED
    const bool good = isfinite(x) && (x >= -1.0e12f) && (x <= 1.0e12f);
    if (num_is_finite(x) != good) {
        return "num_is_finite";
    }
    static const float limit[][2] = {{-1.0f, 1.0f}, {0.0f, 0.0f}, {-1.0e12f, 1.0e12f}, {2.0f, 3.0f}, {-3.4e38f, -1.0e-45f}};
    for (unsigned i = 0U; i < (sizeof limit / sizeof limit[0]); i++) {
        const float y = num_clamp(x, limit[i][0], limit[i][1]);
        if (!((y >= limit[i][0]) && (y <= limit[i][1])) ||
            (isfinite(x) && (x >= 0.0f) && (limit[i][1] >= 0.0f) && !(y >= 0.0f))) {
            return "num_clamp";
        }
    }
    uint32_t    rejected = 0U;
    const float kept = num_guard(x, 0.5f, &rejected);
    const float beyond = num_guard(x, 3.0e38f, &rejected);
    if (!is_good(kept) || !isfinite(beyond) || (kept != (good ? x : 0.5f))) {
        return "num_guard";
    }
#endif
    return NULL;
}

int main(void)
{
    uint32_t bits = 0U;
    do {
        const char *const name = broken_by(of_bits(bits));
        if (name != NULL) {
            printf("%s breaks its contract for the float with bits 0x%08lx\n", name, (unsigned long)bits);
            return 1;
        }
        bits++;
    } while (bits != 0U);
    printf("the contracts hold for all 2^32 floats\n");
    return 0;
}
