#include "sim_host/plant/random.h"

#include <math.h>

static uint64_t rotate(uint64_t x, int k) { return (x << k) | (x >> (64 - k)); }

void sim_random_seed(sim_random_t *r, uint64_t seed)
{
    uint64_t x = seed;
    for (int i = 0; i < 4; i++) {
        x += UINT64_C(0x9E3779B97F4A7C15);
        uint64_t z = x;
        z = (z ^ (z >> 30)) * UINT64_C(0xBF58476D1CE4E5B9);
        z = (z ^ (z >> 27)) * UINT64_C(0x94D049BB133111EB);
        r->s[i] = z ^ (z >> 31);
    }
}

static uint64_t next(sim_random_t *r)
{
    uint64_t *const s = r->s;
    const uint64_t  result = rotate(s[0] + s[3], 23) + s[0];
    const uint64_t  t = s[1] << 17;
    s[2] ^= s[0];
    s[3] ^= s[1];
    s[1] ^= s[2];
    s[0] ^= s[3];
    s[2] ^= t;
    s[3] = rotate(s[3], 45);
    return result;
}

double sim_random_uniform(sim_random_t *r) { return (double)(next(r) >> 11) * 0x1.0p-53; }

/* Marsaglia's polar method. */
void sim_random_normal2(sim_random_t *r, double out[2])
{
    double x, y, q;
    do {
        x = 2.0 * sim_random_uniform(r) - 1.0;
        y = 2.0 * sim_random_uniform(r) - 1.0;
        q = x * x + y * y;
    } while ((q >= 1.0) || (q == 0.0));
    const double k = sqrt(-2.0 * log(q) / q);
    out[0] = x * k;
    out[1] = y * k;
}
