/**
 * @file  sim_host/plant/random.h
 * @brief Reproducible noise: xoshiro256++ (Blackman and Vigna) seeded by splitmix64; normal numbers in pairs.
 */
#ifndef SIM_HOST_PLANT_RANDOM_H
#define SIM_HOST_PLANT_RANDOM_H

#include <stdint.h>

typedef struct {
    uint64_t s[4];
} sim_random_t;

void sim_random_seed(sim_random_t *r, uint64_t seed);
/** Uniform in [0, 1). */
double sim_random_uniform(sim_random_t *r);
/** Two independent normal numbers, mean 0, standard deviation 1. */
void sim_random_normal2(sim_random_t *r, double out[2]);

#endif
