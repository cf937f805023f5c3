/* Inputs over time. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "sim_host/capi/sim.h"

#define PI 3.14159265358979323846

static const sim_field_t INPUTS[INPUT_COUNT] = {
#define INPUT(name, unit, def, lo, hi, doc) {#name, unit, doc, lo, hi, def, SIM_REAL},
#include "sim_host/capi/inputs.def"
#undef INPUT
};

void capi_inputs_default(es_sim_t *s)
{
    for (int i = 0; i < (int)INPUT_COUNT; i++) {
        s->input[i].now = INPUTS[i].def;
    }
}

void capi_inputs_rewind(es_sim_t *s)
{
    s->inputs_until = -INFINITY;
    for (int i = 0; i < (int)INPUT_COUNT; i++) {
        s->input[i].at = 0;
    }
}

void capi_inputs_free(es_sim_t *s)
{
    for (int i = 0; i < (int)INPUT_COUNT; i++) {
        free(s->input[i].t_s);
        free(s->input[i].value);
    }
}

int  es_input_count(void) { return INPUT_COUNT; }
bool es_input_info(int index, es_field_t *out)
{
    if ((index < 0) || (index >= (int)INPUT_COUNT)) {
        return false;
    }
    const sim_field_t *const f = &INPUTS[index];
    return capi_fill(out, f->name, f->unit, "float", f->doc, "", f->min, f->max, f->def);
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
        return capi_refuse(&sim->error, ES_UNKNOWN, "input", name, (double)count);
    }
    if (count < 1) {
        return capi_refuse(&sim->error, ES_TIMES, "input", name, (double)count);
    }
    for (int k = 0; k < count; k++) {
        if (!(isfinite(t_s[k])) || ((k > 0) && !(t_s[k] > t_s[k - 1]))) {
            return capi_refuse(&sim->error, ES_TIMES, "input", name, t_s[k]);
        }
        if (!((value[k] >= INPUTS[i].min) && (value[k] <= INPUTS[i].max))) {
            return capi_refuse_range(&sim->error, ES_OUT_OF_RANGE, "input", name, value[k], INPUTS[i].min, INPUTS[i].max,
                                     INPUTS[i].unit);
        }
    }
    const size_t bytes = (size_t)count * sizeof(double);
    double      *t = malloc(bytes);
    double      *v = malloc(bytes);
    if ((t == NULL) || (v == NULL)) {
        free(t);
        free(v);
        return capi_refuse(&sim->error, ES_NO_MEMORY, "input", name, (double)count);
    }
    memcpy(t, t_s, bytes);
    memcpy(v, value, bytes);
    capi_track_t *const track = &sim->input[i];
    free(track->t_s);
    free(track->value);
    const capi_track_t made = {t, v, count, 0, linear, v[0]};
    *track = made;
    sim->inputs_until = -INFINITY; /* acts in the next period when the simulation runs already */
    return true;
}

static double track_value(capi_track_t *track, double t)
{
    if (track->count == 0) {
        return track->now;
    }
    const double grace = t + CAPI_GRACE_S;
    while ((track->at + 1 < track->count) && (track->t_s[track->at + 1] <= grace)) {
        track->at++;
    }
    const int i = track->at;
    if (!track->linear || (i + 1 >= track->count) || (t <= track->t_s[i])) {
        return track->value[i];
    }
    return track->value[i] + (track->value[i + 1] - track->value[i]) * (t - track->t_s[i]) / (track->t_s[i + 1] - track->t_s[i]);
}

static double now_of(const es_sim_t *s, int input) { return s->input[input].now; }

/* All but the load, to plant, board and drive. */
static void pass_on(es_sim_t *s)
{
    sim_outside_t *const o = &s->board.plant.outside;
    o->load_brake_nm = now_of(s, INPUT_load_brake_nm);
    o->dc_link_v = (s->input[INPUT_dc_link_v].count > 0) ? now_of(s, INPUT_dc_link_v) : s->board.plant.model.dc_link_v;

    sim_disturbance_t *const d = &s->board.disturbance;
    d->sample_lost = now_of(s, INPUT_sample_lost) >= 0.5;
    d->current_nan = now_of(s, INPUT_current_nan) >= 0.5;
    for (int k = 0; k < 2; k++) {
        const int          second = k * (INPUT_current_b_gain - INPUT_current_a_gain);
        const sim_sensor_t sensor = {.stands = now_of(s, INPUT_current_a_stands + second) >= 0.5,
                                     .gain = now_of(s, INPUT_current_a_gain + second),
                                     .offset_a = now_of(s, INPUT_current_a_offset_a + second)};
        d->sensor[k] = sensor;
        d->sensor[k].faulty = sensor.stands || (sensor.gain != 1.0) || (sensor.offset_a != 0.0);
    }
    d->third_sensor = now_of(s, INPUT_third_sensor) >= 0.5;
    o->open_phase = (int)(now_of(s, INPUT_open_phase) + 0.5);
    d->encoder_stuck = now_of(s, INPUT_encoder_stuck) >= 0.5;
    d->encoder_slip_rad = now_of(s, INPUT_encoder_slip_rad);
    d->encoder_error = now_of(s, INPUT_encoder_error) >= 0.5;
    d->celsius[HAL_TEMPERATURE_MOTOR] = now_of(s, INPUT_motor_temperature_c);
    d->celsius[HAL_TEMPERATURE_BRIDGE] = now_of(s, INPUT_bridge_temperature_c);
    for (int k = 0; k < (int)HAL_TEMPERATURES; k++) {
        d->celsius_lost[k] = (int)(now_of(s, INPUT_temperature_lost) + 0.5) == (k + 1);
    }
    d->inverter_fault = (hal_inverter_fault_t)(int)now_of(s, INPUT_inverter_fault);
    d->sto = (uint16_t)(now_of(s, INPUT_sto) + 0.5);
    s->board.load.current_cyc = (uint32_t)now_of(s, INPUT_isr_load_cyc);
    s->board.load.speed_cyc = (uint32_t)now_of(s, INPUT_speed_isr_load_cyc);

    const double          turns = trunc(now_of(s, INPUT_position_ref_rad) / (2.0 * PI));
    const drive_command_t c = {(drive_mode_t)(int)(now_of(s, INPUT_control_mode) + 0.5),
                               (float)now_of(s, INPUT_speed_ref_rad_s),
                               (float)now_of(s, INPUT_id_ref_a),
                               (float)now_of(s, INPUT_iq_ref_a),
                               (int32_t)turns,
                               (float)(now_of(s, INPUT_position_ref_rad) - turns * 2.0 * PI)};
    if ((now_of(s, INPUT_home) >= 0.5) && !s->home_asked) {
        capi_call_home(s);
    }
    s->home_asked = now_of(s, INPUT_home) >= 0.5;
    if ((c.mode != s->sent.mode) || (c.speed_ref_rad_s != s->sent.speed_ref_rad_s) || (c.id_ref_a != s->sent.id_ref_a) ||
        (c.iq_ref_a != s->sent.iq_ref_a) || (c.target_turns != s->sent.target_turns) || (c.target_rad != s->sent.target_rad) ||
        (s->board.periods == 0U)) {
        capi_call_command(s, &c);
        s->sent = c;
    }
}

/* A load that is read from a log has a point every few periods, and few inputs move at all: only these are followed, and only
 * what has changed is passed on. */
void capi_inputs_apply(es_sim_t *s, double t)
{
    bool others = s->inputs_until == -INFINITY; /* at the start, or with an input that is new */
    if (others) {
        s->moving_count = INPUT_COUNT;
        for (int i = 0; i < (int)INPUT_COUNT; i++) {
            s->moving[i] = i;
        }
    }
    int still = 0;
    s->inputs_until = INFINITY;
    for (int k = 0; k < s->moving_count; k++) {
        const int           i = s->moving[k];
        capi_track_t *const track = &s->input[i];
        const double        now = track_value(track, t);
        others = others || ((now != track->now) && (i != (int)INPUT_load_torque_nm));
        track->now = now;
        if (track->at + 1 < track->count) {
            const double until = track->linear ? t : track->t_s[track->at + 1];
            s->inputs_until = (until < s->inputs_until) ? until : s->inputs_until;
            s->moving[still++] = i;
        }
    }
    s->moving_count = still;
    s->board.plant.outside.load_torque_nm = now_of(s, INPUT_load_torque_nm);
    if (others) {
        pass_on(s);
    }
}

static bool asks_for(const es_sim_t *s, drive_mode_t mode)
{
    bool found = (s->input[INPUT_control_mode].count == 0) && ((int)INPUTS[INPUT_control_mode].def == (int)mode);
    for (int k = 0; k < s->input[INPUT_control_mode].count; k++) {
        found = found || ((int)(s->input[INPUT_control_mode].value[k] + 0.5) == (int)mode);
    }
    return found;
}

/* A speed reference that would only trip the drive; position mode with what does nothing there. */
bool capi_reference_fits(es_sim_t *s)
{
    if (s->drive.setup->speed.rc_used && asks_for(s, DRIVE_MODE_POSITION)) {
        (void)capi_refuse_with(&s->error, ES_COMBINATION, "param", params_info(PARAM_method)->name, (double)s->params.method,
                               "control_mode");
        s->error.min = (double)DRIVE_MODE_POSITION;
        s->error.rule = "repetitive control corrects the speed loop, which position mode does not run; position_method = src is "
                        "the repetitive controller there";
        return false;
    }
    const bool rc = s->drive.setup->speed.rc_used;
    if ((rc || s->drive.setup->observer.used) && asks_for(s, DRIVE_MODE_TORQUE)) {
        const uint16_t by = (rc || (s->params.method >= (uint16_t)DRIVE_METHOD_DOB)) ? PARAM_method : PARAM_disturbance_observer;
        (void)capi_refuse_with(&s->error, ES_COMBINATION, "param", params_info(by)->name, (double)params_get(&s->params, by),
                               "control_mode");
        s->error.min = (double)DRIVE_MODE_TORQUE;
        s->error.rule =
            "it learns or takes away what keeps the speed from its reference, and in torque mode that is the load; use pi";
        return false;
    }
    const capi_track_t *const id = &s->input[INPUT_id_ref_a];
    for (int k = 0; s->drive.setup->reference.used && !asks_for(s, DRIVE_MODE_CURRENT) && (k < id->count); k++) {
        if (id->value[k] != 0.0) { /* mtpa or field_weakening makes it */
            (void)capi_refuse_range(&s->error, ES_LIMITED, "input", "id_ref_a", id->value[k], 0.0, 0.0, "A");
            s->error.other = params_info((s->params.mtpa != 0U) ? PARAM_mtpa : PARAM_field_weakening)->name;
            return false;
        }
    }
    const bool                speed_mode = asks_for(s, DRIVE_MODE_SPEED) || asks_for(s, DRIVE_MODE_TORQUE);
    const capi_track_t *const ref = &s->input[INPUT_speed_ref_rad_s];
    const double              limit = (double)s->params.over_speed_rad_s;
    for (int k = 0; speed_mode && (k < ref->count); k++) {
        if (fabs(ref->value[k]) > limit) {
            (void)capi_refuse_range(&s->error, ES_LIMITED, "input", "speed_ref_rad_s", ref->value[k], -limit, limit, "rad/s");
            s->error.other = params_info(PARAM_over_speed_rad_s)->name;
            return false;
        }
    }
    return true;
}
