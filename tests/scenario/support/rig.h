/**
 * @file  tests/scenario/support/rig.h
 * @brief A simulated drive through the C interface: settings that may not fail, runs, readings.
 */
#ifndef TESTS_SCENARIO_SUPPORT_RIG_H
#define TESTS_SCENARIO_SUPPORT_RIG_H

#include <math.h>
#include <string.h>

#include "sim_host/capi/evenspin_capi.h"
#include "tests/support/numeric.h"
#include "unity.h"

extern es_sim_t *rig;

/** A new drive that runs at once: no calibration, no alignment. */
void rig_new(void);
void rig_free(void);

void rig_model(const char *name, double value);
void rig_param(const char *name, double value);
void rig_effect(const char *effect, const char *param, double value);
/** A constant, or a step from one value to another. */
void rig_input(const char *name, double value);
void rig_step(const char *name, double before, double at_s, double after);
void rig_start(void);

void   rig_run(int64_t periods);
double rig_read(const char *signal);
/** Name of the fault now. */
const char *rig_fault(void);

#endif
