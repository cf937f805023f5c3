/**
 * @file  sim_host/plant/delay.h
 * @brief Delay line of the bridge: duties of the last periods, read a whole or fractional number of periods later.
 */
#ifndef SIM_HOST_PLANT_DELAY_H
#define SIM_HOST_PLANT_DELAY_H

#include "sim_host/plant/effect.h"

typedef struct {
    double past[SIM_DELAY_PERIODS + 2][3];
    int    newest;
    int    whole; /**< Whole periods of the delay. */
    double part;  /**< Fraction of a period beyond those, [0, 1). */
} sim_delay_t;

void sim_delay_start(sim_delay_t *d, double periods);
/** The duties of a new period come in. */
void sim_delay_push(sim_delay_t *d, const double duty[3]);
/** Duties before and after the time `part` of this period. */
const double *sim_delay_first(const sim_delay_t *d);
const double *sim_delay_second(const sim_delay_t *d);

#endif
