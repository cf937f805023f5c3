#include "sim_host/plant/coupling.h"

#define TWO_PI 6.28318530717958647693

void sim_coupling_start(sim_coupling_t *c, double inertia_kgm2, double load_ratio, double resonance_hz, double damping_ratio,
                        bool has_backlash, double backlash_rad)
{
    static const sim_coupling_t rigid;
    *c = rigid;
    if (!(load_ratio > 0.0) || !(resonance_hz > 0.0)) {
        return;
    }
    const double reduced = load_ratio * (1.0 - load_ratio) * inertia_kgm2; /* (1) */
    c->on = true;
    c->has_backlash = has_backlash;
    c->half_backlash_rad = has_backlash ? 0.5 * backlash_rad : 0.0;
    c->resonance_rad_s = TWO_PI * resonance_hz;
    c->stiffness_nm_rad = reduced * c->resonance_rad_s * c->resonance_rad_s; /* (2) */
    c->damping_nms = 2.0 * damping_ratio * reduced * c->resonance_rad_s;
    c->relax_s = c->damping_nms / c->stiffness_nm_rad;
    c->inv_rotor = 1.0 / ((1.0 - load_ratio) * inertia_kgm2);
    c->inv_load = 1.0 / (load_ratio * inertia_kgm2);
}

/* Both the travel into the flank and the torque (3), expressed as travel, must be positive. */
double sim_coupling_depth(const sim_coupling_t *c, int side, double twist_rad, double twist_rad_s)
{
    const double travel = side * twist_rad - c->half_backlash_rad;
    const double push = travel + side * twist_rad_s * c->relax_s;
    return (travel < push) ? travel : push;
}

int sim_coupling_side(const sim_coupling_t *c, double twist_rad, double twist_rad_s)
{
    if (!c->has_backlash || (sim_coupling_depth(c, 1, twist_rad, twist_rad_s) > 0.0)) {
        return 1;
    }
    return (sim_coupling_depth(c, -1, twist_rad, twist_rad_s) > 0.0) ? -1 : 0;
}

double sim_coupling_torque(const sim_coupling_t *c, int side, double twist_rad, double twist_rad_s)
{
    return (side == 0) ? 0.0 : c->stiffness_nm_rad * (twist_rad - side * c->half_backlash_rad) + c->damping_nms * twist_rad_s;
}
