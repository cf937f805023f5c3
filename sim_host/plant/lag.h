/**
 * @file  sim_host/plant/lag.h
 * @brief First-order low-pass y' = (u - y) / tau, exact for an input that is a cubic over the step.
 */
#ifndef SIM_HOST_PLANT_LAG_H
#define SIM_HOST_PLANT_LAG_H

/** Input at both ends of a step, and its slopes there per second. */
typedef struct {
    double u0, u1, slope0, slope1;
} sim_lag_input_t;

/** What a step of h seconds does to any input: made once per step. */
typedef struct {
    double h_s;
    double weight[5]; /**< Of y and of the four coefficients of the cubic in t / h. */
} sim_lag_t;

void   sim_lag_prepare(sim_lag_t *lag, double tau_s, double h_s);
double sim_lag_step(const sim_lag_t *lag, const sim_lag_input_t *in, double y);

#endif
