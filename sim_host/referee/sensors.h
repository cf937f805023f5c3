/**
 * @file  sim_host/referee/sensors.h
 * @brief What the drive gets to see: two phase currents, encoder counts, the dc link, the torque of the load machine.
 */
#ifndef SIM_HOST_REFEREE_SENSORS_H
#define SIM_HOST_REFEREE_SENSORS_H

#include "sim_host/referee/machine.h"

typedef struct {
    double ia_a, ib_a;
    double theta_m_rad; /**< Whole counts, [0, 2 pi). */
} referee_sample_t;

referee_sample_t referee_sensors_sample(const referee_machine_t *machine, referee_noise_t *noise);

#endif
