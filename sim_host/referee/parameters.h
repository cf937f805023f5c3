/**
 * @file  sim_host/referee/parameters.h
 * @brief parameters.def as a struct: member group_name. The same order, nothing but doubles.
 */
#ifndef SIM_HOST_REFEREE_PARAMETERS_H
#define SIM_HOST_REFEREE_PARAMETERS_H

typedef struct {
#define REFEREE_PARAMETER(group, name, initial) double group##_##name;
#include "sim_host/referee/parameters.def"
#undef REFEREE_PARAMETER
} referee_parameters_t;

#endif
