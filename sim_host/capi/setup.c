/* The simulated drive: made, configured, started. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "firmware/app/combinations.h"
#include "sim_host/capi/sim.h"

static int effect_at(const char *name)
{
    int e = 0;
    while ((e < sim_effect_total) && (strcmp(name, sim_effects[e]->name) != 0)) {
        e++;
    }
    return e;
}

static bool is_on(const es_sim_t *s, int e)
{
    int k = 0;
    while ((k < sim_effects[e]->param_count) && (s->effect[e][k] == sim_effects[e]->param[k].off)) {
        k++;
    }
    return k < sim_effects[e]->param_count;
}

/* An effect beside another one that has the shaft already: both are named. */
static bool refuse_second_shaft(es_sim_t *s, int second)
{
    int first = 0;
    while ((first < second) && !(is_on(s, first) && (strcmp(sim_effects[first]->acts_on, sim_effects[second]->acts_on) == 0))) {
        first++;
    }
    return capi_refuse_with(&s->error, ES_TWO_SHAFTS, "effect", sim_effects[first]->name, 0.0, sim_effects[second]->name);
}

es_sim_t *es_sim_new(void)
{
    es_sim_t *const s = calloc(1, sizeof *s);
    if (s == NULL) {
        return NULL;
    }
    sim_model_default(&s->model);
    params_default(&s->params);
    for (int e = 0; e < sim_effect_total; e++) {
        for (int k = 0; k < sim_effects[e]->param_count; k++) {
            s->effect[e][k] = sim_effects[e]->param[k].off;
        }
    }
    capi_inputs_default(s);
    s->seed = 1;
    (void)capi_refuse(&s->error, ES_NONE, "", "", 0.0);
    return s;
}

void es_sim_free(es_sim_t *sim)
{
    if (sim == NULL) {
        return;
    }
    capi_inputs_free(sim);
    trace_free(&sim->trace);
    free(sim->table);
    free(sim);
}

const es_error_t *es_sim_error(const es_sim_t *sim)
{
    static const es_error_t NO_OBJECT = {.code = ES_NO_OBJECT, .list = "", .other = "", .unit = "", .rule = ""};
    return (sim != NULL) ? &sim->error : &NO_OBJECT;
}

bool es_sim_set_model(es_sim_t *sim, const char *name, double value)
{
    if ((sim == NULL) || (name == NULL)) {
        return false;
    }
    for (int i = 0; i < sim_model_count(); i++) {
        const sim_field_t *const f = sim_model_info(i);
        if (strcmp(name, f->name) == 0) {
            if (!sim_field_accepts(f, value)) {
                const es_code_t code = (f->kind == SIM_REAL) ? ES_OUT_OF_RANGE : ES_NOT_WHOLE;
                return capi_refuse_range(&sim->error, code, "model", name, value, f->min, f->max, f->unit);
            }
            *sim_model_at(&sim->model, i) = value;
            return true;
        }
    }
    return capi_refuse(&sim->error, ES_UNKNOWN, "model", name, value);
}

int capi_param_index(const char *name)
{
    int i = 0;
    while ((i < (int)PARAM_COUNT) && (strcmp(name, params_info((uint16_t)i)->name) != 0)) {
        i++;
    }
    return i;
}

bool capi_param_set(es_sim_t *sim, drive_params_t *p, const char *name, double value)
{
    const int i = capi_param_index(name);
    if (i == (int)PARAM_COUNT) {
        return capi_refuse(&sim->error, ES_UNKNOWN, "param", name, value);
    }
    if (!params_set(p, (uint16_t)i, (float)value)) {
        const param_info_t *const f = params_info((uint16_t)i);
        const es_code_t           code = (f->kind == PARAM_KIND_FLOAT) ? ES_OUT_OF_RANGE : ES_NOT_WHOLE;
        return capi_refuse_range(&sim->error, code, "param", name, value, (double)f->min, (double)f->max, params_unit(f));
    }
    return true;
}

bool es_sim_set_param(es_sim_t *sim, const char *name, double value)
{
    return (sim != NULL) && (name != NULL) && capi_param_set(sim, &sim->params, name, value);
}

bool es_sim_set_effect(es_sim_t *sim, const char *effect, const char *param, double value)
{
    if ((sim == NULL) || (effect == NULL) || (param == NULL)) {
        return false;
    }
    for (int e = 0; e < sim_effect_total; e++) {
        if (strcmp(effect, sim_effects[e]->name) != 0) {
            continue;
        }
        for (int k = 0; k < sim_effects[e]->param_count; k++) {
            const sim_effect_param_t *const p = &sim_effects[e]->param[k];
            if (strcmp(param, p->name) == 0) {
                if (!((value >= p->min) && (value <= p->max))) {
                    (void)capi_refuse_range(&sim->error, ES_OUT_OF_RANGE, "effect_param", param, value, p->min, p->max, p->unit);
                    sim->error.other = sim_effects[e]->name;
                    return false;
                }
                sim->effect[e][k] = value;
                return true;
            }
        }
        return capi_refuse_with(&sim->error, ES_UNKNOWN, "effect_param", param, value, sim_effects[e]->name);
    }
    return capi_refuse(&sim->error, ES_UNKNOWN, "effect", effect, value);
}

bool es_sim_set_seed(es_sim_t *sim, uint64_t seed)
{
    if (sim == NULL) {
        return false;
    }
    sim->seed = seed;
    sim->noise = NULL;
    sim->noise_periods = 0;
    return true;
}

void es_noise(uint64_t seed, double *pairs, int64_t count)
{
    sim_random_t random;
    sim_random_seed(&random, seed);
    for (int64_t k = 0; (pairs != NULL) && (k < count); k++) {
        sim_random_normal2(&random, &pairs[2 * k]);
    }
}

bool es_sim_set_noise(es_sim_t *sim, uint64_t seed, const double *pairs, int64_t count)
{
    if ((sim == NULL) || (pairs == NULL)) {
        return false;
    }
    if (count < 1) {
        return capi_refuse_range(&sim->error, ES_NOT_WHOLE, "noise", "count", (double)count, 1.0, INFINITY, "");
    }
    double first[2];
    es_noise(seed, first, 1);
    if ((pairs[0] != first[0]) || (pairs[1] != first[1])) {
        (void)capi_refuse(&sim->error, ES_BREAKS_RULE, "noise", "seed", (double)seed);
        sim->error.rule = "the seed that the noise was drawn with";
        return false;
    }
    sim->seed = seed;
    sim->noise = pairs;
    sim->noise_periods = count;
    return true;
}

/* A limit of the model's board; without one the board was made for the set that the drive starts with. */
static float board_limit(const es_sim_t *s, double of_model, uint16_t param)
{
    const float starts = params_get(&s->params, param);
    const float standard = params_info(param)->def;
    return (of_model > 0.0) ? (float)of_model : ((starts > standard) ? starts : standard);
}

static void set_board_limits(es_sim_t *s)
{
    const hal_limits_t limits = {board_limit(s, s->model.board_current_a, PARAM_over_current_a),
                                 board_limit(s, s->model.board_dc_link_v, PARAM_over_voltage_v),
                                 board_limit(s, s->model.board_speed_rad_s, PARAM_over_speed_rad_s),
                                 board_limit(s, 0.0, PARAM_offset_limit_a),
                                 0.0f /* any encoder */,
                                 s->model.brake_ohm > 0.0};
    s->board.limits = limits;
}

bool capi_param_refuse(es_sim_t *s, const drive_params_t *p, uint16_t culprit)
{
    const param_info_t *const f = params_info(culprit);
    const float               most = drive_board_max(culprit);
    const float               value = params_get(p, culprit);
    float                     low = 0.0f;
    float                     high = 0.0f;
    drive_relation(p, culprit, &low, &high);
    const combination_info_t *const broken = combinations_info(combinations_broken(p));
    if ((broken != NULL) && (broken->param == culprit)) {
        (void)capi_refuse_with(&s->error, ES_COMBINATION, "param", f->name, (double)value, params_info(broken->other)->name);
        s->error.min = (double)params_get(p, broken->other);
        s->error.rule = broken->why;
        return false;
    }
    if (value > most) {
        return capi_refuse_range(&s->error, ES_BOARD, "param", f->name, (double)value, (double)f->min, (double)most,
                                 params_unit(f));
    }
    if ((value < low) || (value >= high)) {
        return capi_refuse_range(&s->error, ES_OTHERS, "param", f->name, (double)value, (double)low, (double)high,
                                 params_unit(f));
    }
    return capi_refuse(&s->error, ES_NO_FIT, "param", f->name, (double)value);
}

bool es_sim_start(es_sim_t *sim)
{
    if (sim == NULL) {
        return false;
    }
    sim->started = false;
    if (sim->model.pwm_hz != (double)DRIVE_PWM_HZ) {
        return capi_refuse_range(&sim->error, ES_OUT_OF_RANGE, "model", "pwm_hz", sim->model.pwm_hz, (double)DRIVE_PWM_HZ,
                                 (double)DRIVE_PWM_HZ, "Hz");
    }
    sim_board_select(&sim->board);
    if (sim->board.trace != NULL) {
        trace_restart(sim->board.trace);
    }
    const double edges = (sim->model.counts_per_rev > 0.0) ? sim->model.counts_per_rev : (double)sim->params.encoder_counts;
    const char  *bad =
        sim_plant_start(&sim->board.plant, &sim->model, (const double (*)[SIM_EFFECT_PARAMS])sim->effect, edges, sim->seed);
    if (bad != NULL) {
        const int effect = effect_at(bad);
        return (effect < sim_effect_total) ? refuse_second_shaft(sim, effect)
                                           : capi_refuse(&sim->error, ES_NO_FIT, "model", bad, 0.0);
    }
    sim->board.plant.noise_ahead = sim->noise;
    sim->board.plant.noise_ahead_count = sim->noise_periods;
    if (sim->storage_kept) {
        sim_board_restart(&sim->board);
    } else {
        sim_board_start(&sim->board);
    }
    set_board_limits(sim);
    capi_inputs_rewind(sim);
    if (sim->linked) {
        capi_call_services(sim);
    } else {
        capi_call_init(sim);
        if (sim->params.auto_run !=
            0U) { /* no link, no client whose silence could be dangerous: the simulation itself starts it */
            capi_call_start(sim);
        }
    }
    if (sim->drive.fault == FAULT_configuration) {
        return capi_param_refuse(sim, &sim->params, sim->drive.fault_detail);
    }
    if (!capi_reference_fits(sim)) {
        return false;
    }
    if ((sim->table != NULL) && !capi_table_give(sim)) {
        return false;
    }
    for (int pass = 0; pass < 3; pass++) { /* init -> ready -> run before the first sample, when nothing else is asked for */
        capi_call_background(sim);
    }
    sim->started = true;
    return true;
}
