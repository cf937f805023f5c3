/* The functions of FMI 3.0 that a co-simulation needs; the others are in unsupported.c. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "sim_host/fmu/instance.h"

#include "sim_host/fmu/fmi3/fmi3Functions.h"

#define STEP_GRACE 1e-6 /* of a period: how far rounding of the communication times may be off */

static fmi3Status status(bool good) { return good ? fmi3OK : fmi3Error; }

const char *fmi3GetVersion(void) { return fmi3Version; }

fmi3Status fmi3SetDebugLogging(fmi3Instance instance, fmi3Boolean loggingOn, size_t nCategories, const fmi3String categories[])
{
    (void)loggingOn; /* errors are always said */
    (void)nCategories;
    (void)categories;
    return status(instance != NULL);
}

static double number_of_model(const fmu_t *fmu, const char *name, double fallback)
{
    for (int i = 0; i < fmu->count; i++) {
        if ((fmu->variable[i].role == FMU_MODEL) && (strcmp(fmu->variable[i].name, name) == 0)) {
            return fmu->variable[i].value;
        }
    }
    return fallback;
}

fmi3Instance fmi3InstantiateCoSimulation(fmi3String instanceName, fmi3String instantiationToken, fmi3String resourcePath,
                                         fmi3Boolean visible, fmi3Boolean loggingOn, fmi3Boolean eventModeUsed,
                                         fmi3Boolean earlyReturnAllowed, const fmi3ValueReference requiredIntermediateVariables[],
                                         size_t nRequiredIntermediateVariables, fmi3InstanceEnvironment instanceEnvironment,
                                         fmi3LogMessageCallback logMessage, fmi3IntermediateUpdateCallback intermediateUpdate)
{
    (void)instanceName;
    (void)instantiationToken;
    (void)visible;
    (void)loggingOn;
    (void)earlyReturnAllowed;
    (void)requiredIntermediateVariables;
    (void)intermediateUpdate;
    fmu_t *const fmu = calloc(1, sizeof *fmu);
    if (fmu == NULL) {
        return NULL;
    }
    fmu->environment = instanceEnvironment;
    fmu->log = logMessage;
    fmu->seed = 1;
    const bool asked_for_more = eventModeUsed || (nRequiredIntermediateVariables > 0U);
    if (asked_for_more ? !fmu_refuse(fmu, "event mode and intermediate variables are not supported")
                       : !fmu_read_setup(fmu, resourcePath)) {
        fmi3FreeInstance(fmu);
        return NULL;
    }
    return fmu;
}

void fmi3FreeInstance(fmi3Instance instance)
{
    fmu_t *const fmu = instance;
    if (fmu != NULL) {
        if (fmu->kind != NULL) {
            fmu->kind->stop(fmu);
        }
        free(fmu->variable);
        free(fmu);
    }
}

fmi3Status fmi3EnterInitializationMode(fmi3Instance instance, fmi3Boolean toleranceDefined, fmi3Float64 tolerance,
                                       fmi3Float64 startTime, fmi3Boolean stopTimeDefined, fmi3Float64 stopTime)
{
    (void)toleranceDefined; /* the step is the PWM period */
    (void)tolerance;
    (void)stopTimeDefined;
    (void)stopTime;
    fmu_t *const fmu = instance;
    if ((fmu == NULL) || (fmu->mode != FMU_INSTANTIATED) || !isfinite(startTime)) {
        return fmi3Error;
    }
    fmu->start_s = startTime;
    fmu->mode = FMU_INITIALIZING;
    return fmi3OK;
}

fmi3Status fmi3ExitInitializationMode(fmi3Instance instance)
{
    fmu_t *const fmu = instance;
    if ((fmu == NULL) || (fmu->mode != FMU_INITIALIZING)) {
        return fmi3Error;
    }
    fmu->period_s = 1.0 / number_of_model(fmu, "pwm_hz", 10e3);
    fmu->periods = 0;
    if (!fmu->kind->start(fmu)) {
        return fmi3Error;
    }
    fmu->mode = FMU_STEPPING;
    return fmi3OK;
}

fmi3Status fmi3Terminate(fmi3Instance instance)
{
    fmu_t *const fmu = instance;
    if ((fmu == NULL) || (fmu->mode != FMU_STEPPING)) {
        return fmi3Error;
    }
    fmu->mode = FMU_TERMINATED;
    return fmi3OK;
}

fmi3Status fmi3Reset(fmi3Instance instance)
{
    fmu_t *const fmu = instance;
    if (fmu == NULL) {
        return fmi3Error;
    }
    fmu->kind->stop(fmu);
    for (int i = 0; i < fmu->count; i++) {
        fmu->variable[i].value = fmu->variable[i].start;
        fmu->variable[i].pending = false;
    }
    fmu->mode = FMU_INSTANTIATED;
    fmu->periods = 0;
    return fmi3OK;
}

fmi3Status fmi3GetFloat64(fmi3Instance instance, const fmi3ValueReference valueReferences[], size_t nValueReferences,
                          fmi3Float64 values[], size_t nValues)
{
    fmu_t *const fmu = instance;
    if ((fmu == NULL) || (nValues != nValueReferences)) {
        return fmi3Error;
    }
    const bool runs = (fmu->mode == FMU_STEPPING) || (fmu->mode == FMU_TERMINATED);
    for (size_t k = 0; k < nValues; k++) {
        const fmi3ValueReference at = valueReferences[k];
        if (at == (fmi3ValueReference)fmu->count) {
            values[k] = fmu->start_s + (double)fmu->periods * fmu->period_s;
        } else if (at > (fmi3ValueReference)fmu->count) {
            return status(fmu_refuse(fmu, "value reference %u: there is none", (unsigned)at));
        } else if (fmu->variable[at].role == FMU_OUTPUT) {
            values[k] = runs ? fmu->kind->get(fmu, &fmu->variable[at]) : 0.0;
        } else {
            values[k] = fmu->variable[at].value;
        }
    }
    return fmi3OK;
}

fmi3Status fmi3SetFloat64(fmi3Instance instance, const fmi3ValueReference valueReferences[], size_t nValueReferences,
                          const fmi3Float64 values[], size_t nValues)
{
    fmu_t *const fmu = instance;
    if ((fmu == NULL) || (nValues != nValueReferences) || (fmu->mode == FMU_TERMINATED)) {
        return fmi3Error;
    }
    for (size_t k = 0; k < nValues; k++) {
        const fmi3ValueReference at = valueReferences[k];
        if ((at >= (fmi3ValueReference)fmu->count) || (fmu->variable[at].role == FMU_OUTPUT)) {
            return status(fmu_refuse(fmu, "value reference %u: cannot be set", (unsigned)at));
        }
        fmu_variable_t *const v = &fmu->variable[at];
        if (!isfinite(values[k])) {
            return status(fmu_refuse(fmu, "%s: is not finite", v->name));
        }
        const double before = v->value;
        v->value = values[k];
        if ((fmu->mode == FMU_STEPPING) && (v->value != before) && !fmu->kind->set(fmu, v)) {
            v->value = before;
            return fmi3Error;
        }
    }
    return fmi3OK;
}

fmi3Status fmi3DoStep(fmi3Instance instance, fmi3Float64 currentCommunicationPoint, fmi3Float64 communicationStepSize,
                      fmi3Boolean noSetFMUStatePriorToCurrentPoint, fmi3Boolean *eventHandlingNeeded,
                      fmi3Boolean *terminateSimulation, fmi3Boolean *earlyReturn, fmi3Float64 *lastSuccessfulTime)
{
    (void)noSetFMUStatePriorToCurrentPoint;
    fmu_t *const fmu = instance;
    if ((fmu == NULL) || (fmu->mode != FMU_STEPPING)) {
        return fmi3Error;
    }
    *eventHandlingNeeded = fmi3False;
    *terminateSimulation = fmi3False;
    *earlyReturn = fmi3False;
    const double end_s = currentCommunicationPoint + communicationStepSize;
    const double wanted = floor((end_s - fmu->start_s) / fmu->period_s + STEP_GRACE); /* whole periods up to there */
    if (!(communicationStepSize >= 0.0) || !(wanted >= (double)fmu->periods) || !(wanted < 1e15)) {
        return status(
            fmu_refuse(fmu, "a step from %g by %g s: time cannot go back", currentCommunicationPoint, communicationStepSize));
    }
    const int64_t periods = (int64_t)wanted - fmu->periods;
    if (!fmu->kind->run(fmu, periods)) {
        return fmi3Error;
    }
    fmu->periods += periods;
    *lastSuccessfulTime = end_s;
    return fmi3OK;
}
