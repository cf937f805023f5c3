#include "tests/sim_host/referee/support/defaults.h"

#include <string.h>

#include "sim_host/referee/referee.h"

referee_parameters_t plain_motor(void)
{
    double values[sizeof(referee_parameters_t) / sizeof(double)];
    for (size_t k = 0; k < referee_parameter_count(); k++) {
        values[k] = referee_parameter_default(k);
    }
    referee_parameters_t p;
    memcpy(&p, values, sizeof p);
    p.motor_pole_pairs = 3.0;
    p.motor_resistance_ohm = 1.0;
    p.motor_ld_h = 5e-3;
    p.motor_lq_h = 5e-3;
    p.motor_psi_wb = 0.1;
    p.motor_inertia_kgm2 = 1e-3;
    return p;
}
