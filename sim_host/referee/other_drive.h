/**
 * @file  sim_host/referee/other_drive.h
 * @brief A controller that is not that of the measured-log format, in the kinds that benches have (parameters.def,
 *        group other): speed by a PLL or by filtered differences, PI or IP speed loop, maximum torque per ampere on a
 *        salient machine, voltage feed-forward, an angle that comes late as that of a sensorless observer, a voltage
 *        that acts in the same or in the next period.
 */
#ifndef SIM_HOST_REFEREE_OTHER_DRIVE_H
#define SIM_HOST_REFEREE_OTHER_DRIVE_H

#include "sim_host/referee/controller.h"

typedef struct {
    const referee_parameters_t *p;
    double                      theta_m_rad; /**< The drive's angle, mechanical, not wrapped. */
    double                      pll_rad, pll_rad_s;
    double                      tick_rad, filtered_rad_s, speed_rad_s;
    double                      torque_a, speed_integral_a; /**< Current that the speed loop asks for. */
    referee_vector_t            integral_v;
    unsigned                    period;
    referee_vector_t            ref_a, i_a, v_v; /**< Drive's frame. */
} referee_other_drive_t;

/** @p theta_m_rad: measured at the start. */
void referee_other_drive_init(referee_other_drive_t *self, const referee_parameters_t *p, double theta_m_rad);

/** One control period: the voltage to apply, stationary frame. */
referee_vector_t referee_other_drive_step(referee_other_drive_t *self, const referee_sample_t *sample,
                                          const referee_wish_t *wish);

#endif
