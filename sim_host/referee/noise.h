/**
 * @file  sim_host/referee/noise.h
 * @brief Random numbers: xoshiro256** (Blackman, Vigna 2018), seeded by splitmix64; normal by Marsaglia's polar method.
 */
#ifndef SIM_HOST_REFEREE_NOISE_H
#define SIM_HOST_REFEREE_NOISE_H

#include <stdbool.h>
#include <stdint.h>

typedef struct {
    uint64_t word[4];
    double   spare; /**< The second of a pair of normal numbers. */
    bool     has_spare;
} referee_noise_t;

void   referee_noise_seed(referee_noise_t *self, uint64_t seed);
double referee_noise_uniform(referee_noise_t *self); /**< [0, 1). */
double referee_noise_normal(referee_noise_t *self);  /**< Mean 0, standard deviation 1. */

#endif
