#include "sim_host/referee/foreign.h"

#include <math.h>

double referee_foreign_torque(const referee_parameters_t *p, double theta_rad, double speed_rad_s)
{
    double brake_nm = 0.0;
    if (p->pump_load_torque_nm_s2 != 0.0) {
        const double pulse = 1.0 + (p->pump_load_pulse_rel * sin((p->pump_load_order * theta_rad) + p->pump_load_phase_rad));
        brake_nm += p->pump_load_torque_nm_s2 * speed_rad_s * fabs(speed_rad_s) * pulse;
    }
    if (p->position_load_amplitude_nm != 0.0) {
        const double x = (theta_rad - p->position_load_centre_rad) / p->position_load_width_rad;
        brake_nm += p->position_load_amplitude_nm * exp(-x * x);
    }
    return brake_nm;
}

double referee_foreign_bristle(const referee_parameters_t *p, double torque_nm, double moved_rad)
{
    const double end_nm = copysign(p->presliding_torque_nm, moved_rad);
    return end_nm + ((torque_nm - end_nm) * exp(-fabs(moved_rad) / p->presliding_length_rad));
}

referee_cross_t referee_foreign_cross(const referee_parameters_t *p, referee_vector_t i_a, double c, double s,
                                      double speed_e_rad_s)
{
    const double k = p->cross_saturation_wb_per_a2;
    const double id = (i_a.x * c) + (i_a.y * s);
    const double iq = (i_a.y * c) - (i_a.x * s);
    /* linkage_d = -k iq^2 / 2, linkage_q = -k id iq; differential [0 m; m n] in the rotor frame */
    const double d_wb = -0.5 * k * iq * iq;
    const double q_wb = -k * id * iq;
    const double m_h = -k * iq;
    const double n_h = -k * id;
    const double c2 = (c * c) - (s * s);
    const double s2 = 2.0 * s * c;
    /* v = dlinkage/dt in the rotor frame + w J linkage, less what the turning frame does to the currents */
    const double turn_d = -speed_e_rad_s * (q_wb - (m_h * -id));
    const double turn_q = speed_e_rad_s * (d_wb - ((m_h * -iq) + (n_h * id)));
    return (referee_cross_t){
        .a_h = (-m_h * s2) + (n_h * s * s),
        .b_h = (m_h * c2) - (n_h * s * c),
        .d_h = (m_h * s2) + (n_h * c * c),
        .turning_v = {(turn_d * c) - (turn_q * s), (turn_d * s) + (turn_q * c)},
        .torque_wb_a = (d_wb * iq) - (q_wb * id),
    };
}
