/* The firmware on the machine: what `evenspin run` simulates. */
#include "sim_host/fmu/instance.h"

#define MOST_WAITING 100 /* periods that a changed parameter may wait for the main loop of the drive, which runs every 10 */

static bool refused(const fmu_t *fmu, const fmu_variable_t *v)
{
    const es_error_t *const e = es_sim_error(fmu->sim);
    if (e->min < e->max) {
        return fmu_refuse(fmu, "%s = %g: must be within %g .. %g %s (%s)", v->name, v->value, e->min, e->max, e->unit, e->name);
    }
    return fmu_refuse(fmu, "%s = %g: is refused%s%s %s", v->name, v->value, (e->name[0] != '\0') ? " because of " : "", e->name,
                      e->rule);
}

static bool set_input(const fmu_t *fmu, const fmu_variable_t *v)
{
    const double now = 0.0;
    return es_sim_set_input(fmu->sim, v->name, &now, &v->value, 1, false) || refused(fmu, v);
}

static void stop(fmu_t *fmu)
{
    es_sim_free(fmu->sim);
    fmu->sim = NULL;
}

static bool start(fmu_t *fmu)
{
    stop(fmu);
    fmu->sim = es_sim_new();
    if (fmu->sim == NULL) {
        return fmu_refuse(fmu, "no memory for a simulation");
    }
    for (int i = 0; i < fmu->count; i++) {
        fmu_variable_t *const v = &fmu->variable[i];
        bool                  done = true;
        v->pending = false;
        switch (v->role) {
        case FMU_MODEL:
            done = es_sim_set_model(fmu->sim, v->name, v->value);
            break;
        case FMU_PARAM:
            done = es_sim_set_param(fmu->sim, v->name, v->value);
            break;
        case FMU_EFFECT:
            done = es_sim_set_effect(fmu->sim, v->other, v->name, v->value);
            break;
        case FMU_INPUT:
            done = set_input(fmu, v);
            break;
        default:
            break;
        }
        if (!done) {
            return (v->role == FMU_INPUT) ? false : refused(fmu, v);
        }
    }
    (void)es_sim_set_seed(fmu->sim, fmu->seed);
    if (!es_sim_start(fmu->sim)) {
        return fmu_refuse(fmu, "the drive does not start: %s does not fit %s %s", es_sim_error(fmu->sim)->name,
                          es_sim_error(fmu->sim)->other, es_sim_error(fmu->sim)->rule);
    }
    return true;
}

static bool set(fmu_t *fmu, fmu_variable_t *v)
{
    if (v->role == FMU_INPUT) {
        return set_input(fmu, v);
    }
    v->pending = v->role == FMU_PARAM;
    return v->pending || fmu_refuse(fmu, "%s: is fixed; set it before the initialization", v->name);
}

/* Parameters go to the drive one by one: it takes a set over between two samples, and a second one waits for that. */
static bool tune(fmu_t *fmu, bool *waiting)
{
    *waiting = false;
    for (int i = 0; i < fmu->count; i++) {
        fmu_variable_t *const v = &fmu->variable[i];
        if (!v->pending) {
            continue;
        }
        if (es_sim_tune(fmu->sim, v->name, v->value)) {
            v->pending = false;
        } else if (es_sim_error(fmu->sim)->code == ES_WAITING) {
            *waiting = true;
            return true;
        } else {
            v->pending = false;
            return refused(fmu, v);
        }
    }
    return true;
}

static bool run(fmu_t *fmu, int64_t periods)
{
    bool waiting = true;
    for (int64_t k = 0; (k < periods) && waiting; k++) {
        if (!tune(fmu, &waiting)) {
            return false;
        }
        const int64_t now = waiting ? 1 : periods - k;
        (void)es_sim_run(fmu->sim, now, 1, NULL, 0);
        if (waiting && (k > (int64_t)MOST_WAITING * fmu->count)) {
            return fmu_refuse(fmu, "the drive does not take its parameters over");
        }
    }
    return true;
}

static double get(fmu_t *fmu, const fmu_variable_t *v) { return (fmu->sim != NULL) ? es_sim_read(fmu->sim, v->name) : 0.0; }

const fmu_kind_t fmu_drive = {start, set, run, get, stop};
