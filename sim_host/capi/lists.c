/* The lists that do not depend on a simulation: parameters, plant model, effects, faults, commands of the link. */
#include <stddef.h>

#include "firmware/app/combinations.h"
#include "firmware/app/faults.h"
#include "firmware/app/parameters.h"
#include "firmware/services/schema.h"
#include "sim_host/capi/error.h"
#include "sim_host/plant/effect.h"
#include "sim_host/plant/model.h"

static const char *kind_name(sim_kind_t kind)
{
    static const char *const NAME[] = {"float", "integer", "flag"};
    return NAME[kind];
}

int  es_param_count(void) { return PARAM_COUNT; }
bool es_param_info(int index, es_field_t *out)
{
    static const char *const  KIND[] = {"float", "integer", "flag", "choice"};
    const param_info_t *const p = (index >= 0) ? params_info((uint16_t)((index < PARAM_COUNT) ? index : PARAM_COUNT)) : NULL;
    if ((p == NULL) ||
        !capi_fill(out, p->name, params_unit(p), KIND[p->kind], p->doc, params_choices(p), p->min, p->max, p->def)) {
        return false;
    }
    out->at_rest = params_only_at_rest((uint16_t)index);
    return true;
}

int  es_model_count(void) { return sim_model_count(); }
bool es_model_info(int index, es_field_t *out)
{
    const sim_field_t *const f = sim_model_info(index);
    return (f != NULL) && capi_fill(out, f->name, f->unit, kind_name(f->kind), f->doc, "", f->min, f->max, f->def);
}

int  es_effect_count(void) { return sim_effect_total; }
bool es_effect_info(int index, es_effect_t *out)
{
    if ((index < 0) || (index >= sim_effect_total) || (out == NULL)) {
        return false;
    }
    const sim_effect_t *const e = sim_effects[index];
    const char *const         apart = (e->told_apart != NULL) ? e->told_apart : "";
    const es_effect_t         row = {e->name, e->acts_on, e->doc, e->signature, apart, e->scenario_only, e->param_count};
    *out = row;
    return true;
}
bool es_effect_param_info(int effect, int param, es_field_t *out)
{
    if ((effect < 0) || (effect >= sim_effect_total) || (param < 0) || (param >= sim_effects[effect]->param_count)) {
        return false;
    }
    const sim_effect_param_t *const p = &sim_effects[effect]->param[param];
    return capi_fill(out, p->name, p->unit, "float", p->doc, "", p->min, p->max, p->off);
}

bool es_effect_param_role(int effect, int param, es_role_t *out)
{
    static const char *const ROLE[] = {"amplitude", "phase", "factor", "order", "sign", "share", "quantity", "detail"};
    if ((effect < 0) || (effect >= sim_effect_total) || (param < 0) || (param >= sim_effects[effect]->param_count) ||
        (out == NULL)) {
        return false;
    }
    const sim_effect_param_t *const p = &sim_effects[effect]->param[param];
    const es_role_t row = {ROLE[p->role], p->example, (p->flags & SIM_VECTOR) != 0U, (p->flags & SIM_OPTIONAL) != 0U};
    *out = row;
    return true;
}
const char *es_effect_neighbour(int effect, int index)
{
    const bool there = (effect >= 0) && (effect < sim_effect_total) && (index >= 0) && (index < SIM_EFFECT_NEIGHBOURS);
    return there ? sim_effects[effect]->confused_with[index] : NULL;
}
bool es_effect_shown_by(int effect, int index, const char **experiment, const char **condition)
{
    if ((effect < 0) || (effect >= sim_effect_total) || (index < 0) || (index >= SIM_EFFECT_NEIGHBOURS) || (experiment == NULL) ||
        (condition == NULL) || (sim_effects[effect]->shown_by[index].experiment == NULL)) {
        return false;
    }
    *experiment = sim_effects[effect]->shown_by[index].experiment;
    *condition = sim_effects[effect]->shown_by[index].condition;
    return true;
}

int es_combination_count(void)
{
    int count = 0;
    while (combinations_info((uint16_t)count) != NULL) {
        count++;
    }
    return count;
}
bool es_combination_info(int index, es_combination_t *out)
{
    const combination_info_t *const c = (index >= 0) ? combinations_info((uint16_t)index) : NULL;
    if ((c == NULL) || (out == NULL)) {
        return false;
    }
    const es_combination_t row = {c->name, params_info(c->param)->name, params_info(c->other)->name, c->why};
    *out = row;
    return true;
}

int  es_fault_count(void) { return FAULT_COUNT; }
bool es_fault_info(int index, es_fault_t *out)
{
    const fault_info_t *const f =
        (index >= 0) ? faults_info((uint16_t)((index < (int)FAULT_COUNT) ? index : (int)FAULT_COUNT)) : NULL;
    if ((f == NULL) || (out == NULL)) {
        return false;
    }
    const es_fault_t row = {f->name, f->cause, f->check};
    *out = row;
    return true;
}

int  es_command_count(void) { return (int)schema_count(SCHEMA_COMMANDS); }
bool es_command_info(int index, es_field_t *out)
{
    if ((index < 0) || (index >= es_command_count())) {
        return false;
    }
    return capi_fill(out, schema_name(SCHEMA_COMMANDS, (uint16_t)index), "", "",
                     schema_text(SCHEMA_COMMANDS, (uint16_t)index, 0U), "", 0.0, 0.0, 0.0);
}

uint32_t es_schema_hash(void) { return schema_hash(); }
