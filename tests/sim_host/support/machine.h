/**
 * @file  tests/sim_host/support/machine.h
 * @brief A simulated machine for tests: model and effects to change, then a start, then periods of known voltage.
 */
#ifndef TESTS_SIM_HOST_SUPPORT_MACHINE_H
#define TESTS_SIM_HOST_SUPPORT_MACHINE_H

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

#include "sim_host/plant/plant.h"
#include "unity.h"

#define PI 3.14159265358979323846
#define TWO_PI 6.28318530717958647693
#define SQRT3 1.73205080756887729353
#define COUNT_OF(array) (sizeof(array) / sizeof((array)[0]))
#define EFFECTS_AT_MOST SIM_EFFECTS_MAX

extern sim_plant_t plant;
extern sim_model_t model;                                             /* of the next start */
extern double      effect_values[EFFECTS_AT_MOST][SIM_EFFECT_PARAMS]; /* of the next start */

/** Default model without back-EMF friction, all effects off. */
void machine_defaults(void);
/** Position of an effect and of its parameter; the test fails when there is none. */
int  machine_effect(const char *effect);
void machine_set(const char *effect, const char *param, double value);
/** Start with model and effect_values; the test fails when the model is refused. */
void machine_start(void);
/** Start in the same way. @return what was refused, or NULL. */
const char *machine_try_start(void);

/** Duties that make the vector (alpha, beta) volts on the dc link of the model. */
void machine_duties(double alpha_v, double beta_v, double duty[3]);
/** Periods with the gates on and a constant vector in the stationary frame, or the same in the rotor frame as it is at
 *  the start of each period. */
void machine_voltage(double alpha_v, double beta_v, int periods);
void machine_dq_voltage(double d_v, double q_v, int periods);
/** Periods with the gates off. */
void machine_coast(int periods);

const char *at(const char *format, ...);

#define ASSERT_REL(tolerance, expected, actual, text)                                                                            \
    TEST_ASSERT_DOUBLE_WITHIN_MESSAGE((tolerance) * fabs(expected), (expected), (actual), (text))

#endif
