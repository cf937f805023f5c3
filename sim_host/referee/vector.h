/**
 * @file  sim_host/referee/vector.h
 * @brief Two-axis quantities: stationary frame (alpha on phase a) or rotating frame (d, q). Amplitude-invariant.
 */
#ifndef SIM_HOST_REFEREE_VECTOR_H
#define SIM_HOST_REFEREE_VECTOR_H

typedef struct {
    double x; /**< alpha or d */
    double y; /**< beta or q */
} referee_vector_t;

#define REFEREE_PI 3.14159265358979323846
#define REFEREE_SQRT_3 1.73205080756887729353

#endif
