/* The control blocks for Python: lists, parameters by name, actions. */
#include "sim_host/capi/block.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define LARGEST 1.0e9

struct es_block {
    const capi_block_t *kind;
    double              param[CAPI_PARAMS_MAX];
    bool                started;
    void               *self;
    num_t              *memory;
};

num_t capi_signal_in(double x)
{
#ifdef EVENSPIN_FIXED
    return isfinite(x) ? capi_in(x) : INT32_MIN;
#else
    return (num_t)x;
#endif
}

angle_t capi_angle_in(double rad)
{
    return isfinite(rad) ? (angle_t)(int64_t)floor(fmod(rad / (2.0 * CAPI_PI), 1.0) * 4294967296.0) : 0U;
}

bool capi_usable(const double *x, int count)
{
    bool usable = true;
    for (int i = 0; i < count; i++) {
        usable = usable && (fabs(x[i]) <= LARGEST); /* false for NaN */
    }
    return usable;
}

int capi_refused(ctl_diag_t diag, const int *param_of_field, size_t fields, int fallback)
{
    if (diag.status == CTL_OK) {
        return CAPI_STARTED;
    }
    return (diag.field < fields) ? param_of_field[diag.field] : fallback;
}

/* ---- lists ----------------------------------------------------------------------------------------------------------- */

static int params_of(const capi_block_t *kind)
{
    int n = 0;
    while ((n < CAPI_PARAMS_MAX) && (kind->param[n].name != NULL)) {
        n++;
    }
    return n;
}

static int actions_of(const capi_block_t *kind)
{
    int n = 0;
    while ((n < CAPI_ACTIONS_MAX) && (kind->action[n].name != NULL)) {
        n++;
    }
    return n;
}

/* Words of "a|b|c". */
static int words(const char *list)
{
    int n = ((list != NULL) && (list[0] != '\0')) ? 1 : 0;
    for (const char *c = list; (n > 0) && (*c != '\0'); c++) {
        n += (*c == '|') ? 1 : 0;
    }
    return n;
}

static const char *text(const char *s) { return (s != NULL) ? s : ""; }

static const capi_block_t *kind_at(int index) { return ((index >= 0) && (index < capi_block_total)) ? capi_blocks[index] : NULL; }

int  es_block_count(void) { return capi_block_total; }
bool es_block_info(int index, es_block_info_t *out)
{
    const capi_block_t *const kind = kind_at(index);
    if ((kind == NULL) || (out == NULL)) {
        return false;
    }
    const es_block_info_t row = {kind->name, kind->doc, params_of(kind), actions_of(kind)};
    *out = row;
    return true;
}

bool es_block_param_info(int block, int param, es_field_t *out)
{
    static const char *const  KIND[] = {"float", "integer", "flag", "choice"};
    const capi_block_t *const kind = kind_at(block);
    if ((kind == NULL) || (param < 0) || (param >= params_of(kind))) {
        return false;
    }
    const capi_param_t *const p = &kind->param[param];
    if (!capi_fill(out, p->name, p->unit, KIND[p->kind], p->doc, text(p->choices), p->min, p->max, p->value)) {
        return false;
    }
    out->above = (p->ends & (unsigned)CAPI_ABOVE) != 0U;
    out->below = (p->ends & (unsigned)CAPI_BELOW) != 0U;
    out->rule = text(p->rule);
    return true;
}

bool es_block_action_info(int block, int action, es_action_t *out)
{
    const capi_block_t *const kind = kind_at(block);
    if ((kind == NULL) || (action < 0) || (action >= actions_of(kind)) || (out == NULL)) {
        return false;
    }
    const capi_action_t *const a = &kind->action[action];
    const es_action_t          row = {a->name, a->doc, text(a->inputs), text(a->outputs), words(a->inputs), words(a->outputs)};
    *out = row;
    return true;
}

/* ---- one block ------------------------------------------------------------------------------------------------------- */

es_block_t *es_block_new(const char *block, es_error_t *error)
{
    int i = 0;
    while ((block != NULL) && (i < capi_block_total) && (strcmp(block, capi_blocks[i]->name) != 0)) {
        i++;
    }
    if ((block == NULL) || (i == capi_block_total)) {
        (void)capi_refuse(error, (block == NULL) ? ES_NO_OBJECT : ES_UNKNOWN, "block", block, 0.0);
        return NULL;
    }
    es_block_t *const made = calloc(1, sizeof *made);
    if (made == NULL) {
        (void)capi_refuse(error, ES_NO_MEMORY, "block", block, 0.0);
        return NULL;
    }
    made->kind = capi_blocks[i];
    for (int k = 0; k < params_of(made->kind); k++) {
        made->param[k] = made->kind->param[k].value;
    }
    return made;
}

static void stop(es_block_t *block)
{
    free(block->self);
    free(block->memory);
    block->self = NULL;
    block->memory = NULL;
    block->started = false;
}

void es_block_free(es_block_t *block)
{
    if (block != NULL) {
        stop(block);
        free(block);
    }
}

/* A parameter that is out of its range, or refused although it is within: then its rule says why. */
static bool refuse(const es_block_t *block, es_error_t *error, es_code_t code, int param)
{
    const capi_param_t *const p = &block->kind->param[param];
    (void)capi_refuse_range(error, code, "block_param", p->name, block->param[param], p->min, p->max, p->unit);
    if (error != NULL) {
        error->other = block->kind->name;
        error->rule = text(p->rule);
        error->above = (p->ends & (unsigned)CAPI_ABOVE) != 0U;
        error->below = (p->ends & (unsigned)CAPI_BELOW) != 0U;
    }
    return false;
}

static es_code_t check(const capi_param_t *p, double value)
{
    const bool high = (p->ends & (unsigned)CAPI_BELOW) ? (value < p->max) : (value <= p->max);
    const bool low = (p->ends & (unsigned)CAPI_ABOVE) ? (value > p->min) : (value >= p->min);
    const bool whole = (p->kind == CAPI_REAL) || (value == floor(value));
    if (isfinite(value) && low && high && whole) {
        return ES_NONE;
    }
    return (p->kind == CAPI_REAL) ? ES_OUT_OF_RANGE : ES_NOT_WHOLE;
}

bool es_block_set(es_block_t *block, const char *param, double value, es_error_t *error)
{
    if ((block == NULL) || (param == NULL)) {
        return capi_refuse(error, ES_NO_OBJECT, "block_param", param, value);
    }
    for (int k = 0; k < params_of(block->kind); k++) {
        if (strcmp(param, block->kind->param[k].name) == 0) {
            const double    before = block->param[k];
            const es_code_t code = check(&block->kind->param[k], value);
            block->param[k] = value;
            if (code != ES_NONE) {
                (void)refuse(block, error, code, k);
                block->param[k] = before;
            }
            return code == ES_NONE;
        }
    }
    return capi_refuse_with(error, ES_UNKNOWN, "block_param", param, value, block->kind->name);
}

bool es_block_start(es_block_t *block, es_error_t *error)
{
    if (block == NULL) {
        return capi_refuse(error, ES_NO_OBJECT, "block", "", 0.0);
    }
    stop(block);
    const capi_block_t *const kind = block->kind;
    const int                 cells = (kind->cells != NULL) ? kind->cells(block->param) : 0;
    block->self = calloc(1, kind->size);
    block->memory = calloc((size_t)cells + 1U, sizeof block->memory[0]);
    if ((block->self == NULL) || (block->memory == NULL)) {
        stop(block);
        return capi_refuse(error, ES_NO_MEMORY, "block", kind->name, cells);
    }
    const int refused = kind->start(block->self, block->param, block->memory, cells);
    if (refused != CAPI_STARTED) {
        stop(block);
        return refuse(block, error, ES_BREAKS_RULE, refused);
    }
    block->started = true;
    return true;
}

bool es_block_do(es_block_t *block, int action, const double *in, double *out)
{
    if ((block == NULL) || !block->started || (action < 0) || (action >= actions_of(block->kind))) {
        return false;
    }
    const capi_action_t *const a = &block->kind->action[action];
    if (((in == NULL) && (a->inputs != NULL)) || ((out == NULL) && (a->outputs != NULL))) {
        return false;
    }
    a->run(block->self, in, out);
    return true;
}

int es_block_table(const es_block_t *block, double *out, int room)
{
    if ((block == NULL) || !block->started || (block->kind->table == NULL)) {
        return 0;
    }
    return block->kind->table(block->self, out, (out != NULL) ? room : 0);
}
