/**
 * @file  sim_host/plant/dc_link.h
 * @brief The dc link as a capacitor behind a rectifier: it takes what a braking motor gives back, the source never does.
 *
 *     C dv/dt = max(0, (source - v) / R) - i_bridge - g v                                                (1)
 *
 * R lies between source and capacitor, g is the mean conductance of a brake resistor. What the bridge takes over a PWM period counts
 * as energy: i_bridge is the constant current that takes it at the mean voltage of the period. (1) is then linear on either side of
 * the source's voltage, and solved exactly.
 */
#ifndef SIM_HOST_PLANT_DC_LINK_H
#define SIM_HOST_PLANT_DC_LINK_H

#include <stdbool.h>

typedef struct {
    bool   on; /**< Else the dc link is as stiff as its source. */
    double volt_v;
    double capacity_f, supply_ohm;
    double taken_ws; /**< By the bridge in this period so far; negative: given back. */
} sim_dc_link_t;

/** @param capacity_f  0: stiff */
void sim_dc_link_start(sim_dc_link_t *link, double volt_v, double capacity_f, double supply_ohm);
/** The end of a period: (1) with what the bridge has taken. @param brake_s  conductance g, >= 0 */
void sim_dc_link_period(sim_dc_link_t *link, double source_v, double brake_s, double period_s);

#endif
