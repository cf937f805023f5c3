/* Calls of the firmware from outside, each taken down with its arguments, so that a replay can make the same ones. */
#include <string.h>

#include "sim_host/capi/sim.h"

#define BOARD_NAME "simulator"

static trace_t *enter(es_sim_t *s, trace_event_t entry)
{
    trace_enter(s->board.trace, entry);
    return s->board.trace;
}

static void leave(es_sim_t *s) { trace_leave(s->board.trace); }

static void put_params(trace_t *t, const drive_params_t *params)
{
    for (uint16_t i = 0; (t != NULL) && (i < (uint16_t)PARAM_COUNT); i++) {
        trace_put_number(t, TRACE_CH_VALUE, params_get(params, i));
    }
}

void capi_call_init(es_sim_t *s)
{
    put_params(enter(s, TRACE_drive_init), &s->params);
    drive_init(&s->drive, &s->params);
    leave(s);
}

void capi_call_services(es_sim_t *s)
{
    const hal_reset_t      cause = s->board.reset_cause; /* as the program of a board asks for it, before the services start */
    const services_setup_t setup = {
        &s->drive, &s->params, BOARD_NAME, s->capture, s->black_box, CAPI_CAPTURE_VALUES, CAPI_BLACK_BOX_VALUES, cause};
    trace_t *const t = enter(s, TRACE_services_start);
    put_params(t, &s->params);
    if (t != NULL) {
        trace_put(t, TRACE_ORDER, (uint8_t)cause);
        trace_put_count(t, TRACE_CH_COUNT, CAPI_CAPTURE_VALUES);
        trace_put_count(t, TRACE_CH_COUNT, CAPI_BLACK_BOX_VALUES);
        for (size_t i = 0; i < sizeof BOARD_NAME; i++) {
            trace_put(t, TRACE_OCTETS, (uint8_t)BOARD_NAME[i]);
        }
    }
    services_start(&s->services, &setup);
    leave(s);
}

void capi_call_start(es_sim_t *s)
{
    (void)enter(s, TRACE_drive_start);
    drive_start(&s->drive);
    leave(s);
}

void capi_call_background(es_sim_t *s)
{
    (void)enter(s, TRACE_background);
    drive_background(&s->drive);
    leave(s);
}

void capi_call_home(es_sim_t *s)
{
    (void)enter(s, TRACE_drive_home);
    drive_home(&s->drive);
    leave(s);
}

void capi_call_command(es_sim_t *s, const drive_command_t *c)
{
    trace_t *const t = enter(s, TRACE_drive_command);
    if (t != NULL) {
        trace_put(t, TRACE_ORDER, (uint8_t)c->mode);
        trace_put_number(t, TRACE_CH_VALUE, c->speed_ref_rad_s);
        trace_put_number(t, TRACE_CH_VALUE, c->id_ref_a);
        trace_put_number(t, TRACE_CH_VALUE, c->iq_ref_a);
        trace_put_count(t, TRACE_CH_COUNT, (uint32_t)c->target_turns);
        trace_put_number(t, TRACE_CH_VALUE, c->target_rad);
    }
    (void)drive_command(&s->drive, c);
    leave(s);
}

bool capi_call_tune(es_sim_t *s, uint16_t param, const drive_params_t *params, uint16_t *culprit)
{
    trace_t *const t = enter(s, TRACE_drive_tune);
    if (t != NULL) {
        trace_put_count(t, TRACE_CH_COUNT, param);
        trace_put_number(t, TRACE_CH_VALUE, params_get(params, param));
    }
    const bool done = drive_tune(&s->drive, params, culprit);
    leave(s);
    return done;
}

bool capi_call_memory_write(es_sim_t *s, const float *amps, uint16_t cells)
{
    trace_t *const t = enter(s, TRACE_memory_write);
    if (t != NULL) {
        trace_put_count(t, TRACE_CH_COUNT, cells);
        for (uint16_t i = 0; i < cells; i++) {
            trace_put_number(t, TRACE_CH_VALUE, amps[i]);
        }
    }
    const bool done = drive_memory_write(&s->drive, amps, cells);
    leave(s);
    return done;
}

bool capi_call_memory_clear(es_sim_t *s)
{
    (void)enter(s, TRACE_memory_clear);
    const bool done = drive_memory_clear(&s->drive);
    leave(s);
    return done;
}
