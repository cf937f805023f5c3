/* The simulated drive: firmware and virtual board, period by period. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "firmware/app/drive.h"
#include "firmware/app/telemetry.h"
#include "firmware/services/schema.h"
#include "firmware/services/services.h"
#include "hal/hal_reset.h"
#include "sim_host/board/board.h"
#include "sim_host/capi/evenspin_capi.h"

#define SIGNALS_MAX 64
#define PI 3.14159265358979323846
#define EFFECTS_MAX SIM_EFFECTS_MAX
#define MAIN_LOOP_PERIODS 10U /* one pass of the main loop per millisecond */
#define CAPTURE_VALUES 6140   /* as on the chip, see linker/f28379d_flash.cmd */
#define BLACK_BOX_VALUES 2048

enum {
#define INPUT(name, unit, def, lo, hi, doc) INPUT_##name,
#include "sim_host/capi/inputs.def"
#undef INPUT
    INPUT_COUNT
};

static const sim_field_t INPUTS[INPUT_COUNT] = {
#define INPUT(name, unit, def, lo, hi, doc) {#name, unit, doc, lo, hi, def, SIM_REAL},
#include "sim_host/capi/inputs.def"
#undef INPUT
};

/* A value over time. */
typedef struct {
    double *t_s, *value;
    int     count, at;
    bool    linear;
    double  now;
} track_t;

struct es_sim {
    sim_board_t     board;
    drive_t         drive;
    sim_model_t     model;
    drive_params_t  params;
    double          effect[EFFECTS_MAX][SIM_EFFECT_PARAMS];
    uint64_t        seed;
    track_t         input[INPUT_COUNT];
    bool            started;
    drive_command_t sent;
    bool            home_asked;
    double         *table; /* memory of the angle observer that waits for the start, and its cells */
    int             table_cells;
    double          inputs_until; /* time at which an input changes next */
    int             signal[SIGNALS_MAX];
    int             signal_count;
    bool            linked; /* the services run */
    services_t      services;
    float           capture[CAPTURE_VALUES], black_box[BLACK_BOX_VALUES];
    bool            storage_kept; /* over the next start */
    char            error[256];
};

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

static double read_signal(const es_sim_t *s, int index)
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

/* ---- lists --------------------------------------------------------------------------------------------------------------- */

static bool fill(es_field_t *out, const char *name, const char *unit, const char *kind, const char *doc, const char *choices,
                 double min, double max, double value)
{
    if (out == NULL) {
        return false;
    }
    const es_field_t f = {name, unit, kind, doc, choices, min, max, value, false};
    *out = f;
    return true;
}

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
    if ((p == NULL) || !fill(out, p->name, p->unit, KIND[p->kind], p->doc, p->choices, p->min, p->max, p->def)) {
        return false;
    }
    out->at_rest = params_only_at_rest((uint16_t)index);
    return true;
}

static const signal_info_t *signal_at(int index)
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
    const signal_info_t *const s = signal_at(index);
    return (s != NULL) && fill(out, s->name, s->unit, "float", s->doc, "", -INFINITY, INFINITY, 0.0);
}

int  es_model_count(void) { return sim_model_count(); }
bool es_model_info(int index, es_field_t *out)
{
    const sim_field_t *const f = sim_model_info(index);
    return (f != NULL) && fill(out, f->name, f->unit, kind_name(f->kind), f->doc, "", f->min, f->max, f->def);
}

int  es_input_count(void) { return INPUT_COUNT; }
bool es_input_info(int index, es_field_t *out)
{
    if ((index < 0) || (index >= (int)INPUT_COUNT)) {
        return false;
    }
    const sim_field_t *const f = &INPUTS[index];
    return fill(out, f->name, f->unit, "float", f->doc, "", f->min, f->max, f->def);
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
    return fill(out, p->name, p->unit, "float", p->doc, "", p->min, p->max, p->off);
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
    return fill(out, schema_name(SCHEMA_COMMANDS, (uint16_t)index), "", "", schema_text(SCHEMA_COMMANDS, (uint16_t)index, 0U), "",
                0.0, 0.0, 0.0);
}

uint32_t es_schema_hash(void) { return schema_hash(); }

/* ---- setting up --------------------------------------------------------------------------------------------------------------- */

static bool refuse(es_sim_t *s, const char *what, double value, const char *why)
{
    (void)snprintf(s->error, sizeof s->error, "%s = %g: %s", (what != NULL) ? what : "(no name)", value, why);
    return false;
}

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
    (void)snprintf(s->error, sizeof s->error,
                   "effects.%s and effects.%s are both on, and there is one shaft: leave one of them out",
                   sim_effects[first]->name, sim_effects[second]->name);
    return false;
}

static bool refuse_range(es_sim_t *s, const char *what, double value, double min, double max, const char *unit, bool whole)
{
    char why[120];
    (void)snprintf(why, sizeof why, "must be %swithin %g .. %g%s%s", whole ? "a whole number " : "", min, max,
                   (unit[0] != '\0') ? " " : "", unit);
    return refuse(s, what, value, why);
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
    for (int i = 0; i < (int)INPUT_COUNT; i++) {
        s->input[i].now = INPUTS[i].def;
    }
    s->seed = 1;
    return s;
}

void es_sim_free(es_sim_t *sim)
{
    if (sim == NULL) {
        return;
    }
    for (int i = 0; i < (int)INPUT_COUNT; i++) {
        free(sim->input[i].t_s);
        free(sim->input[i].value);
    }
    free(sim->table);
    free(sim);
}

const char *es_sim_error(const es_sim_t *sim) { return (sim != NULL) ? sim->error : "no simulation object"; }

bool es_sim_set_model(es_sim_t *sim, const char *name, double value)
{
    if ((sim == NULL) || (name == NULL)) {
        return false;
    }
    for (int i = 0; i < sim_model_count(); i++) {
        const sim_field_t *const f = sim_model_info(i);
        if (strcmp(name, f->name) == 0) {
            if (!sim_field_accepts(f, value)) {
                return refuse_range(sim, name, value, f->min, f->max, f->unit, f->kind != SIM_REAL);
            }
            *sim_model_at(&sim->model, i) = value;
            return true;
        }
    }
    return refuse(sim, name, value, "no such model field");
}

static int param_index(const char *name)
{
    int i = 0;
    while ((i < (int)PARAM_COUNT) && (strcmp(name, params_info((uint16_t)i)->name) != 0)) {
        i++;
    }
    return i;
}

static bool set_param(es_sim_t *sim, drive_params_t *p, const char *name, double value)
{
    const int i = param_index(name);
    if (i == (int)PARAM_COUNT) {
        return refuse(sim, name, value, "no such drive parameter");
    }
    if (!params_set(p, (uint16_t)i, (float)value)) {
        const param_info_t *const f = params_info((uint16_t)i);
        return refuse_range(sim, name, value, (double)f->min, (double)f->max, f->unit, f->kind != PARAM_KIND_FLOAT);
    }
    return true;
}

bool es_sim_set_param(es_sim_t *sim, const char *name, double value)
{
    return (sim != NULL) && (name != NULL) && set_param(sim, &sim->params, name, value);
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
                    return refuse_range(sim, param, value, p->min, p->max, p->unit, false);
                }
                sim->effect[e][k] = value;
                return true;
            }
        }
        return refuse(sim, param, value, "no such parameter of this effect");
    }
    return refuse(sim, effect, value, "no such effect");
}

bool es_sim_set_seed(es_sim_t *sim, uint64_t seed)
{
    if (sim == NULL) {
        return false;
    }
    sim->seed = seed;
    return true;
}

bool es_sim_set_input(es_sim_t *sim, const char *name, const double *t_s, const double *value, int count, bool linear)
{
    if ((sim == NULL) || (name == NULL) || (t_s == NULL) || (value == NULL)) {
        return false;
    }
    int i = 0;
    while ((i < (int)INPUT_COUNT) && (strcmp(name, INPUTS[i].name) != 0)) {
        i++;
    }
    if (i == (int)INPUT_COUNT) {
        return refuse(sim, name, (double)count, "no such input");
    }
    if (count < 1) {
        return refuse(sim, name, (double)count, "needs at least one point");
    }
    for (int k = 0; k < count; k++) {
        if (!(isfinite(t_s[k])) || ((k > 0) && !(t_s[k] > t_s[k - 1]))) {
            return refuse(sim, name, t_s[k], "times must be finite and rise");
        }
        if (!((value[k] >= INPUTS[i].min) && (value[k] <= INPUTS[i].max))) {
            return refuse_range(sim, name, value[k], INPUTS[i].min, INPUTS[i].max, INPUTS[i].unit, false);
        }
    }
    const size_t bytes = (size_t)count * sizeof(double);
    double      *t = malloc(bytes);
    double      *v = malloc(bytes);
    if ((t == NULL) || (v == NULL)) {
        free(t);
        free(v);
        return refuse(sim, name, (double)count, "not enough memory");
    }
    memcpy(t, t_s, bytes);
    memcpy(v, value, bytes);
    track_t *const track = &sim->input[i];
    free(track->t_s);
    free(track->value);
    const track_t made = {t, v, count, 0, linear, v[0]};
    *track = made;
    sim->inputs_until = -INFINITY; /* acts in the next period when the simulation runs already */
    return true;
}

/* A step at 0.1 s acts in the period that starts at 0.1 s, however that was rounded. */
#define GRACE_S 0.5e-6

/* ---- running -------------------------------------------------------------------------------------------------------------------- */

static double track_value(track_t *track, double t)
{
    if (track->count == 0) {
        return track->now;
    }
    const double grace = t + GRACE_S;
    while ((track->at + 1 < track->count) && (track->t_s[track->at + 1] <= grace)) {
        track->at++;
    }
    const int i = track->at;
    if (!track->linear || (i + 1 >= track->count) || (t <= track->t_s[i])) {
        return track->value[i];
    }
    return track->value[i] + (track->value[i + 1] - track->value[i]) * (t - track->t_s[i]) / (track->t_s[i + 1] - track->t_s[i]);
}

static void apply_inputs(es_sim_t *s)
{
    const double t = (double)s->board.periods * s->board.plant.period_s;
    double       now[INPUT_COUNT];
    if (t + GRACE_S < s->inputs_until) {
        return;
    }
    s->inputs_until = INFINITY;
    for (int i = 0; i < (int)INPUT_COUNT; i++) {
        track_t *const track = &s->input[i];
        now[i] = track_value(track, t);
        const bool ends = track->at + 1 >= track->count;
        if (!ends) {
            s->inputs_until = fmin(s->inputs_until, track->linear ? t : track->t_s[track->at + 1]);
        }
    }
    sim_outside_t *const o = &s->board.plant.outside;
    o->load_torque_nm = now[INPUT_load_torque_nm];
    o->load_brake_nm = now[INPUT_load_brake_nm];
    o->dc_link_v = (s->input[INPUT_dc_link_v].count > 0) ? now[INPUT_dc_link_v] : s->board.plant.model.dc_link_v;

    sim_disturbance_t *const d = &s->board.disturbance;
    d->sample_lost = now[INPUT_sample_lost] >= 0.5;
    d->current_nan = now[INPUT_current_nan] >= 0.5;
    d->encoder_stuck = now[INPUT_encoder_stuck] >= 0.5;
    d->encoder_slip_rad = now[INPUT_encoder_slip_rad];
    d->encoder_error = now[INPUT_encoder_error] >= 0.5;
    d->inverter_fault = (hal_inverter_fault_t)(int)now[INPUT_inverter_fault];
    s->board.load.current_cyc = (uint32_t)now[INPUT_isr_load_cyc];
    s->board.load.speed_cyc = (uint32_t)now[INPUT_speed_isr_load_cyc];

    const double          turns = trunc(now[INPUT_position_ref_rad] / (2.0 * PI));
    const drive_command_t c = {(drive_mode_t)(int)(now[INPUT_control_mode] + 0.5),
                               (float)now[INPUT_speed_ref_rad_s],
                               (float)now[INPUT_id_ref_a],
                               (float)now[INPUT_iq_ref_a],
                               (int32_t)turns,
                               (float)(now[INPUT_position_ref_rad] - turns * 2.0 * PI)};
    if ((now[INPUT_home] >= 0.5) && !s->home_asked) {
        drive_home(&s->drive);
    }
    s->home_asked = now[INPUT_home] >= 0.5;
    if ((c.mode != s->sent.mode) || (c.speed_ref_rad_s != s->sent.speed_ref_rad_s) || (c.id_ref_a != s->sent.id_ref_a) ||
        (c.iq_ref_a != s->sent.iq_ref_a) || (c.target_turns != s->sent.target_turns) || (c.target_rad != s->sent.target_rad) ||
        (s->board.periods == 0U)) {
        (void)drive_command(&s->drive, &c);
        s->sent = c;
    }
}

static bool give_table(es_sim_t *sim)
{
    float amps[DRIVE_OBSERVER_CAPACITY];
    for (int i = 0; i < sim->table_cells; i++) {
        amps[i] = (float)sim->table[i];
    }
    return drive_memory_write(&sim->drive, amps, (uint16_t)sim->table_cells)
               ? true
               : refuse(sim, "memory", (double)sim->table_cells,
                        "needs method = aro, aro_cells values within +-observer_limit_a, and a drive that does not run");
}

/* A limit of the model's board; without one the board was made for the set that the drive starts with. */
static float board_limit(const es_sim_t *s, double of_model, uint16_t param)
{
    const float starts = params_get(&s->params, param);
    const float usual = params_info(param)->def;
    return (of_model > 0.0) ? (float)of_model : ((starts > usual) ? starts : usual);
}

static void set_board_limits(es_sim_t *s)
{
    const hal_limits_t limits = {board_limit(s, s->model.board_current_a, PARAM_over_current_a),
                                 board_limit(s, s->model.board_dc_link_v, PARAM_over_voltage_v),
                                 board_limit(s, s->model.board_speed_rad_s, PARAM_over_speed_rad_s),
                                 board_limit(s, 0.0, PARAM_offset_limit_a)};
    s->board.limits = limits;
}

/* Why the drive does not take parameter @p culprit of @p p. */
static bool refuse_param(es_sim_t *s, const drive_params_t *p, uint16_t culprit)
{
    const param_info_t *const f = params_info(culprit);
    const float               most = drive_board_max(culprit);
    const double              value = (double)params_get(p, culprit);
    float                     low = 0.0f;
    float                     high = 0.0f;
    char                      why[160];
    drive_relation(p, culprit, &low, &high);
    if ((float)value > most) {
        (void)snprintf(why, sizeof why, "the board allows at most %g%s%s", (double)most, (f->unit[0] != '\0') ? " " : "",
                       f->unit);
    } else if (((float)value < low) || ((float)value >= high)) {
        (void)snprintf(why, sizeof why, "the other parameters leave %g .. %g%s%s; see docs/parameters.md", (double)low,
                       (double)high, (f->unit[0] != '\0') ? " " : "", f->unit);
    } else {
        (void)snprintf(why, sizeof why, "does not fit the other parameters; see docs/parameters.md");
    }
    return refuse(s, f->name, value, why);
}

/* A speed reference that would only trip the drive. */
static bool reference_fits(es_sim_t *s)
{
    bool speed_mode = (s->input[INPUT_control_mode].count == 0) && ((int)INPUTS[INPUT_control_mode].def == (int)DRIVE_MODE_SPEED);
    for (int k = 0; k < s->input[INPUT_control_mode].count; k++) {
        speed_mode = speed_mode || ((int)(s->input[INPUT_control_mode].value[k] + 0.5) == (int)DRIVE_MODE_SPEED);
    }
    const track_t *const ref = &s->input[INPUT_speed_ref_rad_s];
    const double         limit = (double)s->params.over_speed_rad_s;
    for (int k = 0; speed_mode && (k < ref->count); k++) {
        if (fabs(ref->value[k]) > limit) {
            char why[80];
            (void)snprintf(why, sizeof why, "must be within over_speed_rad_s, +-%g rad/s", limit);
            return refuse(s, "speed_ref_rad_s", ref->value[k], why);
        }
    }
    return true;
}

bool es_sim_start(es_sim_t *sim)
{
    if (sim == NULL) {
        return false;
    }
    sim->started = false;
    if (sim->model.pwm_hz != (double)DRIVE_PWM_HZ) {
        return refuse(sim, "pwm_hz", sim->model.pwm_hz, "the firmware runs at 10000 Hz");
    }
    sim_board_select(&sim->board);
    const double edges = (sim->model.counts_per_rev > 0.0) ? sim->model.counts_per_rev : (double)sim->params.encoder_counts;
    const char  *bad =
        sim_plant_start(&sim->board.plant, &sim->model, (const double (*)[SIM_EFFECT_PARAMS])sim->effect, edges, sim->seed);
    if (bad != NULL) {
        const int effect = effect_at(bad);
        return (effect < sim_effect_total) ? refuse_second_shaft(sim, effect) : refuse(sim, bad, 0.0, "does not fit the plant");
    }
    static _Thread_local uint16_t storage[SIM_STORAGE_PAGES][SIM_STORAGE_WORDS];
    memcpy(storage, sim->board.storage, sizeof storage);
    sim_board_start(&sim->board);
    set_board_limits(sim);
    if (sim->storage_kept) {
        memcpy(sim->board.storage, storage, sizeof storage);
    }
    sim->inputs_until = -INFINITY;
    for (int i = 0; i < (int)INPUT_COUNT; i++) {
        sim->input[i].at = 0;
    }
    if (sim->linked) {
        const services_setup_t setup = {&sim->drive,    &sim->params,   "simulator",      sim->capture,
                                        sim->black_box, CAPTURE_VALUES, BLACK_BOX_VALUES, hal_reset_cause()};
        services_start(&sim->services, &setup);
    } else {
        drive_init(&sim->drive, &sim->params);
        if (sim->params.auto_run !=
            0U) { /* no link, no client whose silence could be dangerous: the simulation itself starts it */
            drive_start(&sim->drive);
        }
    }
    if (sim->drive.fault == FAULT_configuration) {
        return refuse_param(sim, &sim->params, sim->drive.fault_detail);
    }
    if (!reference_fits(sim)) {
        return false;
    }
    if ((sim->table != NULL) && !give_table(sim)) {
        return false;
    }
    for (int pass = 0; pass < 3; pass++) { /* init -> ready -> run before the first sample, when nothing else is asked for */
        drive_background(&sim->drive);
    }
    sim->started = true;
    return true;
}

static int find_signal(const char *name)
{
    for (int i = 0; i < es_signal_count(); i++) {
        if (strcmp(name, signal_at(i)->name) == 0) {
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
    if ((count < 1) || (count > SIGNALS_MAX)) {
        return refuse_range(sim, "count", (double)count, 1, SIGNALS_MAX, "", true);
    }
    int chosen[SIGNALS_MAX];
    for (int i = 0; i < count; i++) {
        chosen[i] = (signals[i] != NULL) ? find_signal(signals[i]) : -1;
        if (chosen[i] < 0) {
            return refuse(sim, signals[i], (double)i, "no such signal");
        }
    }
    memcpy(sim->signal, chosen, sizeof chosen);
    sim->signal_count = count;
    return true;
}

static void interrupts(es_sim_t *s)
{
    drive_current_isr(&s->drive);
    if (sim_board_speed_due(&s->board)) {
        sim_board_speed_begin(&s->board);
        drive_speed_isr(&s->drive);
        sim_board_speed_end(&s->board);
    }
    if (s->linked) {
        services_sample(&s->services);
    }
    if ((s->board.periods % MAIN_LOOP_PERIODS) == 0U) {
        drive_background(&s->drive);
    }
    if (s->linked) {
        services_pass(&s->services);
    }
}

int64_t es_sim_run(es_sim_t *sim, int64_t periods, int decimate, double *out, int64_t capacity_rows)
{
    if ((sim == NULL) || !sim->started || (decimate < 1)) {
        return 0;
    }
    sim_board_select(&sim->board);
    int64_t rows = 0;
    for (int64_t k = 0; k < periods; k++) {
        const bool due = (out != NULL) && ((sim->board.periods % (uint64_t)decimate) == 0U);
        if (due && (rows >= capacity_rows)) {
            break;
        }
        apply_inputs(sim);
        interrupts(sim);
        if (due) {
            for (int i = 0; i < sim->signal_count; i++) {
                out[rows * sim->signal_count + i] = read_signal(sim, sim->signal[i]);
            }
            rows++;
        }
        sim_board_period(&sim->board);
    }
    return rows;
}

double es_sim_time(const es_sim_t *sim) { return (sim != NULL) ? (double)sim->board.periods / (double)DRIVE_PWM_HZ : 0.0; }

double es_sim_read(const es_sim_t *sim, const char *signal)
{
    const int i = ((sim != NULL) && (signal != NULL) && sim->started) ? find_signal(signal) : -1;
    return (i >= 0) ? read_signal(sim, i) : (double)NAN;
}

bool es_sim_tune(es_sim_t *sim, const char *param, double value)
{
    if ((sim == NULL) || (param == NULL) || !sim->started) {
        return false;
    }
    drive_params_t p = *sim->drive.params;
    if (!set_param(sim, &p, param, value)) {
        return false;
    }
    sim_board_select(&sim->board);
    uint16_t culprit = PARAM_COUNT;
    if (!drive_tune(&sim->drive, &p, &culprit)) {
        if (drive_needs_rest(&sim->drive, culprit) && (params_get(&p, culprit) <= drive_board_max(culprit))) {
            return refuse(sim, params_info(culprit)->name, value, "cannot change while the drive runs; stop it first");
        }
        return (culprit < (uint16_t)PARAM_COUNT) ? refuse_param(sim, &p, culprit)
                                                 : refuse(sim, param, value, "an earlier change still waits");
    }
    return true;
}

int es_sim_memory_read(const es_sim_t *sim, double *amps, int room)
{
    float table[DRIVE_OBSERVER_CAPACITY];
    if ((sim == NULL) || !sim->started) {
        return 0;
    }
    const int cells = drive_memory_read(&sim->drive, table, (uint16_t)DRIVE_OBSERVER_CAPACITY);
    for (int i = 0; (amps != NULL) && (i < cells) && (i < room); i++) {
        amps[i] = (double)table[i];
    }
    return cells;
}

bool es_sim_memory_write(es_sim_t *sim, const double *amps, int cells)
{
    if ((sim == NULL) || (amps == NULL)) {
        return false;
    }
    if ((cells < 1) || (cells > (int)DRIVE_OBSERVER_CAPACITY)) {
        return refuse_range(sim, "cells", (double)cells, 1, (double)DRIVE_OBSERVER_CAPACITY, "", true);
    }
    double *const copy = malloc((size_t)cells * sizeof *copy);
    if (copy == NULL) {
        return refuse(sim, "cells", (double)cells, "not enough memory");
    }
    memcpy(copy, amps, (size_t)cells * sizeof *copy);
    free(sim->table);
    sim->table = copy;
    sim->table_cells = cells;
    return !sim->started || give_table(sim);
}

bool es_sim_memory_clear(es_sim_t *sim)
{
    if (sim == NULL) {
        return false;
    }
    free(sim->table);
    sim->table = NULL;
    if (sim->started && !drive_memory_clear(&sim->drive)) {
        return refuse(sim, "memory", 0.0, "cannot be cleared while the drive runs");
    }
    return true;
}

/* ---- link -------------------------------------------------------------------------------------------------------------------- */

bool es_sim_link_open(es_sim_t *sim)
{
    if (sim == NULL) {
        return false;
    }
    if (sim->started) {
        return refuse(sim, "link", 1.0, "is opened before the start");
    }
    sim->linked = true;
    return true;
}

int es_sim_link_write(es_sim_t *sim, const uint8_t *octets, int count)
{
    if ((sim == NULL) || (octets == NULL) || !sim->linked || !sim->started) {
        return 0;
    }
    sim_pipe_t *const p = &sim->board.to_drive;
    int               n = 0;
    while ((n < count) && ((p->head - p->tail) < SIM_LINK_OCTETS)) {
        p->octet[p->head++ % SIM_LINK_OCTETS] = octets[n++];
    }
    return n;
}

int es_sim_link_read(es_sim_t *sim, uint8_t *octets, int room)
{
    if ((sim == NULL) || (octets == NULL) || !sim->linked || !sim->started) {
        return 0;
    }
    sim_pipe_t *const p = &sim->board.from_drive;
    int               n = 0;
    while ((n < room) && (p->tail != p->head)) {
        octets[n++] = (uint8_t)p->octet[p->tail++ % SIM_LINK_OCTETS];
    }
    return n;
}

int es_sim_storage_read(const es_sim_t *sim, uint16_t *words, int room)
{
    const int all = SIM_STORAGE_PAGES * SIM_STORAGE_WORDS;
    if ((sim != NULL) && (words != NULL)) {
        memcpy(words, sim->board.storage, (size_t)((room < 0) ? 0 : ((room < all) ? room : all)) * sizeof words[0]);
    }
    return all;
}

bool es_sim_storage_write(es_sim_t *sim, const uint16_t *words, int count)
{
    if ((sim == NULL) || (words == NULL)) {
        return false;
    }
    if (count != SIM_STORAGE_PAGES * SIM_STORAGE_WORDS) {
        return refuse(sim, "storage", (double)count, "is written as a whole: as many words as es_sim_storage_read says");
    }
    memcpy(sim->board.storage, words, (size_t)count * sizeof words[0]);
    sim->storage_kept = true;
    return true;
}

/* ---- library -------------------------------------------------------------------------------------------------------------------- */

int         es_abi_version(void) { return 2; }
const char *es_numeric(void) { return NUM_NAME; }

double es_monotonic_s(void)
{
    struct timespec t;
    (void)clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}
