/**
 * @file  sim_host/referee/referee.h
 * @brief A second drive simulator that shares no code with the first one, to check what the tools conclude from logs.
 *
 * Stationary-frame phase model, fixed fine step, trapezoidal rule for the currents, dry friction as an impulse per step,
 * bridge as average voltage or edge by edge with dead time; the controller, encoder and logging of the measured-log
 * format (docs/log-format.md). Everything is double; a run is a pure function of what it is given.
 */
#ifndef SIM_HOST_REFEREE_REFEREE_H
#define SIM_HOST_REFEREE_REFEREE_H

#include <stddef.h>

#ifdef __cplusplus
extern "C" {
#endif

int referee_abi_version(void);

/** Parameters in their order (parameters.def); names are "group.name". NULL or 0 beyond the last. */
size_t      referee_parameter_count(void);
const char *referee_parameter_name(size_t index);
double      referee_parameter_default(size_t index);

/** Columns of a record in their order (signals.def). */
size_t      referee_signal_count(void);
const char *referee_signal_name(size_t index);

/** Inputs, one value per control period. */
typedef struct {
    const double *speed_ref_rad_s;
    const double *id_ref_a;
    const double *iq_ref_a;       /**< Used in current mode. */
    const double *load_torque_nm; /**< Brakes positive rotation; of the load machine. */
    const double *current_mode;   /**< Not 0: current mode. */
} referee_inputs_t;

/**
 * Simulate `periods` control periods from rest; every `decimate`-th is logged, the first is.
 * @param  parameters  referee_parameter_count() values.
 * @param  log         rows x referee_signal_count(), rows = ceil(periods / decimate).
 * @return 0; n > 0: parameter n - 1 is not finite or out of its domain; -1: a pointer or a count is missing.
 */
int referee_run(const double *parameters, const referee_inputs_t *inputs, size_t periods, size_t decimate, double *log);

#ifdef __cplusplus
}
#endif

#endif
