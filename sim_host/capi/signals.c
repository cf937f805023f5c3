/* Signals: the telemetry of the drive, then what only the simulator knows. */
#include <math.h>
#include <string.h>

#include "firmware/app/telemetry.h"
#include "sim_host/capi/sim.h"

static double phase_current(const es_sim_t *s, int k)
{
    double i[3];
    sim_plant_phase_currents(&s->board.plant, i);
    return i[k];
}

enum {
#define TRUTH(name, unit, expression, doc) TRUTH_##name,
#include "sim_host/capi/truth.def"
#undef TRUTH
    TRUTH_COUNT
};

static const signal_info_t TRUTHS[TRUTH_COUNT] = {
#define TRUTH(name, unit, expression, doc) {#name, unit, doc},
#include "sim_host/capi/truth.def"
#undef TRUTH
};

double capi_signal_read(const es_sim_t *s, int index)
{
    switch (index - (int)SIGNAL_COUNT) {
#define TRUTH(name, unit, expression, doc)                                                                                       \
    case TRUTH_##name:                                                                                                           \
        return (expression);
#include "sim_host/capi/truth.def"
#undef TRUTH
    default:
        return (double)telemetry_read(&s->drive, (uint16_t)index);
    }
}

const signal_info_t *capi_signal_info(int index)
{
    if ((index >= 0) && (index < (int)SIGNAL_COUNT)) {
        return telemetry_info((uint16_t)index);
    }
    const int k = index - (int)SIGNAL_COUNT;
    return ((index >= 0) && (k < (int)TRUTH_COUNT)) ? &TRUTHS[k] : NULL;
}
int  es_signal_count(void) { return (int)SIGNAL_COUNT + (int)TRUTH_COUNT; }
bool es_signal_info(int index, es_field_t *out)
{
    const signal_info_t *const s = capi_signal_info(index);
    return (s != NULL) && capi_fill(out, s->name, s->unit, "float", s->doc, "", -INFINITY, INFINITY, 0.0);
}

int capi_signal_find(const char *name)
{
    for (int i = 0; i < es_signal_count(); i++) {
        if (strcmp(name, capi_signal_info(i)->name) == 0) {
            return i;
        }
    }
    return -1;
}

bool es_sim_record(es_sim_t *sim, const char *const *signals, int count)
{
    if ((sim == NULL) || (signals == NULL)) {
        return false;
    }
    if ((count < 1) || (count > CAPI_SIGNALS_MAX)) {
        return capi_refuse_range(&sim->error, ES_NOT_WHOLE, "signal", "count", (double)count, 1, CAPI_SIGNALS_MAX, "");
    }
    int chosen[CAPI_SIGNALS_MAX];
    for (int i = 0; i < count; i++) {
        chosen[i] = (signals[i] != NULL) ? capi_signal_find(signals[i]) : -1;
        if (chosen[i] < 0) {
            return capi_refuse(&sim->error, ES_UNKNOWN, "signal", signals[i], (double)i);
        }
    }
    memcpy(sim->signal, chosen, sizeof chosen);
    sim->signal_count = count;
    return true;
}
