/**
 * @file  sim_host/plant/whole.h
 * @brief floor() for |x| < 2^62, without a call.
 */
#ifndef SIM_HOST_PLANT_WHOLE_H
#define SIM_HOST_PLANT_WHOLE_H

#include <stdint.h>

static inline int64_t sim_whole_below(double x)
{
    const int64_t cut = (int64_t)x;
    return ((double)cut > x) ? cut - 1 : cut;
}

#endif
