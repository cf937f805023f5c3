/**
 * @file  sim_host/plant/coupling.h
 * @brief The shaft between rotor and load: a damped spring, optionally with backlash.
 *
 *     J_load = r J,  J_rotor = (1 - r) J,  mu = r (1 - r) J                                              (1)
 *     k = mu w0^2,  d = 2 zeta mu w0,  w0 = 2 pi f_res                                                   (2)
 *     torque = k (twist - side backlash/2) + d twist'   on the flank `side` (+1, -1) that is in contact      (3)
 *
 * f_res and zeta belong to the free-free mode, in which rotor and load swing against each other. With backlash a flank only
 * pushes: contact begins where the twist arrives at it and ends where (3) would pull. Without backlash contact never ends.
 */
#ifndef SIM_HOST_PLANT_COUPLING_H
#define SIM_HOST_PLANT_COUPLING_H

#include <stdbool.h>

typedef struct {
    bool   on;
    bool   has_backlash;
    double half_backlash_rad;
    double stiffness_nm_rad, damping_nms;
    double relax_s;             /**< damping / stiffness. */
    double inv_rotor, inv_load; /**< 1 / inertia. */
    double load_viscous_nms;    /**< Viscous friction of the load. */
    double resonance_rad_s;
} sim_coupling_t;

/** Off when there is no load or no resonance. */
void sim_coupling_start(sim_coupling_t *c, double inertia_kgm2, double load_ratio, double resonance_hz, double damping_ratio,
                        bool has_backlash, double backlash_rad);
/** Depth of contact with the flank @p side (+1 or -1), rad; positive: contact. */
double sim_coupling_depth(const sim_coupling_t *c, int side, double twist_rad, double twist_rad_s);
/** Flank in contact, 0: none. */
int sim_coupling_side(const sim_coupling_t *c, double twist_rad, double twist_rad_s);
/** Torque from the rotor to the load. */
double sim_coupling_torque(const sim_coupling_t *c, int side, double twist_rad, double twist_rad_s);

#endif
