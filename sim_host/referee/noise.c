#include "sim_host/referee/noise.h"

#include <math.h>

static uint64_t rotate(uint64_t x, int bits) { return (x << bits) | (x >> (64 - bits)); }

void referee_noise_seed(referee_noise_t *self, uint64_t seed)
{
    for (int k = 0; k < 4; k++) {
        seed += UINT64_C(0x9e3779b97f4a7c15);
        uint64_t z = seed;
        z = (z ^ (z >> 30)) * UINT64_C(0xbf58476d1ce4e5b9);
        z = (z ^ (z >> 27)) * UINT64_C(0x94d049bb133111eb);
        self->word[k] = z ^ (z >> 31);
    }
    self->spare = 0.0;
    self->has_spare = false;
}

static uint64_t next(referee_noise_t *self)
{
    uint64_t *const s = self->word;
    const uint64_t  result = rotate(s[1] * 5U, 7) * 9U;
    const uint64_t  t = s[1] << 17;
    s[2] ^= s[0];
    s[3] ^= s[1];
    s[1] ^= s[2];
    s[0] ^= s[3];
    s[2] ^= t;
    s[3] = rotate(s[3], 45);
    return result;
}

double referee_noise_uniform(referee_noise_t *self) { return (double)(next(self) >> 11) * 0x1.0p-53; }

double referee_noise_normal(referee_noise_t *self)
{
    if (self->has_spare) {
        self->has_spare = false;
        return self->spare;
    }
    double x;
    double y;
    double square;
    do {
        x = (2.0 * referee_noise_uniform(self)) - 1.0;
        y = (2.0 * referee_noise_uniform(self)) - 1.0;
        square = (x * x) + (y * y);
    } while (square >= 1.0 || square == 0.0);
    const double scale = sqrt(-2.0 * log(square) / square);
    self->spare = y * scale;
    self->has_spare = true;
    return x * scale;
}
