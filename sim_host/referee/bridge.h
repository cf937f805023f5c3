/**
 * @file  sim_host/referee/bridge.h
 * @brief The inverter over one PWM period: from the wanted mean voltage to the voltage at the terminals.
 *
 * Average: the wanted voltage less dead_time * pwm_hz * v_dc against each phase current. Edges: centred pulses with
 * symmetric zero sequence; the switch that goes on waits for the dead time, and while both are off a diode of the side
 * that the current chooses conducts. Close to no current the diode voltage goes over linearly, within what one step
 * changes: a current that cannot leave zero stays there (zero-current clamping) instead of chattering.
 */
#ifndef SIM_HOST_REFEREE_BRIDGE_H
#define SIM_HOST_REFEREE_BRIDGE_H

#include "sim_host/referee/machine.h"

/**
 * Advance the machine by one PWM period that begins at clock @p t_s, with the link at @p link_v. The drive makes duties
 * with the nominal link: one that differs scales the voltage.
 */
void referee_bridge_period(referee_machine_t *machine, referee_vector_t wanted_v, double link_v, double load_torque_nm,
                           double t_s);

/** Advance the machine by part of a period, with the average inverter. */
void referee_bridge_average(referee_machine_t *machine, referee_vector_t wanted_v, double link_v, double load_torque_nm,
                            double t_s, double length_s);

#endif
