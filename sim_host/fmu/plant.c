/* The machine alone: motor, inverter, shaft, load and sensors, driven by phase duties. */
#include <string.h>

#include "sim_host/fmu/instance.h"

enum { DUTY_A, DUTY_B, DUTY_C, GATES, LOAD_TORQUE, LOAD_BRAKE, DC_LINK, INPUTS };
static const char *const INPUT_NAMES[INPUTS] = {"duty_a",         "duty_b",        "duty_c",   "gates",
                                                "load_torque_nm", "load_brake_nm", "dc_link_v"};

enum { SPEED, THETA, ID, IQ, IA, IB, IC, TORQUE, LOAD_SPEED, READ_IA, READ_IB, READ_THETA, READ_VDC, OUTPUTS };
static const char *const OUTPUT_NAMES[OUTPUTS] = {
    "true_speed_rad_s", "true_theta_m_rad",      "true_id_a", "true_iq_a", "true_ia_a",   "true_ib_a", "true_ic_a",
    "true_torque_nm",   "true_load_speed_rad_s", "ia_a",      "ib_a",      "theta_m_rad", "vdc_v"};

static int place(const char *const *names, int count, const char *name)
{
    int i = 0;
    while ((i < count) && (strcmp(names[i], name) != 0)) {
        i++;
    }
    return i;
}

static bool set_model(fmu_t *fmu, const fmu_variable_t *v)
{
    for (int i = 0; i < sim_model_count(); i++) {
        const sim_field_t *const f = sim_model_info(i);
        if (strcmp(v->name, f->name) == 0) {
            if (!sim_field_accepts(f, v->value)) {
                return fmu_refuse(fmu, "%s = %g: must be within %g .. %g %s", v->name, v->value, f->min, f->max, f->unit);
            }
            *sim_model_at(&fmu->model, i) = v->value;
            return true;
        }
    }
    return fmu_refuse(fmu, "%s: no such number of the machine", v->name);
}

static bool set_effect(fmu_t *fmu, const fmu_variable_t *v)
{
    for (int e = 0; e < sim_effect_total; e++) {
        for (int k = 0; (k < sim_effects[e]->param_count) && (strcmp(sim_effects[e]->name, v->other) == 0); k++) {
            const sim_effect_param_t *const p = &sim_effects[e]->param[k];
            if (strcmp(p->name, v->name) == 0) {
                fmu->effect[e][k] = v->value;
                return ((v->value >= p->min) && (v->value <= p->max)) ||
                       fmu_refuse(fmu, "%s.%s = %g: must be within %g .. %g %s", v->other, v->name, v->value, p->min, p->max,
                                  p->unit);
            }
        }
    }
    return fmu_refuse(fmu, "%s.%s: no such effect", v->other, v->name);
}

static double input(const fmu_t *fmu, int which)
{
    for (int i = 0; i < fmu->count; i++) {
        if ((fmu->variable[i].role == FMU_INPUT) && (fmu->variable[i].plant_index == which)) {
            return fmu->variable[i].value;
        }
    }
    return 0.0;
}

/* What acts from outside in the next period. */
static void apply(fmu_t *fmu)
{
    const sim_outside_t outside = {
        .load_torque_nm = input(fmu, LOAD_TORQUE), .load_brake_nm = input(fmu, LOAD_BRAKE), .dc_link_v = input(fmu, DC_LINK)};
    fmu->plant.outside = outside;
}

static bool start(fmu_t *fmu)
{
    sim_model_default(&fmu->model);
    for (int e = 0; e < sim_effect_total; e++) {
        for (int k = 0; k < sim_effects[e]->param_count; k++) {
            fmu->effect[e][k] = sim_effects[e]->param[k].off;
        }
    }
    for (int i = 0; i < fmu->count; i++) {
        fmu_variable_t *const v = &fmu->variable[i];
        bool                  done = true;
        if (v->role == FMU_MODEL) {
            done = set_model(fmu, v);
        } else if (v->role == FMU_EFFECT) {
            done = set_effect(fmu, v);
        } else if (v->role == FMU_INPUT) {
            v->plant_index = place(INPUT_NAMES, INPUTS, v->name);
            done = (v->plant_index < INPUTS) || fmu_refuse(fmu, "%s: no such input", v->name);
        } else if (v->role == FMU_OUTPUT) {
            v->plant_index = place(OUTPUT_NAMES, OUTPUTS, v->name);
            done = (v->plant_index < OUTPUTS) || fmu_refuse(fmu, "%s: no such output", v->name);
        }
        if (!done) {
            return false;
        }
    }
    const double      edges = (fmu->model.counts_per_rev > 0.0) ? fmu->model.counts_per_rev : 4096.0; /* nobody reads them */
    const char *const bad =
        sim_plant_start(&fmu->plant, &fmu->model, (const double (*)[SIM_EFFECT_PARAMS])fmu->effect, edges, fmu->seed);
    if (bad != NULL) {
        return fmu_refuse(fmu, "%s does not fit the other numbers of the machine", bad);
    }
    apply(fmu);
    sim_plant_read(&fmu->plant, &fmu->reading);
    return true;
}

static bool set(fmu_t *fmu, fmu_variable_t *v)
{
    return (v->role == FMU_INPUT) || fmu_refuse(fmu, "%s: is fixed; set it before the initialization", v->name);
}

static bool run(fmu_t *fmu, int64_t periods)
{
    const double duty[3] = {input(fmu, DUTY_A), input(fmu, DUTY_B), input(fmu, DUTY_C)};
    for (int k = 0; k < 3; k++) {
        if (!((duty[k] >= 0.0) && (duty[k] <= 1.0))) {
            return fmu_refuse(fmu, "%s = %g: must be within 0 .. 1", INPUT_NAMES[k], duty[k]);
        }
    }
    apply(fmu);
    for (int64_t k = 0; k < periods; k++) {
        sim_plant_period(&fmu->plant, duty, input(fmu, GATES) >= 0.5);
        sim_plant_read(&fmu->plant, &fmu->reading);
    }
    return true;
}

static double get(fmu_t *fmu, const fmu_variable_t *v)
{
    const sim_plant_t *const p = &fmu->plant;
    double                   phase[3];
    sim_plant_phase_currents(p, phase);
    const double values[OUTPUTS] = {p->x.speed_rad_s,
                                    p->x.theta_m_rad,
                                    p->x.id_a,
                                    p->x.iq_a,
                                    phase[0],
                                    phase[1],
                                    phase[2],
                                    sim_plant_torque(p),
                                    sim_plant_load_speed(p),
                                    fmu->reading.ia_a,
                                    fmu->reading.ib_a,
                                    fmu->reading.theta_m_rad,
                                    fmu->reading.vdc_v};
    return values[v->plant_index];
}

static void stop(fmu_t *fmu) { (void)fmu; }

const fmu_kind_t fmu_plant = {start, set, run, get, stop};
