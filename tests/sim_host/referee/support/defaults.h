/** A plain motor without effects for the tests of the referee: 1 ohm, 5 ms, 3 pole pairs. */
#ifndef TESTS_SIM_HOST_REFEREE_SUPPORT_DEFAULTS_H
#define TESTS_SIM_HOST_REFEREE_SUPPORT_DEFAULTS_H

#include "sim_host/referee/parameters.h"

referee_parameters_t plain_motor(void);

#endif
