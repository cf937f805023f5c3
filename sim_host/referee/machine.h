/**
 * @file  sim_host/referee/machine.h
 * @brief The machine: windings in the stationary frame, one or two masses, friction, every torque.
 *
 *     L(theta) di/dt = v - R i - w_e (dL/dtheta_e) i - e(theta, w)         trapezoidal in i, angle at mid step
 *     J dw/dt        = T_e - T_brake(theta, w, t) - friction               friction: an impulse that can only stop
 *
 * Angles advance half before and half after (the step is symmetric: second order where nothing sticks).
 */
#ifndef SIM_HOST_REFEREE_MACHINE_H
#define SIM_HOST_REFEREE_MACHINE_H

#include <stdbool.h>

#include "sim_host/referee/noise.h"
#include "sim_host/referee/parameters.h"
#include "sim_host/referee/vector.h"

typedef struct {
    /* constants of a run */
    const referee_parameters_t *p;
    double                      motor_inertia_kgm2, load_inertia_kgm2; /**< The second is 0 with one mass. */
    double                      stiffness_nm_rad, damping_nms, half_gap_rad;
    double                      holding_nm;          /**< Dry friction that is the same at standstill as in motion. */
    double                      l_mean_h, l_swing_h; /**< L(theta_e) = mean +- swing cos 2 theta_e. */
    bool                        angle_torque, time_torque;
    /* what changes slowly: once per control period */
    double resistance_ohm, psi_wb, dry_friction_nm, burst_nm, burst_left_s;
    /* state */
    double           theta_rad, speed_rad_s;           /**< Of the rotor, not wrapped. */
    double           load_theta_rad, load_speed_rad_s; /**< Angle and speed of the load; those of the rotor with one mass. */
    referee_vector_t i_a;                              /**< Stationary frame. */
    referee_vector_t i_filtered_a;                     /**< Behind the filter of the current sensors. */
    double           torque_nm;                        /**< Of the air gap, in the last step. */
    double           spring_nm;                        /**< Coulomb friction of a shaft that gives way, against rotation. */
    double           bristle_nm;                       /**< Friction before the shaft slides, against positive rotation. */
} referee_machine_t;

void referee_machine_init(referee_machine_t *self, const referee_parameters_t *p);

/** Drift, warming and random bursts: once per control period of length @p period_s at clock @p t_s. */
void referee_machine_age(referee_machine_t *self, double t_s, double period_s, referee_noise_t *noise);

/** Advance by @p h_s with the terminal voltage @p v_v (stationary frame) and the torque of the load machine. */
void referee_machine_step(referee_machine_t *self, double h_s, referee_vector_t v_v, double load_torque_nm, double t_s);

#endif
