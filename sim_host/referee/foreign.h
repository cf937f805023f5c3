/**
 * @file  sim_host/referee/foreign.h
 * @brief What the vocabulary of the measured-log format does not have and is more than a term of a sum: a pump, a position
 *        with more load, friction that gives way before it slides, and an inductance from one axis to the other.
 */
#ifndef SIM_HOST_REFEREE_FOREIGN_H
#define SIM_HOST_REFEREE_FOREIGN_H

#include "sim_host/referee/parameters.h"
#include "sim_host/referee/vector.h"

/** Torque against positive rotation of pump and position. */
double referee_foreign_torque(const referee_parameters_t *p, double theta_rad, double speed_rad_s);

/** Torque of a bristle that was @p torque_nm, after the shaft has moved by @p moved_rad (Dahl 1968, exponent 1). */
double referee_foreign_bristle(const referee_parameters_t *p, double torque_nm, double moved_rad);

/** Cross saturation, all in the stationary frame: inductance [a b; b d] that is added, and the voltage that turning makes. */
typedef struct {
    double           a_h, b_h, d_h;
    referee_vector_t turning_v;
    double           torque_wb_a; /**< Added to psi iq. */
} referee_cross_t;

referee_cross_t referee_foreign_cross(const referee_parameters_t *p, referee_vector_t i_a, double c, double s,
                                      double speed_e_rad_s);

#endif
