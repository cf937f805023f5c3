/**
 * @file  sim_host/referee/controller.h
 * @brief The controller of the measured-log format, written from its text: PLL, speed PI every 10th period, current PI.
 */
#ifndef SIM_HOST_REFEREE_CONTROLLER_H
#define SIM_HOST_REFEREE_CONTROLLER_H

#include <stdbool.h>

#include "sim_host/referee/parameters.h"
#include "sim_host/referee/sensors.h"
#include "sim_host/referee/vector.h"

typedef struct {
    double speed_ref_rad_s, id_ref_a, iq_ref_a;
    bool   current_mode;
} referee_wish_t;

typedef struct {
    const referee_parameters_t *p;
    double                      pll_theta_rad, speed_rad_s;
    double                      speed_integral_a;
    referee_vector_t            integral_v;
    unsigned                    period; /**< Modulo the periods of the speed loop. */
    bool                        was_current_mode;
    /* what is logged */
    referee_vector_t ref_a, i_a, v_v; /**< Drive's frame. */
} referee_controller_t;

/** @p theta_m_rad: measured at the start. */
void referee_controller_init(referee_controller_t *self, const referee_parameters_t *p, double theta_m_rad);

/** One control period: the voltage to apply, stationary frame, in the period after the next sample. */
referee_vector_t referee_controller_step(referee_controller_t *self, const referee_sample_t *sample, const referee_wish_t *wish);

#endif
